//! The course of a shaft that runs down, from the speed that it really has.
//!
//! Friction goes with the speed. A twin that lacks some of it slows down otherwise, soon turns at another speed, and brakes by another
//! friction there: nothing that is linear about its own course says what is missing. What the twin's friction does at the recording's
//! speed is known, though, as a speed loop's push is (see [`super::looped`]): taken off along the recorded way, it leaves what is
//! missing in proportion to its size, however large that is.

use super::track::{Mark, Track};
use super::turning::{Course, speeds};
use crate::twin::{Drive, Twin};

/// When the drive of a run-down goes off, s; none of another drive.
#[must_use]
pub const fn off_s(twin: &Twin) -> Option<f64> {
    match twin.drive {
        Drive::RunDown { off_s, .. } => Some(off_s),
        _ => None,
    }
}

/// The course from the first mark on after the drive goes off, which begins as the twin's does; the twin's before.
#[must_use]
pub fn braked(marks: &[(Mark, i64)], track: &Track, twin: &Twin, mut course: Course) -> Course {
    let Some(off_s) = off_s(twin) else {
        return course;
    };
    let first = marks.partition_point(|(mark, _)| mark.time_s < off_s);
    let Some(Some((angle, speed, _))) = course.get(first).copied() else {
        return course;
    };
    let shaft = &twin.shaft;
    let brake = |speed: f64| {
        let friction = shaft.viscous_n_m_s * speed.abs() + twin.friction_n_m(speed.abs());
        -friction * speed.signum() / shaft.inertia_kg_m2
    };
    let own = middles(&marks[first..], track);
    let (mut state, mut now) = ([angle, speed], marks[first].0.time_s);
    let (mut near, mut last) = (0, brake(at(&own, &mut 0, now)));
    for (there, (mark, _)) in course[first..].iter_mut().zip(&marks[first..]) {
        let after_s = mark.time_s - now;
        let next = brake(at(&own, &mut near, mark.time_s));
        // Braking that goes evenly from mark to mark.
        state[0] += after_s * (state[1] + after_s * (2.0 * last + next) / 6.0);
        state[1] += 0.5 * after_s * (last + next);
        (now, last) = (mark.time_s, next);
        *there = Some((state[0], state[1], 0.0));
    }
    course
}

/// Times, s, and speeds there, rad/s: each is the mean over some marks, so it is that of their middle.
fn middles(marks: &[(Mark, i64)], track: &Track) -> Vec<(f64, f64)> {
    let all = speeds(marks, track);
    let half = super::turning::half_window(track);
    let each = all.into_iter().enumerate().filter_map(|(at, speed)| {
        let whole = at >= half && at + half < marks.len();
        let middle_s = 0.5
            * (marks[at.saturating_sub(half)].0.time_s
                + marks[(at + half).min(marks.len() - 1)].0.time_s);
        whole.then_some((middle_s, speed?))
    });
    each.collect()
}

/// Speed at a time, on the straight way between two; times only go on.
fn at(own: &[(f64, f64)], near: &mut usize, time_s: f64) -> f64 {
    while *near + 2 < own.len() && own[*near + 1].0 < time_s {
        *near += 1;
    }
    match own.get(*near..*near + 2) {
        Some([(a_s, a), (b_s, b)]) if b_s > a_s => a + (b - a) * (time_s - a_s) / (b_s - a_s),
        _ => own.get(*near).map_or(0.0, |one| one.1),
    }
}
