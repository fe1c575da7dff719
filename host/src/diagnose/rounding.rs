//! Where nothing but the timer's own rounding is left.
//!
//! A stamp is rounded to a tick. Where something scatters edges by more than a tick, rounding is white noise; where nothing does, it
//! comes and goes with the phase of edge against clock, as steady as the shaft turns, and looks like rhythms and patterns of a tenth of
//! a tick (B. Widrow, I. Kollar, Quantization Noise, Cambridge 2008, chapter 19). What is no larger than rounding as a whole can't be
//! told from it there.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::board::Board;

/// Standard error of a stamp over that of rounding alone, up to which nothing scatters the stamps.
const STAMPS: f64 = 1.1;
/// The same of the expected time of an edge: neither does the shaft.
const EDGES: f64 = 1.5;
/// Mean square over that of rounding, and its standard errors, from which on something else is there.
const MORE: f64 = 0.03;
const SURE: f64 = 4.0;
/// How much edges keep to one phase of the clock, 0 to 1, from which on they are all rounded alike: one way or the other, a whole tick
/// apart, with up to three times the mean square.
const IN_STEP: f64 = 0.3;
const ALIKE: f64 = 3.1;

/// Whether rounding is all there is in every recording.
#[must_use]
pub fn is_all(board: &Board) -> bool {
    let Some(model) = board.fit(board.nuisances()) else {
        return false;
    };
    let each = board.benches.iter().zip(&model.left);
    each.clone().count() > 0 && each.into_iter().all(|(bench, left)| is_all_of(bench, left))
}

/// The same of one recording's residual, white.
#[must_use]
pub fn is_all_of(bench: &Bench, left: &[f64]) -> bool {
    let least_s = bench.least_stamp_s;
    if bench.noise.stamp_s > ALIKE.sqrt() * least_s {
        return false;
    }
    let tick_s = least_s * 12_f64.sqrt();
    let speeds = bench.seen.speeds.iter().map(|speed| speed.abs());
    let expected_s = bench.deviations().zip(speeds);
    let expected_s = expected_s.map(|(deviation, speed)| Some(deviation? / speed));
    let (mut count, mut wide, mut squares) = (0.0, 0.0, 0.0);
    let (mut cos, mut sin) = (0.0, 0.0);
    for ((expected_s, left), time_s) in expected_s.zip(left).zip(&bench.seen.times_s) {
        let Some(expected_s) = expected_s else {
            continue;
        };
        let off_s = left * expected_s;
        count += 1.0;
        wide += expected_s;
        squares += (off_s / least_s).powi(2);
        // An angle that is ahead is a stamp that is early.
        let phase = (TAU * (time_s + off_s) / tick_s).sin_cos();
        (sin, cos) = (sin + phase.0, cos + phase.1);
    }
    // Uniform errors: their squares scatter by 0.8 of their mean's square.
    let scatter = (0.8_f64 / count).sqrt();
    let (stamps, most) = if cos.hypot(sin) > IN_STEP * count {
        (ALIKE.sqrt(), ALIKE)
    } else {
        (STAMPS, 1.0 + MORE + SURE * scatter)
    };
    let scattered =
        bench.noise.stamp_s > stamps * least_s || wide > EDGES * stamps * least_s * count;
    count > 0.0 && !scattered && squares < most * count
}
