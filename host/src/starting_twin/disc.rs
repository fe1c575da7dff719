//! The disc's own errors, with how sure they are and which of their orders a torque may be.

use realfft::RealFftPlanner;

use super::Estimate;
use crate::diagnose::disc::{learned, variances};
use crate::diagnose::effect::{Carrier, Effect, On, Site};
use crate::diagnose::lsq::{Basis, dot};
use crate::diagnose::model::{Board, Fit};
use crate::diagnose::search::{self, SURE};
use crate::diagnose::spread::Spread;

/// Orders that are looked at for a torque behind them.
const STRONGEST: usize = 8;
/// Standard errors that an order has to be from nothing to be looked at, and with a torque beside it to be told from that.
const SEEN: f64 = 5.0;
const TOLD: f64 = 3.0;

/// The disc's errors.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscFound {
    /// Error of each edge of the recording's grid, rad; their mean is 0.
    pub errors_rad: Vec<f64>,
    /// How sure they are where no torque turns with the shaft.
    pub spread: Spread,
    /// RMS of the errors.
    pub rms_rad: Estimate,
    /// Orders that a torque may be as well, with their amplitudes, rad.
    pub alike: Vec<(usize, f64)>,
}

/// What a fit says of the disc, order by order.
struct Spectrum {
    /// Error of each edge, rad; their mean is 0.
    errors_rad: Vec<f64>,
    /// Squares of waves of unit size, and how sure they are.
    powers: Vec<f64>,
    variances: Vec<f64>,
}

impl Spectrum {
    fn of(board: &Board, fit: &Fit) -> Option<Self> {
        let mut errors_rad = learned(board, &fit.model)?;
        let count = errors_rad.len() as f64;
        let mean = errors_rad.iter().sum::<f64>() / count;
        errors_rad.iter_mut().for_each(|error| *error -= mean);
        let powers = powers(&errors_rad);
        let variances = variances(board, fit)?;
        Some(Self {
            errors_rad,
            powers,
            variances,
        })
    }

    /// Amplitude of the wave of an order, rad.
    fn amplitude(&self, order: usize) -> f64 {
        (2.0 * self.powers[order] / self.errors_rad.len() as f64).sqrt()
    }

    /// The orders below that of the lines whose powers are surely not noise, strongest first.
    fn seen(&self, board: &Board) -> Vec<usize> {
        let mut orders: Vec<usize> = (1..lines(board).min(self.powers.len()))
            .filter(|&order| self.powers[order] > SEEN * SEEN * 2.0 * self.variances[order])
            .collect();
        orders.sort_by(|a, b| self.powers[*b].total_cmp(&self.powers[*a]));
        orders.truncate(STRONGEST);
        orders
    }
}

/// What repeats every turn beside a fit; none where that is not worth saying.
#[must_use]
pub fn find(board: &Board, fit: &Fit) -> Option<DiscFound> {
    let mut board = board.clone();
    let white = board.with_pattern(&board.rest(&fit.model));
    let mut pattern = board.pattern.take()?;
    let mut evidence = pattern.size_up(&board.benches, &white);
    board.pattern = Some(pattern);
    // How sure waves are is told from a fit beside a pattern of this size: of another one the difference would count as theirs.
    let fit = &board.fit(&fit.model);
    let of_disc = |term: usize| fit.model.terms[term].effect.is_of_disc();
    let numbers = fit.of.iter().filter(|(term, _)| of_disc(*term)).count();
    evidence += search::evidence(&board, fit.loss_of(&of_disc), numbers).max(0.0);
    if evidence < SURE {
        return None;
    }
    let spectrum = Spectrum::of(&board, fit)?;
    let edges = spectrum.errors_rad.len();
    // Sums over waves of unit size: each order but the last has two.
    let (mut square, mut spread) = (0.0, 0.0);
    for (order, power) in spectrum.powers.iter().enumerate().skip(1) {
        let numbers = if 2 * order == edges { 1.0 } else { 2.0 };
        let own = spectrum.variances[order];
        square += power + numbers * own;
        spread += 2.0 * numbers * own * own + 4.0 * own * power;
    }
    let count = edges as f64;
    let rms = (square / count).sqrt();
    let error = spread.sqrt() / count / (2.0 * rms);
    let mut alike: Vec<(usize, f64)> = spectrum
        .seen(&board)
        .into_iter()
        .map(|order| (order, spectrum.amplitude(order)))
        .filter(|(order, size)| *size < TOLD * error_beside_torque(&board, *order))
        .collect();
    alike.sort_by_key(|(order, _)| *order);
    Some(DiscFound {
        spread: Spread::of(&spectrum.variances, edges),
        errors_rad: spectrum.errors_rad,
        rms_rad: Estimate::normal(rms, error),
        alike,
    })
}

/// Lines of the disc: from that order on no machine makes a torque.
#[must_use]
pub fn lines(board: &Board) -> usize {
    let record = board.benches.first().map(|bench| &bench.record);
    record.map_or(0, |record| (record.edges / record.classes.max(2)) as usize)
}

/// The orders below that of the lines at which the disc seems to have most beside a fit, strongest first.
#[must_use]
pub fn strongest(board: &Board, fit: &Fit) -> Vec<usize> {
    let spectrum = Spectrum::of(board, fit);
    spectrum.map_or_else(Vec::new, |spectrum| spectrum.seen(board))
}

/// Squares of a row's waves of unit size, order by order.
fn powers(row: &[f64]) -> Vec<f64> {
    let edges = row.len();
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(edges);
    let mut spectrum = forward.make_output_vec();
    let mut row = row.to_vec();
    if forward.process(&mut row, &mut spectrum).is_err() {
        return vec![0.0; edges / 2 + 1];
    }
    let each = spectrum.iter().enumerate().map(|(order, value)| {
        let numbers = if 2 * order == edges { 1.0 } else { 2.0 };
        numbers * value.norm_sqr() / edges as f64
    });
    each.collect()
}

/// Standard error of the disc's amplitude at an order where a torque of that order is free, rad.
fn error_beside_torque(board: &Board, order: usize) -> f64 {
    let columns = |site: Site| {
        let effect = Effect::new(site, Carrier::Order(order as f64));
        let mut both = vec![Vec::new(); 2];
        for bench in &board.benches {
            for (all, own) in both.iter_mut().zip(bench.columns(&effect).iter()) {
                all.extend(bench.white(own));
            }
        }
        both
    };
    let torque = columns(Site::Torque);
    let torque: Vec<&[f64]> = torque.iter().map(Vec::as_slice).collect();
    let basis = Basis::of(&torque);
    let told = columns(Site::Disc(On::ALL)).into_iter().map(|mut column| {
        basis.clear(&mut column);
        dot(&column, &column)
    });
    let least = told.fold(f64::INFINITY, f64::min);
    least.sqrt().recip()
}
