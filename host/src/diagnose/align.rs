//! Recordings of one disc that begin at any of its lines: turned by whole lines until their discs agree.
//!
//! Without an index a recording's edges are numbered from its first one, by the angle at which the twin says that the shaft starts. The
//! disc that it shows by itself is held against another recording's, or against the one that the twin gives: the turn of most likelihood
//! is the peak of their correlation.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::bench::Bench;
use super::disc;
use super::lsq;
use super::model::{Board, Fit};
use super::search::{self, SURE};
use crate::twin::{Errors, Twin};

/// A disc as something knows it.
struct Shown {
    /// Errors of its edges, rad.
    errors: Vec<f64>,
    /// Variance of each order's wave of unit size, rad^2.
    variance: Vec<f64>,
}

impl Shown {
    /// As a recording shows it by itself.
    fn by(bench: &Bench) -> Option<Self> {
        let plain = Twin {
            errors: Errors::default(),
            local_defect: Vec::new(),
            ..bench.twin.clone()
        };
        let bench = Bench::new(bench.record.clone(), &plain, &[], &bench.noise());
        let board = Board::new(vec![bench]);
        let fit = board.fit(&search::nuisances(&board));
        let errors = disc::learned(&board, &fit.model)?;
        let pattern = board.pattern.as_ref()?;
        let variance = (0..=errors.len() / 2).map(|order| pattern.variance(order));
        Some(Self {
            variance: variance.collect(),
            errors,
        })
    }

    /// As the twin gives it; none where it gives none.
    fn given(bench: &Bench) -> Option<Self> {
        let gives = bench.disc.iter().any(|error| *error != 0.0);
        gives.then(|| Self {
            errors: bench.disc.clone(),
            variance: bench.spread.variances(bench.disc.len()),
        })
    }

    /// By how many edges another one's places have to be turned to agree with this one's; none where that is not sure.
    fn turn(&self, other: &Self, classes: usize) -> Option<usize> {
        let edges = self.errors.len();
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, back) = (
            planner.plan_fft_forward(edges),
            planner.plan_fft_inverse(edges),
        );
        let spectrum = |errors: &[f64]| {
            let mut row = errors.to_vec();
            let mut spectrum = forward.make_output_vec();
            forward.process(&mut row, &mut spectrum).ok()?;
            Some(spectrum)
        };
        let (own, others) = (spectrum(&self.errors)?, spectrum(&other.errors)?);
        // Coherence: no order counts more than another that is as clear, as torques show in some and differ from recording to recording.
        let clear = |shown: &Self, spectrum: &[Complex<f64>], order: usize| {
            let power = spectrum[order].norm_sqr() / edges as f64;
            (power + shown.variance[order]).sqrt().recip()
        };
        let mut product: Vec<Complex<f64>> = (0..own.len())
            .map(|order| {
                let both = clear(self, &own, order) * clear(other, &others, order);
                own[order] * others[order].conj() * (both / edges as f64)
            })
            .collect();
        product[0] = Complex::default();
        if edges.is_multiple_of(2) {
            product[edges / 2].im = 0.0;
        }
        let by_chance: f64 = product.iter().map(|one| 2.0 * one.norm_sqr()).sum();
        let mut both = back.make_output_vec();
        back.process(&mut product, &mut both).ok()?;
        // Squares of what is normal where discs have nothing in common.
        let square = |at: usize| both[at].max(0.0).powi(2) / by_chance;
        let turns = (0..edges).step_by(classes);
        let tried = (edges / classes) as f64;
        let best = turns.max_by(|a, b| both[*a].total_cmp(&both[*b]))?;
        (square(best) - square(0) > SURE + 2.0 * tried.ln()).then_some(best)
    }
}

/// By how many edges the index of recordings stands further than in the twin whose disc they show; none where that is not sure. A disc that
/// is another one beside a fit may be the twin's, counted from elsewhere.
#[must_use]
pub fn index_moved(board: &Board, fit: &Fit) -> Option<i64> {
    disc::other(board, fit)?;
    let first = board.benches.first()?;
    let mut errors = disc::learned(board, &fit.model)?;
    let anchored = board.benches.iter().all(|bench| bench.record.anchored);
    if !anchored || errors.len() != first.disc.len() {
        return None;
    }
    lsq::add(&mut errors, 1.0, &first.disc);
    let pattern = board.pattern.as_ref()?;
    let variance = (0..=errors.len() / 2).map(|order| pattern.variance(order));
    let shown = Shown {
        variance: variance.collect(),
        errors,
    };
    let edges = first.record.edges;
    let by = Shown::given(first)?.turn(&shown, first.record.classes as usize)? as i64;
    Some(if 2 * by > edges { by - edges } else { by })
}

/// By how many edges each recording's places have to be turned so that they are those of one disc.
#[must_use]
pub fn turns(benches: &[Bench]) -> Vec<i64> {
    let mut all = vec![0; benches.len()];
    // Where a twin says at which angle the shaft starts, an error of the disc that it lacks may have moved other edges there.
    let free: Vec<usize> = (0..benches.len())
        .filter(|&at| !benches[at].record.anchored)
        .collect();
    let Some(first) = benches.first() else {
        return all;
    };
    let reference = Shown::given(first);
    let given = reference.is_some();
    if free.is_empty() || !given && benches.len() < 2 {
        return all;
    }
    // Without a disc from a twin, the first recording's is the one.
    let Some(reference) = reference.or_else(|| Shown::by(first)) else {
        return all;
    };
    for at in free.into_iter().filter(|&at| given || at > 0) {
        let classes = benches[at].record.classes as usize;
        let by = Shown::by(&benches[at]).and_then(|shown| reference.turn(&shown, classes));
        all[at] = by.map_or(0, |by| by as i64);
    }
    all
}
