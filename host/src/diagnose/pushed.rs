//! Pushes of a shaft that the twin leaves to itself.
//!
//! From the end of a run-down's drive on, nothing in the twin turns the shaft. Where a recording gains speed all the same, again and
//! again, something does: a rower, a hand, a machine that is fed. How hard it pushes is not known, so nothing is asked of those
//! stretches but where the disc's edges are; each run-down between them starts at the recording's own speed.

use std::ops::Range;

use super::track::{Mark, Track};
use super::turning::{Course, speeds};
use crate::twin::{Drive, Twin};

/// Gain of speed that makes a push, over the highest speed: far more than what noise and ripple do to the mean of a turn.
const GAIN: f64 = 0.05;
/// Pushes that there must be: one or two are steps of a load.
const LEAST: usize = 3;
/// Uncertainty of the speed over itself that a push brings, at its first two edges and at every other.
const JOLTS: [f64; 2] = [0.2, 0.02];

/// One push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// From when, s.
    pub from_s: f64,
    /// Until when, s.
    pub until_s: f64,
    /// Speed at its start and end, rad/s.
    pub speeds: [f64; 2],
}

/// Pushes of a recording against its twin.
#[must_use]
pub fn pushes(track: &Track, twin: &Twin) -> Vec<Push> {
    let marks = track.directed();
    let speeds = speeds(&marks, track);
    let each = ranges(&marks, &speeds, track, twin).into_iter();
    let speed = |at: usize| speeds.get(at).copied().flatten().unwrap_or(0.0);
    each.map(|range| Push {
        from_s: marks[range.start].0.time_s,
        until_s: marks[range.end - 1].0.time_s,
        speeds: [speed(range.start), speed(range.end - 1)],
    })
    .collect()
}

/// Marks under each push, a turn before and after included: the mean of a turn shows a push that late.
fn ranges(
    marks: &[(Mark, i64)],
    speeds: &[Option<f64>],
    track: &Track,
    twin: &Twin,
) -> Vec<Range<usize>> {
    let Drive::RunDown { off_s, .. } = twin.drive else {
        return Vec::new();
    };
    if track.reverses() {
        return Vec::new();
    }
    let size = |at: usize| speeds[at].map_or(0.0, f64::abs);
    let top = (0..marks.len()).map(size).fold(0.0, f64::max);
    let turn = track.edges as usize;
    let first = marks.partition_point(|(mark, _)| mark.time_s < off_s);
    let mut found: Vec<Range<usize>> = Vec::new();
    let (mut low, mut high) = (first, first);
    let mut rising = false;
    for at in first..marks.len() {
        if rising {
            if size(at) > size(high) {
                high = at;
            } else if size(at) < size(high) - GAIN * top || at + 1 == marks.len() {
                let range = low.saturating_sub(turn).max(first)..(high + turn).min(marks.len());
                match found.last_mut() {
                    Some(last) if last.end >= range.start => last.end = range.end,
                    _ => found.push(range),
                }
                (rising, low) = (false, at);
            }
        } else if size(at) < size(low) {
            low = at;
        } else if size(at) > size(low) + GAIN * top {
            (rising, high) = (true, at);
        }
    }
    if found.len() < LEAST {
        found.clear();
    }
    found
}

/// The shaft's course where it is pushed; none where it is not.
#[must_use]
pub(super) fn course(marks: &[(Mark, i64)], track: &Track, twin: &Twin) -> Option<Course> {
    if !matches!(twin.drive, Drive::RunDown { .. }) {
        return None;
    }
    let speeds = speeds(marks, track);
    let ranges = ranges(marks, &speeds, track, twin);
    if ranges.is_empty() {
        return None;
    }
    let shaft = &twin.shaft;
    let brake = |speed: f64| {
        let friction = shaft.viscous_n_m_s * speed.abs() + twin.friction_n_m(speed.abs());
        -friction * speed.signum() / shaft.inertia_kg_m2
    };
    let step = std::f64::consts::TAU / track.edges as f64;
    let first = marks.first()?.0;
    let (mut angle, mut now) = (first.place as f64 * step, first.time_s);
    let mut speed = speeds.iter().flatten().next().copied()?;
    let mut pushes = ranges.iter().peekable();
    let each = marks.iter().enumerate().map(|(at, (mark, _))| {
        while pushes.next_if(|push| push.end <= at).is_some() {}
        let after_s = mark.time_s - now;
        now = mark.time_s;
        let pushed = pushes.peek().is_some_and(|push| push.contains(&at));
        let start = pushes.peek().map_or(0, |push| push.start);
        let begins = pushed && start == at;
        if pushed {
            let here = speeds[at].unwrap_or(speed);
            if begins {
                angle = mark.place as f64 * step;
            } else {
                angle += 0.5 * (speed + here) * after_s;
            }
            speed = here;
        } else {
            let middle = brake(speed + 0.5 * after_s * brake(speed));
            angle += (speed + 0.5 * after_s * middle) * after_s;
            speed += after_s * middle;
        }
        let jolt = match pushed {
            // The angle starts anew at the first edge, so that the speed does at the second.
            true if at < start + 2 => JOLTS[0] * speed,
            true => JOLTS[1] * speed,
            false => 0.0,
        };
        Some((angle, speed, jolt * jolt))
    });
    Some(each.collect())
}
