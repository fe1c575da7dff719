//! Turns, each on its own: from crossing times to the error of every edge as this turn shows it.

use realfft::num_complex::Complex64;

use super::agree::{Agreement, LOW_ORDERS, Seen, Squares};
use super::course::{self, Place};
use super::plan::{Plan, coefficient};

/// A turn taken.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    /// Error of every edge, turns; that of edge 0 is zero.
    pub error: Vec<f64>,
    /// What of it is the speed's own course.
    pub course: Vec<f64>,
    /// Duration over that of the first turn.
    pub ratio: f64,
    /// The same in half octaves, rounded.
    pub bin: i32,
    /// Sign in the contrasts.
    pub sign: f64,
    /// Squared differences of the lowest orders to the turn before, of like speed; turns squared.
    pub pair: Option<Squares>,
    /// Sum of squared second differences between this turn's deviations and the last one's, steps squared.
    pub jitter: Option<f64>,
}

/// What the turns so far say to the next.
#[derive(Default)]
struct Reader {
    turns: Vec<Turn>,
    first: Option<f64>,
    agreement: Agreement,
}

/// All turns that are taken of some recordings, which begin at a crossing of edge 0; the first turn of each gives the rate.
pub(super) fn read(recordings: &[&[u64]], plan: Plan) -> Vec<Turn> {
    let mut reader = Reader::default();
    for times in recordings {
        reader.agreement.interrupt();
        let mut before = None;
        let mut known: Option<Vec<f64>> = None;
        let ends: Vec<f64> = times
            .iter()
            .step_by(plan.edges)
            .map(|&t| (t - times[0]) as f64)
            .collect();
        let mut row = Vec::new();
        for (number, crossings) in times
            .windows(plan.edges + 1)
            .step_by(plan.edges)
            .enumerate()
        {
            let since = |time: &u64| (time - crossings[0]) as f64;
            let duration = since(&crossings[plan.edges]);
            let Some(before) = before.replace(duration) else {
                continue;
            };
            let time: Vec<f64> = crossings.iter().map(|t| since(t) / before).collect();
            let deviations = steps(&time, plan);
            let old = known.take();
            let jitter = old.map(|old| second_differences(&deviations, &old));
            if let Some(along) = reader.take(&time, [before, duration], jitter, plan) {
                known = Some(deviations);
                row.push(Place {
                    turn: number,
                    along,
                });
            } else {
                reader.end_row(&mut row, &ends, times, plan);
            }
        }
        reader.end_row(&mut row, &ends, times, plan);
    }
    reader.turns
}

impl Reader {
    /// Takes the speed's own course of the last turns, which follow on one another and leave the row.
    fn end_row(&mut self, row: &mut Vec<Place>, ends: &[f64], times: &[u64], plan: Plan) {
        let first = self.turns.len() - row.len();
        for (at, turn) in self.turns[first..].iter_mut().enumerate() {
            let number = row[at].turn;
            let crossings = &times[number * plan.edges..(number + 1) * plan.edges];
            let since = |&time: &u64| (time - crossings[0]) as f64;
            let duration = ends[number + 1] - ends[number];
            let tau: Vec<f64> = crossings.iter().map(|t| since(t) / duration).collect();
            let folded = (0..).zip(&turn.error);
            let folded: Vec<f64> = folded
                .map(|(k, e)| f64::from(k) / plan.edges as f64 - e)
                .collect();
            turn.course = course::off(row, at, ends, &tau, &folded);
        }
        row.clear();
    }

    /// Takes a turn whose crossings are given in durations of the turn before; none where it is not to be used, else whether its bend
    /// is that of both.
    fn take(
        &mut self,
        time: &[f64],
        [before, duration]: [f64; 2],
        jitter: Option<f64>,
        plan: Plan,
    ) -> Option<bool> {
        let whole = time[plan.edges];
        let first = *self.first.get_or_insert(duration);
        let ratio = duration / first;
        let bin = (2.0 * ratio.log2() + 0.5).floor() as i32;
        if (whole - 1.0).abs() > 1.0 / 3.0 || !(-12..12).contains(&bin) {
            return None;
        }
        // Three crossings of edge 0 tell how the turn bends. Where the one before was not taken it may as well have been steady.
        let smooth = (before - duration) / before * duration / (before + duration);
        let bends = [Some(smooth), jitter.is_none().then_some(0.0)];
        let usual = |bin| pairs(&self.turns, bin).copied().collect();
        let seen = bends.into_iter().flatten().map(|bend| {
            let low = low_orders(time, bend, plan);
            let seen = Seen { duration, bin, low };
            (seen, bend, self.agreement.off(&seen, &usual))
        });
        let closest = seen.min_by(|one, other| one.2.0.total_cmp(&other.2.0));
        let (seen, bend, (_, far)) = closest.expect("one bend at least");
        if far && self.agreement.reject(seen, &usual) {
            return None;
        }
        let pair = self.agreement.take(seen, !far);
        // The angle is tau - bend tau (1 - tau).
        let angle = |tau: f64| tau - bend * tau * (1.0 - tau);
        let place = |k: usize| k as f64 / plan.edges as f64;
        let sign = if self.turns.len().count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let error = (0..plan.edges).map(|k| place(k) - angle(time[k] / whole));
        self.turns.push(Turn {
            error: error.collect(),
            course: Vec::new(),
            ratio,
            bin,
            sign,
            pair,
            jitter,
        });
        Some(bend == smooth)
    }
}

/// The pairs of turns compared in a bin.
pub(super) fn pairs(turns: &[Turn], bin: i32) -> impl Iterator<Item = &Squares> {
    let of_bin = turns.iter().filter(move |turn| turn.bin == bin);
    of_bin.filter_map(|turn| turn.pair.as_ref())
}

/// The lowest orders of how far a turn's crossings are off a motion with this bend, in durations of the turn before.
fn low_orders(time: &[f64], bend: f64, plan: Plan) -> [Complex64; LOW_ORDERS] {
    let tau_at = |x: f64| {
        let half = 1.0 - bend;
        2.0 * x / (half + (half * half + 4.0 * bend * x).sqrt())
    };
    let off_motion: Vec<f64> = (0..plan.edges)
        .step_by(plan.sample)
        .map(|k| time[k] - time[plan.edges] * tau_at(k as f64 / plan.edges as f64))
        .collect();
    std::array::from_fn(|index| coefficient(&off_motion, index + 1))
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

/// The same of errors without the speed's own course.
pub(super) fn straight(turns: &[Turn], shares: &[f64], apart: usize) -> Vec<f64> {
    let mut sum = combine(turns, shares, apart);
    for (turn, share) in turns.iter().zip(shares) {
        for (sum, course) in sum.iter_mut().zip(turn.course.iter().step_by(apart)) {
            *sum -= share * course;
        }
    }
    sum
}
