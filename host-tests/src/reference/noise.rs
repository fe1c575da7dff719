//! Noise of an estimate at every order.

use std::f64::consts::LN_2;

use super::agree::LOW_ORDERS;
use super::moments::{noise_of, torque_power};
use super::plan::{Plan, coefficient};
use super::turns::{Turn, combine, pairs};

/// Noise powers by order, turns squared.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    /// Expected.
    pub level: Vec<f64>,
    /// What the contrast showed at the order itself over the level of its neighbours.
    pub own: Vec<f64>,
    /// Pairs of turns that the noise of the lowest orders rests on.
    pub low_pairs: f64,
}

impl Noise {
    /// Of the estimate with `shares` of the turns, by its `contrast`.
    pub(super) fn of(plan: Plan, turns: &[Turn], shares: &[f64], contrast: &[f64]) -> Self {
        let samples = combine(turns, contrast, plan.block);
        let shown = plan.by_order(|order| coefficient(&samples, order).norm_sqr());
        // Samples a block apart show jitter of all orders on those that they can tell.
        let jitter = jitter_power(plan, turns, shares);
        let folded = jitter * plan.block as f64;
        let raw = smooth(plan, &shown, folded);
        let own = plan.by_order(|order| shown[order] / raw[order]);
        let smooth =
            plan.by_order(|order| raw[order] - (folded - jitter).min(raw[order] * 7.0 / 8.0));
        // Of a turn at the first one's speed.
        let norm = noise_of(contrast, turns, torque_power);
        let mut low_pairs = f64::INFINITY;
        let level = plan.by_order(|order| {
            let torque = |turn: &Turn| smooth[order] / norm * torque_power(turn);
            if order <= LOW_ORDERS {
                let (power, pairs) = low_noise(turns, shares, order, torque);
                low_pairs = low_pairs.min(pairs);
                power
            } else {
                noise_of(shares, turns, torque)
            }
        });
        Self {
            level,
            own,
            low_pairs,
        }
    }
}

/// Mean over neighbours of the logarithm with the slope of torque noise taken out, and not below that from the order up.
/// That slope ends in a `floor`.
fn smooth(plan: Plan, shown: &[f64], floor: f64) -> Vec<f64> {
    let fourth = |order: usize| 4.0 * (order as f64).log2();
    let sizes: Vec<f64> = plan
        .orders()
        .filter(|order| (7..=18).contains(order))
        .map(|order| shown[order].log2() + fourth(order))
        .collect();
    let size = sizes.iter().sum::<f64>() / sizes.len().max(1) as f64;
    let slope = |order: usize| -((size - fourth(order)).exp2() + floor).log2();
    let mean = |orders: &mut dyn Iterator<Item = usize>| {
        let levels: Vec<f64> = orders.map(|n| shown[n].log2() + slope(n)).collect();
        levels.iter().sum::<f64>() / levels.len().max(1) as f64
    };
    plan.by_order(|order| {
        let last = (order + 24).max(order + order / 3).min(plan.single);
        let first = order.min(last.saturating_sub(24));
        let above = mean(&mut plan.orders().filter(|n| (first..=last).contains(n)));
        let level = mean(&mut plan.neighbours(order)).max(above) - slope(order);
        // The mean over the geometric mean of an exponential distribution.
        (level + 0.577_215_664_9 / LN_2).exp2()
    })
}

/// Noise at a low order of the estimate with `shares` of the turns, as much wider as Student's intervals are: each speed by its own
/// pairs, of which three are worth two, all together by Satterthwaite's rule; and the pairs that it is worth.
fn low_noise(
    turns: &[Turn],
    shares: &[f64],
    order: usize,
    expected: impl Fn(&Turn) -> f64,
) -> (f64, f64) {
    let mut bins: Vec<i32> = turns.iter().map(|turn| turn.bin).collect();
    bins.sort_unstable();
    bins.dedup();
    let (mut sum, mut spread) = (0.0, 0.0);
    for bin in bins {
        let noise = noise_of(shares, turns, |turn| {
            if turn.bin == bin {
                low_power(turns, bin, order, expected(turn))
            } else {
                0.0
            }
        });
        let count = pairs(turns, bin).count() as f64;
        sum += noise;
        spread += if count > 0.0 {
            noise * noise * 1.5 / count
        } else {
            0.0
        };
    }
    (sum + 2.0 * spread / sum, sum * sum / spread)
}

/// Power of a low order in one turn of a bin, by the pairs of turns compared; where these are few, also by what is expected.
fn low_power(turns: &[Turn], bin: i32, order: usize, expected: f64) -> f64 {
    let (scatter, count) = scatter(turns, bin);
    if count == 0.0 {
        return expected;
    }
    let excess = pair_excess(&scatter);
    let seen = scatter[order - 1] / (2.0 * count * excess);
    let of_bin = || turns.iter().filter(|turn| turn.bin == bin);
    let gaps = of_bin().filter(|turn| turn.jitter.is_none()).count();
    let ends = (excess - 1.0) * gaps.saturating_sub(1) as f64 / of_bin().count() as f64;
    let seen = seen * (1.0 + ends);
    let prior = (4.0 - count).max(0.0);
    (seen * count + expected * prior) / (count + prior)
}

/// Summed squared differences of the pairs of a bin, and how many there are.
fn scatter(turns: &[Turn], bin: i32) -> ([f64; LOW_ORDERS], f64) {
    let mut scatter = [0.0; LOW_ORDERS];
    for pair in pairs(turns, bin) {
        for (sum, square) in scatter.iter_mut().zip(pair) {
            *sum += square;
        }
    }
    (scatter, pairs(turns, bin).count() as f64)
}

fn upper_slope(scatter: &[f64; LOW_ORDERS]) -> f64 {
    (scatter[3] * 256.0 + scatter[4] * 625.0 + scatter[5] * 1296.0) / 3.0
}

/// Squares of the shaft's damping over its speed where it is slowest, in parts of what it makes torque pass for geometry: what orders
/// are weighed with, and what is stated. By what order 1 has less than the orders above promise; what does not show is up to a quarter
/// of the speed.
pub(super) fn damping_squares(turns: &[Turn]) -> [f64; 2] {
    let slowest = turns
        .iter()
        .map(|turn| turn.bin)
        .filter(|&bin| scatter(turns, bin).1 >= 3.0);
    let shown = slowest.max().map_or(0.0, |bin| {
        let (scatter, count) = scatter(turns, bin);
        // Jitter of the time stamps rules where the slope goes on to rise.
        let [low, high] = [
            scatter[1] * 16.0 + scatter[2] * 81.0,
            scatter[4] * 625.0 + scatter[5] * 1296.0,
        ];
        if scatter[5] * 1296.0 > 4.0 * scatter[2] * 81.0 || high > 3.5 * low {
            return 0.0;
        }
        let sure = count.sqrt() / (count.sqrt() + 2.0);
        (upper_slope(&scatter) / scatter[0] * sure).clamp(1.0, 17.0) - 1.0
    });
    let longest = turns.iter().map(|turn| turn.ratio).fold(0.0, f64::max);
    let shortest = turns.iter().map(|turn| turn.ratio).fold(f64::MAX, f64::min);
    let part = longest / (shortest + longest);
    [1.0 / 256.0, 1.0 / 16.0].map(|hidden| shown.max(hidden) * part * part)
}

/// How much more neighbouring turns differ than their noise in the long run: twice where speed is a random walk.
fn pair_excess(scatter: &[f64; LOW_ORDERS]) -> f64 {
    let slope = upper_slope(scatter).min((scatter[1] * 16.0 + scatter[2] * 81.0) / 2.0);
    1.0 + 0.9 * (scatter[0] / slope).min(1.25).powi(2)
}

/// Noise of an estimate at every order above the single ones: jitter of time stamps, and the tail of torque beyond the last
/// single order, whose power is `last`.
pub(super) fn common_noise(plan: Plan, turns: &[Turn], shares: &[f64], last: f64) -> f64 {
    let tail = last * 2.0 * plan.single as f64 / (3.0 * plan.common_count().max(1) as f64);
    jitter_power(plan, turns, shares) + tail
}

/// Power at every order that jitter of the time stamps gives an estimate.
fn jitter_power(plan: Plan, turns: &[Turn], shares: &[f64]) -> f64 {
    let edges = plan.edges as f64;
    // In angle jitter goes with the speed.
    let square = |turn: &Turn| f64::from(turn.bin).exp2();
    let per_edge =
        jitter(turns, edges, square) * noise_of(shares, turns, |turn| 1.0 / square(turn));
    per_edge / edges.powi(3)
}

/// Variance of a time stamp, in steps at the first turn's speed, by the speed that shows least; twelve make a second
/// difference of two turns.
fn jitter(turns: &[Turn], edges: f64, square: impl Fn(&Turn) -> f64) -> f64 {
    let of_bin = |turn: &Turn| {
        let of_bin = turns.iter().filter(|other| other.bin == turn.bin);
        let sums: Vec<f64> = of_bin.filter_map(|turn| turn.jitter).collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        (!sums.is_empty()).then(|| mean * square(turn) / (12.0 * edges))
    };
    turns
        .iter()
        .filter_map(of_bin)
        .reduce(f64::min)
        .unwrap_or(0.0)
}
