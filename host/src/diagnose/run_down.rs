//! The course of a shaft that runs down, from the speed that it really has.
//!
//! Friction goes with the speed. A twin that lacks some of it slows down otherwise, soon turns at another speed, and brakes by another
//! friction there: nothing that is linear about its own course says what is missing. What the twin's friction does at the recording's
//! speed is known, though, as a speed loop's push is (see [`super::looped`]): taken off along the recorded way, it leaves what is
//! missing in proportion to its size, however large that is. Where the twin's own course is near, it is the better one: it is exact.

use std::f64::consts::TAU;

use super::track::{Mark, Track};
use super::turning::Course;
use crate::twin::{Drive, Twin};

/// Times that a speed is measured anew at the least.
const FEW: usize = 20;

/// The course from the first mark on after the drive goes off, which begins as the twin's does, and when that is, s; none where the
/// twin's own course will do.
#[must_use]
pub fn braked(
    marks: &[(Mark, i64)],
    track: &Track,
    twin: &Twin,
    course: &Course,
) -> Option<(Course, f64)> {
    let Drive::RunDown { off_s, .. } = twin.drive else {
        return None;
    };
    let first = marks.partition_point(|(mark, _)| mark.time_s < off_s);
    let (angle, speed, _) = (*course.get(first)?)?;
    let shaft = &twin.shaft;
    let brake = |speed: f64| {
        let friction = shaft.viscous_n_m_s * speed.abs() + twin.friction_n_m(speed.abs());
        -friction * speed.signum() / shaft.inertia_kg_m2
    };
    let own = middles(&marks[first..], track);
    if near_by(&own, &marks[first..], &course[first..]) {
        return None;
    }
    let mut course = course.clone();
    // Where it first turns round it has come to rest, or a ripple sends it to and fro.
    let way = marks[first].1;
    let rests = marks[first..]
        .iter()
        .position(|(_, direction)| *direction != way);
    let end = rests.map_or(marks.len(), |rests| first + rests);
    course[end..].fill(None);
    let (mut state, mut now) = ([angle, speed], marks[first].0.time_s);
    let (mut near, mut last) = (0, brake(at(&own, &mut 0, now)));
    for (there, (mark, _)) in course[first..end].iter_mut().zip(&marks[first..end]) {
        let after_s = mark.time_s - now;
        let next = brake(at(&own, &mut near, mark.time_s));
        // Braking that goes evenly from mark to mark.
        state[0] += after_s * (state[1] + after_s * (2.0 * last + next) / 6.0);
        state[1] += 0.5 * after_s * (last + next);
        (now, last) = (mark.time_s, next);
        *there = Some((state[0], state[1], 0.0));
    }
    Some((course, off_s))
}

/// Whether the twin's own course is near enough to be linear about.
fn near_by(own: &[(f64, f64)], marks: &[(Mark, i64)], course: &[Option<(f64, f64, f64)>]) -> bool {
    /// Part of the top speed by which the speeds differ at the most.
    const APART: f64 = 0.1;
    let top = own.iter().map(|(_, speed)| speed.abs()).fold(0.0, f64::max);
    let mut near = 0;
    let mut each = marks.iter().zip(course).filter_map(|((mark, _), there)| {
        let speed = there.map_or(0.0, |(_, speed, _)| speed);
        let inside = own.first()?.0 < mark.time_s && mark.time_s < own.last()?.0;
        inside.then(|| (at(own, &mut near, mark.time_s) - speed).abs())
    });
    each.all(|apart| apart < APART * top)
}

/// Times, s, and speeds there, rad/s: each is the mean over a turn, in which the disc's errors and ripple cancel, so it is that of the
/// turn's middle; over less where there are few turns.
fn middles(marks: &[(Mark, i64)], track: &Track) -> Vec<(f64, f64)> {
    let turn = usize::try_from(track.edges).unwrap_or(1);
    let over = turn.min(marks.len() / FEW).max(1);
    let step = TAU / track.edges as f64;
    let pairs = marks.iter().zip(marks.iter().skip(over));
    let each = pairs.map(|((first, _), (last, _))| {
        let (way, time_s) = (last.place - first.place, last.time_s - first.time_s);
        let middle_s = 0.5 * (first.time_s + last.time_s);
        (middle_s, way as f64 * step / time_s)
    });
    each.filter(|(_, speed)| speed.is_finite()).collect()
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
