//! `torsional_resonance`: a lightly damped mode that torque noise excites.
//!
//! The spectrum of the innovations along time is a (1 - t) + g t |Z0 / Z|^2, with t the share that torque noise has in what the
//! filter expects, a and g the levels of stamps and torque, and |Z0 / Z|^2 of [`super::two_mass`], with what shakes the far side in it
//! where that is worth its number. Its lines are exponential, so
//! their likelihood is Whittle's, -sum(ln S + P / S) (Whittle, Arkiv foer Matematik 2, 1953). The mode stands at the same Hz in
//! every recording; tones, which stand alone, are left out before.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::board::Board;
use super::super::kalman::ShaftNoise;
use super::super::noise_fit::simplex;
use super::mode_scan::scan;
use super::odds::{anywhere, normal_above};
use super::rings::{rings, stretches_of};
use super::spectral::{Band, SEEN, bands, held_s, stretches};
use super::two_mass::TwoMass;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;

/// Twice the log likelihood ratio that a mode needs, in all recordings and in each that can show it.
const LEAST_GAIN: f64 = 40.0;
const LEAST_EACH: f64 = 4.0;
/// Torque noise's share below which a recording shows no mode.
const SHOWS: f64 = 0.2;
/// Largest misfit of the bands around a mode, as a chi squared over its count.
const MISFIT: f64 = 1.8;
/// How much larger for each unit of gain, where several recordings show the mode.
const LOOSER: f64 = 2e-3;

/// Twice the log likelihood ratio that noise on the far side needs.
const LEAST_SHAKEN: f64 = 30.0;
/// The twin's name of its density.
pub const LOAD: &str = "load_psd_n2_m2_s";
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

impl Mode {
    /// As a finding.
    #[must_use]
    pub fn finding(&self, board: &Board) -> NoiseFinding {
        let masses = self.masses;
        let psd = self.load_psd(board);
        let names = ["f_hz", "damping_ratio", "inertia_share", LOAD];
        let values = [masses.f_hz, masses.damping_ratio, masses.inertia_share, psd];
        let [.., of_load] = self.errors;
        let errors = self.errors.into_iter().take(3).chain([psd * of_load]);
        let parameters = names.into_iter().zip(values).zip(errors);
        let count = if psd > 0.0 { 4 } else { 3 };
        let behind = if psd > 0.0 {
            ", which is shaken too"
        } else {
            ""
        };
        NoiseFinding {
            mechanism: Mechanism::TorsionalResonance,
            parameters: parameters
                .take(count)
                .map(|((name, value), standard_error)| NoiseParameter {
                    name,
                    value,
                    standard_error,
                })
                .collect(),
            delta_bic: self.gain - count as f64 * (board.edges() as f64).ln(),
            p_value: anywhere(normal_above(self.gain.sqrt()), self.places),
            text: format!(
                "torque noise excites a mode at {:.4} Hz, damping ratio {:.3}, with {:.0} % of the inertia behind the spring{behind}",
                masses.f_hz,
                masses.damping_ratio,
                100.0 * masses.inertia_share
            ),
            frequencies_hz: vec![masses.f_hz],
            times_s: Vec::new(),
            edge_classes: Vec::new(),
            runner_up: None,
            busy: None,
        }
    }
}

impl Mode {
    /// Density of the torque noise on the far side, N^2 m^2 s, in the first recording.
    fn load_psd(&self, board: &Board) -> f64 {
        let bench = &board.benches[0];
        let near = self.levels[0] * (bench.noise.acceleration + bench.noise.load);
        self.masses.load * near * bench.law.inertia.powi(2)
    }
}

/// Looks for a mode in what a model leaves, white, that rings all the time.
#[must_use]
pub fn find(board: &Board, left: &[Vec<f64>]) -> Option<Mode> {
    if board.benches.iter().any(|bench| bench.law.spring.is_some()) {
        let all = all_bands(board, left);
        if off(&all, [0.0, f64::INFINITY], &|_| 1.0) < MISFIT {
            return None;
        }
        // Not the one that the twins have: what there is instead shows on a stiff shaft.
        let (board, left) = stiff(board, left);
        return find(&board, &left);
    }
    let mode = search(&all_bands(board, left))?;
    let each = board.benches.iter().zip(left);
    let shown = each.zip(&mode.gains).all(|((bench, white), gain)| {
        if *gain < LEAST_GAIN {
            return true;
        }
        let count = stretches_of(held_s(bench), &mode.masses);
        rings(&stretches(bench, white, count), &mode, *gain)
    });
    shown.then_some(mode)
}

/// The spectrum of whole recordings, in bands.
fn all_bands(board: &Board, left: &[Vec<f64>]) -> Vec<Vec<Band>> {
    let each = board.benches.iter().zip(left);
    each.map(|(bench, white)| bands(bench, white)).collect()
}

/// What is left as if no twin had a spring.
fn stiff(board: &Board, left: &[Vec<f64>]) -> (Board, Vec<Vec<f64>>) {
    let mut stiff = board.clone();
    stiff.forget();
    let each = stiff.benches.iter_mut().zip(left);
    let left = each.map(|(bench, left)| {
        let mut angles = left.clone();
        bench.whitener().restore(&mut angles);
        bench.law.spring = None;
        let readings = &mut bench.seen.readings;
        readings.iter_mut().for_each(|one| one.leap.spring = None);
        bench.set_noise(ShaftNoise {
            acceleration: bench.noise.acceleration + bench.noise.load,
            load: 0.0,
            ..bench.noise
        });
        bench.whitened(angles)
    });
    let left = left.collect();
    (stiff, left)
}

/// The spectrum in a band: levels of torque and stamps, with or without a mode.
fn expected(band: &Band, torque: f64, stamps: f64, mode: Option<&TwoMass>) -> f64 {
    let gain = mode.map_or(1.0, |mode| {
        let at = |f_hz: f64| mode.gain(f_hz, band.damping);
        match band.line_hz {
            Some(line_hz) => {
                let [side, middle] = SEEN;
                middle * at(band.f_hz) + side * (at(band.f_hz - line_hz) + at(band.f_hz + line_hz))
            }
            None => at(band.f_hz),
        }
    });
    stamps * (1.0 - band.torque) + torque * band.torque * gain
}

pub(super) fn cost(bands: &[Band], torque: f64, stamps: f64, mode: Option<&TwoMass>) -> f64 {
    let each = bands.iter().map(|band| {
        let expected = expected(band, torque, stamps, mode);
        2.0 * band.lines * (expected.ln() + band.power / expected)
    });
    each.sum()
}

/// The same for levels that few loud bands do not lift.
fn usual(all: &[Vec<Band>], torque: f64, stamps: f64) -> f64 {
    const LOUD: f64 = 2.0;
    let each = all.iter().flatten().map(|band| {
        let expected = expected(band, torque, stamps, None);
        let ratio = band.power / expected;
        let size = if ratio < LOUD {
            ratio
        } else {
            LOUD * (1.0 + (ratio / LOUD).ln())
        };
        2.0 * band.lines * (expected.ln() + size)
    });
    each.sum()
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

fn search(all: &[Vec<Band>]) -> Option<Mode> {
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
    let stiff = simplex(&of, &near, 0.3);
    let shaken = shaken(&of, &stiff);
    let best = place(if of(&stiff) - of(&shaken) > LEAST_SHAKEN {
        &shaken
    } else {
        &stiff
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

/// Chi squared of what a mode leaves in wider bands around it, over their count.
pub(super) fn misfit(all: &[Vec<Band>], mode: &TwoMass, torque: f64, stamps: f64) -> f64 {
    let around = [0.6 * mode.f_hz, 1.6 * mode.f_hz];
    off(all, around, &|band| {
        expected(band, torque, stamps, Some(mode))
    })
}

/// Chi squared of bands from here to there against what is expected, over their count.
fn off(all: &[Vec<Band>], [from_hz, until_hz]: [f64; 2], expected: &dyn Fn(&Band) -> f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for bands in all {
        let from = bands.partition_point(|band| band.f_hz < from_hz);
        let until = bands.partition_point(|band| band.f_hz < until_hz);
        for wide in bands[from..until.max(from)].chunks(12) {
            let (mut ratio, mut lines) = (0.0, 0.0);
            for band in wide {
                ratio += band.lines * band.power / expected(band);
                lines += band.lines;
            }
            // Exponential lines: the mean of so many, its cube root close to normal (Wilson and Hilferty, PNAS 17, 1931).
            let ninth = 1.0 / (9.0 * lines);
            let normal = ((ratio / lines).cbrt() - 1.0 + ninth) / ninth.sqrt();
            sum += normal * normal;
            count += 1.0;
        }
    }
    // Few bands scatter more.
    sum / (count + 6.0 * count.sqrt()).max(1.0)
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
