//! The speed of the shaft at each edge, as the edges beside it have it.

use super::super::super::seen::Seen;

/// Edges to either side at the least.
const BESIDE: usize = 8;

/// Speeds, rad/s, negative in reverse: the twin's, and what edges to either side have gone more than it. Stamps are less what was taken
/// off them, s; those in doubt say nothing.
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
    let first = seen.angles.first().copied().unwrap_or(0.0);
    let begin_s = seen.times_s.first().copied().unwrap_or(0.0);
    for (at, reading) in seen.readings.iter().enumerate() {
        let sure = f64::from(u8::from(reading.doubt_s == 0.0));
        let broken = f64::from(u8::from(reading.fresh || reading.anew));
        let angle = seen.angles[at] - first + seen.speeds[at] * removed_s[at];
        let time_s = seen.times_s[at] - begin_s - removed_s[at];
        let more = [sure, sure * time_s, sure * angle, broken];
        sum.iter_mut()
            .zip(more)
            .for_each(|(sum, more)| *sum += more);
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
        // What is far from the twin's way is no wander.
        let speed = seen.speeds[at];
        if more.abs() < 0.3 * speed.abs() {
            speed + more
        } else {
            speed
        }
    });
    each.collect()
}
