//! Turns, each on its own: from crossing times to the error of every edge as this turn shows it.

use realfft::num_complex::Complex64;

use super::plan::{Plan, coefficient};

/// Lowest orders, compared from turn to turn.
pub(super) const LOW_ORDERS: usize = 6;

/// A turn taken.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    /// Error of every edge, turns; that of edge 0 is zero.
    pub error: Vec<f64>,
    /// Duration over that of the first turn.
    pub ratio: f64,
    /// The same in half octaves, rounded.
    pub bin: i32,
    /// Sign in the contrasts.
    pub sign: f64,
    /// Squared differences of the lowest orders to the turn before, of like speed; turns squared.
    pub pair: Option<[f64; LOW_ORDERS]>,
    /// Sum of squared second differences between this turn's deviations and the last one's, steps squared.
    pub jitter: Option<f64>,
}

/// What the turns so far say to the next.
#[derive(Default)]
struct Reader {
    turns: Vec<Turn>,
    first: Option<f64>,
    last: Option<(f64, [Complex64; LOW_ORDERS])>,
    disagreed: bool,
}

/// All turns that are taken of some recordings, which begin at a crossing of edge 0; the first turn of each gives the rate.
pub(super) fn read(recordings: &[&[u64]], plan: Plan) -> Vec<Turn> {
    let mut reader = Reader::default();
    for times in recordings {
        let mut before = None;
        let mut known: Option<Vec<f64>> = None;
        for crossings in times.windows(plan.edges + 1).step_by(plan.edges) {
            let since = |time: &u64| (time - crossings[0]) as f64;
            let duration = since(&crossings[plan.edges]);
            let Some(before) = before.replace(duration) else {
                continue;
            };
            let time: Vec<f64> = crossings.iter().map(|t| since(t) / before).collect();
            let deviations = steps(&time, plan);
            let old = known.take();
            let jitter = old.map(|old| second_differences(&deviations, &old));
            if reader.take(&time, before, duration, jitter, plan) {
                known = Some(deviations);
            }
        }
    }
    reader.turns
}

impl Reader {
    /// Takes a turn whose crossings are given in durations of the turn before; false where it is not to be used.
    fn take(
        &mut self,
        time: &[f64],
        before: f64,
        duration: f64,
        jitter: Option<f64>,
        plan: Plan,
    ) -> bool {
        let whole = time[plan.edges];
        let first = *self.first.get_or_insert(duration);
        let ratio = duration / first;
        let bin = (2.0 * ratio.log2() + 0.5).floor() as i32;
        if (whole - 1.0).abs() > 1.0 / 3.0 || !(-12..12).contains(&bin) {
            return false;
        }
        // Three crossings of edge 0: the angle is tau - bend tau (1 - tau).
        let bend = (before - duration) / before * duration / (before + duration);
        let angle = |tau: f64| tau - bend * tau * (1.0 - tau);
        let tau_at = |x: f64| {
            let half = 1.0 - bend;
            2.0 * x / (half + (half * half + 4.0 * bend * x).sqrt())
        };
        let place = |k: usize| k as f64 / plan.edges as f64;
        let off_motion: Vec<f64> = (0..plan.edges)
            .step_by(plan.block)
            .map(|k| time[k] - whole * tau_at(place(k)))
            .collect();
        let low = std::array::from_fn(|index| coefficient(&off_motion, index + 1));
        let Ok(pair) = self.compare(duration, bin, low) else {
            return false;
        };
        let sign = if self.turns.len().count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let error = (0..plan.edges).map(|k| place(k) - angle(time[k] / whole));
        self.turns.push(Turn {
            error: error.collect(),
            ratio,
            bin,
            sign,
            pair,
            jitter,
        });
        true
    }

    /// Squared differences of the lowest orders to those of the last turn where the two are of like speed; `Err` for a turn
    /// that differs far more than others do, though not twice in a row.
    fn compare(
        &mut self,
        duration: f64,
        bin: i32,
        low: [Complex64; LOW_ORDERS],
    ) -> Result<Option<[f64; LOW_ORDERS]>, ()> {
        let Some((last, last_low)) = self.last.replace((duration, low)) else {
            return Ok(None);
        };
        if (duration - last).abs() > duration / 16.0 {
            return Ok(None);
        }
        let squares: [f64; LOW_ORDERS] =
            std::array::from_fn(|index| (low[index] - last_low[index]).norm_sqr());
        // Torque noise falls with the fourth power of the order.
        let level = |squares: &[f64; LOW_ORDERS]| -> f64 {
            let by_order = squares.iter().zip(1..);
            by_order.map(|(x, n)| x * f64::from(n).powi(4)).sum()
        };
        let usual: Vec<f64> = pairs(&self.turns, bin).map(level).collect();
        let mean = usual.iter().sum::<f64>() / usual.len().max(1) as f64;
        let far_off = usual.len() >= 3 && level(&squares) > 32.0 * mean;
        if far_off && !self.disagreed {
            self.disagreed = true;
            self.last = Some((last, last_low));
            return Err(());
        }
        self.disagreed = false;
        Ok((!far_off).then_some(squares))
    }
}

/// The pairs of turns compared in a bin.
pub(super) fn pairs(turns: &[Turn], bin: i32) -> impl Iterator<Item = &[f64; LOW_ORDERS]> {
    let of_bin = turns.iter().filter(move |turn| turn.bin == bin);
    of_bin.filter_map(|turn| turn.pair.as_ref())
}

/// Deviation of every interval from the grid, steps.
fn steps(time: &[f64], plan: Plan) -> Vec<f64> {
    let intervals = time.windows(2).map(|pair| pair[1] - pair[0]);
    intervals.map(|x| x * plan.edges as f64 - 1.0).collect()
}

/// Sum of the squared steps in the difference of two turns' deviations.
fn second_differences(new: &[f64], old: &[f64]) -> f64 {
    let change: Vec<f64> = new.iter().zip(old).map(|(new, old)| new - old).collect();
    change
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum()
}

/// Sum over turns of their errors at every `apart`th edge, each turn with its share.
pub(super) fn combine(turns: &[Turn], shares: &[f64], apart: usize) -> Vec<f64> {
    let mut sum = vec![0.0; turns[0].error.len() / apart];
    for (turn, share) in turns.iter().zip(shares) {
        for (sum, error) in sum.iter_mut().zip(turn.error.iter().step_by(apart)) {
            *sum += share * error;
        }
    }
    sum
}
