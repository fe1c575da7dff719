//! The search for the rate at which a speed loop samples.
//!
//! Errors of the disc make the speed of single intervals jump, and which intervals a loop takes depends on its rate to about one part in
//! the number of edges: so a rate that explains the motion is a fingerprint of a loop. Short pieces of some samples are searched
//! for rates with few of their edges; what is best there is followed through ever longer pieces.

use rayon::prelude::*;

use super::sampled::Sampled;
use super::solve::{dot, without};
use super::spans::Spans;
use crate::diagnose::kalman::ShaftNoise;

/// Samples of the first pieces, and most edges between samples for which so many are gone through: short ones find a loop whose push
/// stands out of the noise, long ones take long.
const FIRST: [(f64, f64); 2] = [(16.0, APART_MOST), (48.0, 300.0)];
/// Edges looked at for each sample.
const NODES: f64 = 4.0;
/// Rates kept after the first pieces.
const KEPT: usize = 24;
/// Slowest loop, Hz.
const SLOWEST_HZ: f64 = 20.0;
/// Least edges between samples.
const APART_LEAST: f64 = 2.0;
/// Most edges between samples.
const APART_MOST: f64 = 2_000.0;
/// Least evidence of a first piece.
const EVIDENCE_LEAST: f64 = 32.0;

/// Least evidence of longer pieces an edge.
const EVIDENCE_AN_EDGE: f64 = 0.015;

/// Rates that a rate may stand for, by their shares of it.
const MULTIPLES: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 1.5, 0.5, 1.0 / 3.0];

/// A rate and what speaks for it.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// Samples a second.
    pub f_hz: f64,
    /// Fall of -2 log likelihood.
    pub evidence: f64,
}

/// A piece ready to be held against rates.
struct Piece<'a> {
    sampled: &'a Sampled,
    spans: Spans,
    whitener: crate::diagnose::kalman::Whitener,
    left: Vec<f64>,
    /// Constant and growing push, white, orthonormal.
    steady: Vec<Vec<f64>>,
    squares: f64,
}

impl<'a> Piece<'a> {
    fn new(sampled: &'a Sampled, edges: Vec<usize>, noise: ShaftNoise) -> Self {
        let whitener = sampled.whitener(&edges, noise);
        let mut left = sampled.angles_at(&edges);
        let spans = sampled.spans(edges);
        let mut steady: Vec<Vec<f64>> = Vec::new();
        for mut column in sampled.steady(&spans) {
            whitener.whiten(&mut column);
            for before in &steady {
                without(&mut column, before);
            }
            let size = dot(&column, &column).sqrt();
            if size > 0.0 {
                column.iter_mut().for_each(|value| *value /= size);
                steady.push(column);
            }
        }
        whitener.whiten(&mut left);
        for column in &steady {
            without(&mut left, column);
        }
        let squares = dot(&left, &left);
        Self {
            sampled,
            spans,
            whitener,
            left,
            steady,
            squares,
        }
    }

    /// What speaks for a rate.
    fn evidence(&self, f_hz: f64, both: bool) -> f64 {
        let (mut kp, ki) = if both {
            let [kp, ki] = self.sampled.gains(&self.spans, f_hz);
            (kp, Some(ki))
        } else {
            (self.sampled.gain(&self.spans, f_hz), None)
        };
        self.whitener.whiten(&mut kp);
        for column in &self.steady {
            without(&mut kp, column);
        }
        let (own, with) = (dot(&kp, &kp), dot(&kp, &self.left));
        if own <= 0.0 || with <= 0.0 {
            return 0.0;
        }
        let mut explained = with * with / own;
        if let Some(mut ki) = ki {
            self.whitener.whiten(&mut ki);
            for column in &self.steady {
                without(&mut ki, column);
            }
            let share = dot(&kp, &ki) / own;
            ki.iter_mut()
                .zip(&kp)
                .for_each(|(ki, kp)| *ki -= share * kp);
            let (own, with) = (dot(&ki, &ki), dot(&ki, &self.left));
            if own > 0.0 {
                explained += with * with / own;
            }
        }
        let share = (explained / self.squares).clamp(0.0, 1.0 - 1e-12);
        -(self.spans.edges.len() as f64) * (1.0 - share).ln()
    }
}

/// The rate at which a loop samples, if there seems to be one.
#[must_use]
pub fn rate(sampled: &Sampled, noise: ShaftNoise) -> Option<Rate> {
    let each = FIRST.into_iter();
    let mut tries = each.map(|(samples, most)| {
        let kept = first(sampled, noise, samples, most);
        followed(sampled, noise, kept)
    });
    tries.find_map(|rate| rate)
}

/// Rates for which a first piece speaks, and the edges of the piece.
fn first(sampled: &Sampled, noise: ShaftNoise, samples: f64, most: f64) -> Vec<(Rate, usize)> {
    let mut kept = Vec::new();
    let mut apart = APART_LEAST;
    while apart < most && sampled.rate_hz / apart > SLOWEST_HZ {
        let top = sampled.rate_hz / apart;
        let count = ((samples * 1.4 * apart) as usize + 64).min(sampled.len());
        let mut edges = sampled.edges_for(0.5 * top, (1.4 * apart / NODES) as usize);
        edges.retain(|edge| *edge < count);
        let piece = Piece::new(sampled, edges, noise);
        // Half an edge at the end of the piece.
        let finer = 1.0 - 0.5 / (sampled.time_s(count - 1) * sampled.rate_hz);
        let all = std::iter::successors(Some(top), |f_hz| Some(f_hz * finer));
        let all: Vec<f64> = all.take_while(|f_hz| *f_hz > 0.5 * top).collect();
        let rates: Vec<Rate> = all
            .into_par_iter()
            .map(|f_hz| Rate {
                f_hz,
                evidence: piece.evidence(f_hz, false),
            })
            .collect();
        let worth = rates
            .into_iter()
            .filter(|one| one.evidence > EVIDENCE_LEAST);
        kept.extend(worth.map(|rate| (rate, count)));
        apart *= 2.0;
    }
    kept
}

/// The best of some rates, followed through ever longer pieces; none where it was chance.
fn followed(sampled: &Sampled, noise: ShaftNoise, mut kept: Vec<(Rate, usize)>) -> Option<Rate> {
    kept.sort_by(|a, b| b.0.evidence.total_cmp(&a.0.evidence));
    let mut rates: Vec<Rate> = Vec::new();
    let mut count = kept.first()?.1.max(256);
    for (rate, _) in kept {
        if rates.len() < KEPT
            && rates
                .iter()
                .all(|old| (old.f_hz / rate.f_hz - 1.0).abs() > 1e-9)
        {
            rates.push(rate);
        }
    }
    while count < sampled.len() {
        count = (2 * count).min(sampled.len());
        rates = longer(sampled, &rates, count, noise);
        // What only chance has found does not grow with the piece.
        if rates.first()?.evidence < EVIDENCE_AN_EDGE * count as f64 {
            return None;
        }
    }
    let best = rates.first()?;
    // A loop that took every second sample only would explain half as much.
    let nearby = MULTIPLES.map(|multiple| Rate {
        f_hz: best.f_hz * multiple,
        ..*best
    });
    let possible = nearby.into_iter().filter(|rate| {
        let apart = sampled.rate_hz / rate.f_hz;
        (APART_LEAST..APART_MOST).contains(&apart) && rate.f_hz > SLOWEST_HZ
    });
    let possible: Vec<Rate> = possible.collect();
    longer(sampled, &possible, sampled.len(), noise)
        .first()
        .copied()
}

/// Rates near those before, best first, over a longer piece.
fn longer(sampled: &Sampled, rates: &[Rate], count: usize, noise: ShaftNoise) -> Vec<Rate> {
    let slowest = rates
        .iter()
        .map(|rate| rate.f_hz)
        .fold(f64::INFINITY, f64::min);
    let least_apart = rates
        .iter()
        .map(|rate| sampled.rate_hz / rate.f_hz)
        .fold(f64::INFINITY, f64::min);
    let mut edges = sampled.edges_for(slowest, (least_apart / NODES) as usize);
    edges.retain(|edge| *edge < count);
    let piece = Piece::new(sampled, edges, noise);
    let step = 0.35 / (sampled.time_s(count - 1) * sampled.rate_hz);
    let mut found: Vec<Rate> = rates
        .par_iter()
        .map(|rate| {
            (-5..=5)
                .map(|i| {
                    let f_hz = rate.f_hz * (1.0 + f64::from(i) * step);
                    let evidence = piece.evidence(f_hz, true);
                    Rate { f_hz, evidence }
                })
                .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
                .unwrap_or(*rate)
        })
        .collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    found.truncate((rates.len() / 2).max(3));
    found
}
