//! Where nothing but the timer's own rounding is left.
//!
//! A stamp is rounded to a tick. Where something scatters edges by more than a tick, rounding is white noise; where nothing does, it
//! comes and goes with the phase of edge against clock, as steady as the shaft turns, and looks like rhythms and patterns of a tenth of
//! a tick (B. Widrow, I. Kollar, Quantization Noise, Cambridge 2008, chapter 19). What is no larger than rounding as a whole can't be
//! told from it there.

use super::bench::Bench;
use super::board::Board;

/// Standard error of a stamp over that of rounding alone, up to which nothing scatters the stamps.
const STAMPS: f64 = 1.1;
/// The same of the expected time of an edge: neither does the shaft.
const EDGES: f64 = 1.5;
/// Mean square over that of rounding, and its standard errors, from which on something else is there.
const MORE: f64 = 0.03;
const SURE: f64 = 4.0;

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
    if bench.noise.stamp_s > STAMPS * least_s {
        return false;
    }
    let speeds = bench.seen.speeds.iter().map(|speed| speed.abs());
    let expected_s = bench
        .deviations()
        .zip(speeds)
        .map(|(deviation, speed)| Some(deviation? / speed));
    let (mut count, mut wide, mut squares) = (0.0, 0.0, 0.0);
    for (expected_s, left) in expected_s.zip(left) {
        let Some(expected_s) = expected_s else {
            continue;
        };
        count += 1.0;
        wide += expected_s;
        squares += (left * expected_s / least_s).powi(2);
    }
    // Uniform errors: their squares scatter by 0.8 of their mean's square.
    let scatter = (0.8_f64 / count).sqrt();
    count > 0.0 && wide < EDGES * least_s * count && squares < (1.0 + MORE + SURE * scatter) * count
}
