//! Noise of no catalogue: bursts in time.
//!
//! Blocks of edges next to each other have the same spread, whatever it is. Half the mean squared difference of neighbouring
//! blocks' sums of squares (Allan's variance) grows as the blocks then, and faster where squares cluster. What changes slowly, as the fit of a whole recording leaves it, cancels.

use super::super::board::Board;
use super::super::seen::Seen;
use super::levels::Levels;
use super::odds::{anywhere, normal_above};
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;

/// Blocks that a scale needs at the least.
const BLOCKS_LEAST: usize = 40;
/// Edges of the smallest blocks, which set the scatter: a single late stamp moves some edges after it.
const FINEST: usize = 16;
/// Squares are cut here, so that a single edge is no burst.
const CUT: f64 = 9.0;
/// What a finding needs: standard deviations, and clustering over none.
const LEAST_DEVIATIONS: f64 = 8.0;
const LEAST_CLUSTERING: f64 = 1.3;

/// How much the squares of a row of white numbers cluster at a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Clustering {
    /// Edges a block.
    block: usize,
    /// 1 where edges are independent.
    ratio: f64,
    /// Standard deviations above 1.
    deviations: f64,
}

/// Bursts, where there are any.
#[must_use]
pub fn find(board: &Board, levels: &Levels) -> Option<NoiseFinding> {
    let mut worst: Option<(usize, Clustering)> = None;
    let mut scales = 0.0;
    let all = board.benches.iter().zip(&levels.white);
    let rows: Vec<(Vec<f64>, Vec<f64>)> =
        all.map(|(bench, white)| own(&bench.seen, white)).collect();
    for (at, (_, white)) in rows.iter().enumerate() {
        // Where the shaft hardly moves its law is not linear.
        let speeds = board.benches[at]
            .seen
            .speeds
            .iter()
            .map(|speed| speed.abs());
        let (low, high) = speeds.fold((f64::INFINITY, 0.0_f64), |(low, high), w| {
            (low.min(w), high.max(w))
        });
        if low < 0.1 * high {
            continue;
        }
        for clustering in scales_of(white) {
            scales += 1.0;
            if worst.is_none_or(|(_, other)| clustering.deviations > other.deviations) {
                worst = Some((at, clustering));
            }
        }
    }
    let (at, clustering) = worst?;
    if clustering.deviations < LEAST_DEVIATIONS || clustering.ratio < LEAST_CLUSTERING {
        return None;
    }
    let (own_s, white) = &rows[at];
    let loud = loud(white, clustering.block);
    let times: Vec<f64> = loud
        .blocks
        .iter()
        .take(20)
        .map(|block| own_s[block * clustering.block])
        .collect();
    let p_value = anywhere(normal_above(clustering.deviations), scales);
    Some(NoiseFinding {
        mechanism: Mechanism::Unknown,
        parameters: vec![
            NoiseParameter {
                name: "share",
                value: loud.share,
                standard_error: 0.1 * loud.share,
            },
            NoiseParameter {
                name: "times_as_wide",
                value: loud.wider,
                standard_error: 0.1 * loud.wider,
            },
        ],
        delta_bic: clustering.deviations * clustering.deviations - (board.edges() as f64).ln(),
        p_value,
        text: format!(
            "noise comes in bursts: in {:.0} % of the time edges spread {:.1} times as far as else",
            100.0 * loud.share,
            loud.wider
        ),
        frequencies_hz: Vec::new(),
        times_s: times,
        edge_classes: Vec::new(),
        runner_up: None,
        busy: None,
    })
}

/// Times and white numbers of the edges whose noise is the shaft's own: how hard something pushes it is not known, nor how evenly.
fn own(seen: &Seen, white: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let each = seen.times_s.iter().zip(white).enumerate();
    let own = each.filter(|(at, _)| !seen.follows(*at));
    own.map(|(_, (time, white))| (*time, *white)).unzip()
}

fn scales_of(white: &[f64]) -> Vec<Clustering> {
    let squares: Vec<f64> = white.iter().map(|w| (w * w).min(CUT)).collect();
    let (base, blocks) = (allan(&squares, FINEST), squares.len() / FINEST);
    let mut all = Vec::new();
    let mut block = 2 * FINEST;
    while squares.len() / block >= BLOCKS_LEAST {
        let ratio = allan(&squares, block) / base.max(f64::MIN_POSITIVE);
        let scatter = (3.0 / (squares.len() / block) as f64 + 3.0 / blocks as f64).sqrt();
        all.push(Clustering {
            block,
            ratio,
            deviations: (ratio - 1.0) / scatter,
        });
        block *= 2;
    }
    all
}

/// Half the mean squared difference of neighbouring blocks' sums, for each edge.
fn allan(squares: &[f64], block: usize) -> f64 {
    let sums: Vec<f64> = squares
        .chunks_exact(block)
        .map(|b| b.iter().sum())
        .collect();
    let pairs = sums.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    0.5 * pairs.sum::<f64>() / ((sums.len() - 1) * block) as f64
}

struct Loud {
    blocks: Vec<usize>,
    share: f64,
    wider: f64,
}

/// Blocks well above the usual one.
fn loud(white: &[f64], block: usize) -> Loud {
    let means: Vec<f64> = white
        .chunks_exact(block)
        .map(|b| b.iter().map(|w| w * w).sum::<f64>() / block as f64)
        .collect();
    let mut sorted = means.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let above = usual * (1.0 + 4.0 * (2.0 / block as f64).sqrt());
    let blocks: Vec<usize> = (0..means.len()).filter(|at| means[*at] > above).collect();
    let sum: f64 = blocks.iter().map(|at| means[*at]).sum();
    let mean = sum / blocks.len().max(1) as f64;
    Loud {
        share: blocks.len() as f64 / means.len() as f64,
        wider: (mean / usual).max(1.0).sqrt(),
        blocks,
    }
}
