//! Gains of a loop whose rate is known, once the samples that fall on an edge are decided.
//!
//! Which of two speeds such a sample saw is not said by the stamps (see `diagnose::ties`). Taken the wrong way it pushes at random, which
//! pulls the gains towards zero; so the loop is put into the twin, its ties are decided, and the gains are fitted again to what is
//! left, until they stay.

use super::gains::Side;
use super::solve::{Rows, Solved, solved};
use crate::diagnose::bench::Bench;
use crate::diagnose::prepare;
use crate::diagnose::run::Recorded;
use crate::twin::Twin;

/// Times that ties are decided and gains are fitted at the most.
const ROUNDS: usize = 5;
/// Change, in standard errors, that does not matter.
const STAYS: f64 = 0.2;
/// Variance of the white residual from which on the noise is found anew.
const VARIANCE: f64 = 1.1;

/// A loop with its ties decided.
pub struct Decided {
    /// Proportional and integral gain over the inertia.
    pub sizes: [f64; 2],
    /// Standard errors.
    pub errors: [f64; 2],
    /// Recordings against the twins with the loop in.
    pub benches: Vec<Bench>,
    /// Samples that were decided against the stamps.
    pub turned: usize,
}

/// Fits a loop again from near its gains; `with` puts one into a twin. None where it is lost.
#[must_use]
pub fn decided(
    rig: &[Recorded],
    sides: &[Side],
    f_hz: f64,
    start: [f64; 2],
    with: &dyn Fn(&Twin, [f64; 2]) -> Twin,
) -> Option<Decided> {
    let mut sizes = start;
    for round in 1.. {
        let mut benches = Vec::new();
        let (mut rows, mut turned) = (Vec::new(), 0);
        for (one, side) in rig.iter().zip(sides) {
            let looped = Recorded {
                twin: with(&one.twin, sizes),
                ..one.clone()
            };
            let mut bench = prepare::bench(&looped).ok()?;
            let squares: f64 = bench.white.iter().map(|white| white * white).sum();
            if squares > VARIANCE * bench.white.len() as f64 {
                bench.set_noise(bench.noise_of(&bench.seen.angles));
            }
            let mut missed = side.sampled.missed(f_hz);
            for tie in bench.seen.ties.iter().filter(|tie| tie.turned) {
                if let Some(miss) = missed.get_mut((tie.at_s * f_hz).round() as usize) {
                    *miss -= tie.push / sizes[0];
                    turned += 1;
                }
            }
            rows.push(rows_of(side, &bench, f_hz, &missed)?);
            benches.push(bench);
        }
        let Solved {
            sizes: more,
            errors,
            ..
        } = solved(rows)?;
        let moved = more
            .iter()
            .zip(&errors)
            .any(|(more, error)| more.abs() > STAYS * error);
        if !moved || round == ROUNDS {
            return Some(Decided {
                sizes,
                errors,
                benches,
                turned,
            });
        }
        for (size, more) in sizes.iter_mut().zip(more) {
            *size += more;
        }
    }
    None
}

/// What more of the gains does to the edges of a recording.
fn rows_of(side: &Side, bench: &Bench, f_hz: f64, missed: &[f64]) -> Option<Rows<2>> {
    let times = &bench.seen.times_s;
    let sampled = &side.sampled;
    let first = sampled.edge_of(*times.first()?)?;
    let edges: Vec<usize> = (first..first + times.len()).collect();
    if edges.last() != sampled.edge_of(*times.last()?).as_ref() {
        return None;
    }
    let way = bench
        .seen
        .speeds
        .first()
        .map_or(1.0, |speed| speed.signum());
    let white = |row: Vec<f64>| bench.whitened(row.iter().map(|value| way * value).collect());
    let spans = sampled.spans(edges);
    let columns: [Vec<f64>; 2] = sampled.responses(&spans, f_hz, |sample| {
        missed.get(sample as usize).copied().unwrap_or(0.0)
    });
    Some(Rows {
        columns: columns.map(white),
        steady: sampled.steady(&spans).map(white),
        left: bench.white.clone(),
    })
}
