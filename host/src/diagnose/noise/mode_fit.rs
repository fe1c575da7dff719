//! A torsional mode fitted to the spectra of all recordings: from a coarse search on, with and without noise on the far side.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::noise_fit::simplex;
use super::mode_likelihood::{cost, expected, misfit, usual};
use super::mode_scan::scan;
use super::spectral::Band;
use super::two_mass::TwoMass;

/// Twice the log likelihood ratio that a mode needs, in all recordings and in each that can show it.
pub(super) const LEAST_GAIN: f64 = 40.0;
const LEAST_EACH: f64 = 4.0;
/// Torque noise's share below which a recording shows no mode.
const SHOWS: f64 = 0.2;
/// Largest misfit of the bands around a mode, as a chi squared over its count.
pub(super) const MISFIT: f64 = 1.8;
/// How much larger for each unit of gain, where several recordings show the mode.
const LOOSER: f64 = 2e-3;
/// Twice the log likelihood ratio that noise on the far side needs.
const LEAST_SHAKEN: f64 = 30.0;
/// Standard deviation of the logit of a share, before anything is known of it.
const SHARES: f64 = 3.0;
/// Places of logarithms and the share's logit among the numbers of a fit.
const LOGIT_SHARE: usize = 2;
const LOG_TORQUE: usize = 3;
const LOG_LOAD: usize = 5;

/// A mode that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// It.
    pub masses: TwoMass,
    /// Levels of torque and stamps with it, over the filter's.
    pub levels: [f64; 2],
    /// Standard errors of frequency, damping ratio and share, and of the density of torque noise on the far side over its own.
    pub errors: [f64; 4],
    /// Twice the log likelihood ratio against no mode.
    pub gain: f64,
    /// The same of each recording.
    pub gains: Vec<f64>,
    /// Places that were searched.
    pub places: f64,
}

/// Mode and levels from numbers without bounds.
fn of_numbers(x: &[f64]) -> (TwoMass, f64, f64) {
    let share = 1.0 / (1.0 + (-x[2]).exp());
    let mode = TwoMass {
        f_hz: x[0].exp(),
        damping_ratio: x[1].exp().min(0.7),
        inertia_share: share.clamp(1e-4, 0.97),
        load: x.get(LOG_LOAD).map_or(0.0, |log| log.exp()),
    };
    (mode, x[3].exp(), x[4].exp())
}

/// The mode that makes the spectra most likely, if there is one.
pub(super) fn search(all: &[Vec<Band>]) -> Option<Mode> {
    if all.iter().all(Vec::is_empty) {
        return None;
    }
    let sum = |torque: f64, stamps: f64, mode: Option<&TwoMass>| -> f64 {
        all.iter()
            .map(|bands| cost(bands, torque, stamps, mode))
            .sum()
    };
    let none = simplex(&|x| sum(x[0].exp(), x[1].exp(), None), &[0.0, 0.0], 0.1);
    let (torque, stamps) = (none[0].exp(), none[1].exp());
    // A mode lifts the levels fitted without it, so it is looked for on top of those of most bands.
    let most = simplex(&|x| usual(all, x[0].exp(), x[1].exp()), &[0.0, 0.0], 0.2);
    let (first, rough, places) = scan(all, most[0].exp(), most[1].exp())?;
    if rough < 0.5 * LEAST_GAIN {
        return None;
    }
    let logit = (first.inertia_share / (1.0 - first.inertia_share)).ln();
    // Scaled so that a step of one is a small one in each.
    let start = [
        first.f_hz.ln(),
        first.damping_ratio.ln(),
        logit,
        most[0],
        most[1],
    ];
    let scales = [first.damping_ratio, 0.4, 0.4, 0.1, 0.1];
    let place = |x: &[f64]| -> Vec<f64> {
        let known = (0..5).map(|i| start[i] + scales[i] * x[i]);
        known.chain(x.get(LOG_LOAD).copied()).collect()
    };
    let of = |x: &[f64]| {
        let numbers = place(x);
        let (mode, torque, stamps) = of_numbers(&numbers);
        sum(torque, stamps, Some(&mode)) + unlikely(&numbers)
    };
    let near = simplex(&of, &[0.0; 5], 1.0);
    // From the other side too: a broad mode of the grid covers a narrow one.
    let narrow = simplex(&of, &[0.0, -3.0, 0.0, 0.0, 0.0], 0.7);
    let near = if of(&near) < of(&narrow) {
        near
    } else {
        narrow
    };
    let unshaken = simplex(&of, &near, 0.3);
    let shaken = shaken(&of, &unshaken);
    let best = place(if of(&unshaken) - of(&shaken) > LEAST_SHAKEN {
        &shaken
    } else {
        &unshaken
    });
    let (mode, with_torque, with_stamps) = of_numbers(&best);
    let gains: Vec<(f64, f64)> = all
        .iter()
        .map(|bands| {
            let gain = cost(bands, torque, stamps, None)
                - cost(bands, with_torque, with_stamps, Some(&mode));
            let shows = nearest(bands, mode.f_hz).map_or(0.0, |band| band.torque);
            (gain, shows)
        })
        .collect();
    let gain: f64 = gains.iter().map(|(gain, _)| gain).sum();
    let everywhere = gains
        .iter()
        .all(|(gain, shows)| *shows < SHOWS || *gain > LEAST_EACH);
    // Of a peak whose tip alone is above the stamps nobody can tell that torque noise makes it.
    let somewhere = gains.iter().any(|(_, shows)| *shows > SHOWS);
    let lowest = all
        .iter()
        .flatten()
        .map(|band| band.f_hz)
        .fold(f64::INFINITY, f64::min);
    let plausible = mode.damping_ratio < 0.3 && mode.f_hz > 1.2 * lowest;
    // One recording may show anything in a band; the same mode in two may miss what rhythms put on top.
    let several = gains
        .iter()
        .filter(|(gain, shows)| *shows > SHOWS && *gain > LEAST_GAIN)
        .count()
        > 1;
    let most = MISFIT + if several { LOOSER * gain } else { 0.0 };
    let fits = misfit(all, &mode, with_torque, with_stamps) < most;
    if gain < LEAST_GAIN || !everywhere || !somewhere || !plausible || !fits {
        return None;
    }
    Some(Mode {
        masses: mode,
        levels: [with_torque, with_stamps],
        errors: errors(all, &best)?,
        gain,
        gains: gains.iter().map(|(gain, _)| *gain).collect(),
        places,
    })
}

/// Twice the logarithm by which a share is unlikely beforehand: a side that is shaken itself hardly says how heavy it is.
fn unlikely(numbers: &[f64]) -> f64 {
    if numbers.len() > LOG_LOAD {
        (numbers[LOGIT_SHARE] / SHARES).powi(2)
    } else {
        0.0
    }
}

/// The numbers of a mode with a far side that is shaken too, the logarithm of by how much more last.
fn shaken(of: &(dyn Fn(&[f64]) -> f64 + Sync), without: &[f64]) -> Vec<f64> {
    let first = vec![0.0; without.len()];
    let starts =
        [without, &first].map(|start| [-2.0, 1.0, 4.0].map(|log| [start, &[log]].concat()));
    let each = starts.as_flattened().par_iter();
    let tried = each.map(|start| {
        let there = simplex(of, &simplex(of, start, 1.0), 0.5);
        (of(&there), there)
    });
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(|| without.to_vec(), |best| best.1)
}

fn nearest(bands: &[Band], f_hz: f64) -> Option<&Band> {
    let at = bands.partition_point(|band| band.f_hz < f_hz);
    bands.get(at)
}

/// Standard errors of frequency, damping ratio and share, and of the far side's noise over its own, from Fisher's information of the
/// lines.
fn errors(all: &[Vec<Band>], best: &[f64]) -> Option<[f64; 4]> {
    const STEP: f64 = 1e-4;
    let at = |x: &[f64], band: &Band| {
        let (mode, torque, stamps) = of_numbers(x);
        expected(band, torque, stamps, Some(&mode)).ln()
    };
    let count = best.len();
    let mut information = DMatrix::<f64>::zeros(count, count);
    for band in all.iter().flatten() {
        let here = at(best, band);
        let slopes = DVector::from_fn(count, |i, _| {
            let mut there = best.to_vec();
            there[i] += STEP;
            (at(&there, band) - here) / STEP
        });
        information += band.lines * &slopes * slopes.transpose();
    }
    if count > LOG_LOAD {
        information[(LOGIT_SHARE, LOGIT_SHARE)] += SHARES.powi(-2);
    }
    let covariance = information.try_inverse()?;
    let (mode, ..) = of_numbers(best);
    let share = mode.inertia_share;
    let scales = [mode.f_hz, mode.damping_ratio, share * (1.0 - share)];
    let error = |i: usize| covariance[(i, i)].max(0.0).sqrt();
    // The density is a product with the level.
    let of_load = if count > LOG_LOAD {
        let both = covariance[(LOG_LOAD, LOG_LOAD)] + covariance[(LOG_TORQUE, LOG_TORQUE)];
        (both + 2.0 * covariance[(LOG_LOAD, LOG_TORQUE)])
            .max(0.0)
            .sqrt()
    } else {
        0.0
    };
    let [f, damping, share] = scales;
    let errors = [f * error(0), damping * error(1), share * error(2), of_load];
    errors
        .iter()
        .all(|error| error.is_finite())
        .then_some(errors)
}
