//! The speed of the shaft at each edge, as the edges beside it have it: what a delay makes of the angle goes by the real speed, wander
//! and all.

use super::seen::Seen;

/// Edges to either side at the least.
const BESIDE: usize = 8;
/// Part of the twin's speed that wander is less than.
const WANDER: f64 = 0.3;

/// Speeds, rad/s, negative in reverse: the twin's with its swing, and what edges to either side have gone more than it. Stamps are less
/// what was taken off them, s, where something was; those in doubt say nothing.
#[must_use]
pub fn pace(seen: &Seen, removed_s: &[f64]) -> Vec<f64> {
    let classes = usize::try_from(seen.classes).unwrap_or(1).max(1);
    // Whole lines, so that what channels are off cancels.
    let beside = classes * BESIDE.div_ceil(classes);
    let count = seen.len();
    // Sums of the edges before each: how many, when, where, and how often the count was in doubt.
    let mut sums = Vec::with_capacity(count + 1);
    let mut sum = [0.0; 4];
    sums.push(sum);
    let stamp_s = |at: usize| seen.times_s[at] - removed_s.get(at).copied().unwrap_or(0.0);
    let (mut begin_s, mut begin_rad, mut last_s, mut gone) = (0.0, 0.0, 0.0, 0.0);
    for (at, reading) in seen.readings.iter().enumerate() {
        let (time_s, theta) = (stamp_s(at), seen.true_theta(at));
        if at == 0 {
            (begin_s, begin_rad, last_s) = (time_s, theta, time_s);
        }
        // How far the twin would have gone without its swing.
        let before = seen.speeds[at.saturating_sub(1)];
        gone += 0.5 * (before + seen.speeds[at]) * (time_s - last_s);
        last_s = time_s;
        // A speed that was measured has it.
        let swing = seen.swings.get(at).copied().filter(|_| !seen.measured);
        let swing = swing.unwrap_or(0.0);
        let more = theta - begin_rad - gone - swing;
        let sure = f64::from(u8::from(reading.doubt_s == 0.0));
        let broken = f64::from(u8::from(reading.fresh || reading.anew));
        let all = [sure, sure * (time_s - begin_s), sure * more, broken];
        sum.iter_mut().zip(all).for_each(|(sum, one)| *sum += one);
        sums.push(sum);
    }
    let mean = |range: std::ops::Range<usize>| {
        let [count, time, angle, _] =
            std::array::from_fn(|i| sums[range.end][i] - sums[range.start][i]);
        (count > 0.5).then(|| (time / count, angle / count))
    };
    let each = (0..count).map(|at| {
        let (from, until) = (at.saturating_sub(beside), (at + 1 + beside).min(count));
        let more = mean(from..at).zip(mean(at + 1..until));
        let whole = sums[until][3] - sums[from + 1][3] < 0.5;
        let more = more.filter(|_| whole).map_or(0.0, |(before, after)| {
            (after.1 - before.1) / (after.0 - before.0)
        });
        let swung = seen.swung.get(at).copied().unwrap_or(0.0);
        // What is far from the twin's way is no wander.
        let wander = Some(more).filter(|more| more.abs() < WANDER * seen.speeds[at].abs());
        seen.speeds[at] + swung + wander.unwrap_or(0.0)
    });
    each.collect()
}
