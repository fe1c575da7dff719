//! The course of a shaft that a speed loop drives, from the edges that the loop saw.

use std::f64::consts::TAU;

use quadcal::edge::Direction;

use super::shaft::Leap;
use super::ties::Tie;
use super::track::{Mark, Track};
use super::turning::Course;
use crate::twin::{SeenSpeed, SpeedLoop, Twin};

/// Least error of a stamp that a tie is reckoned with, s.
pub const TIED_JITTER_S: f64 = 3e-7;

/// The shaft as a speed loop sends it that saw these edges as they were captured, at the times at which their marks passed. The push
/// before the first is not known: a constant one is anyone's guess.
#[must_use]
pub fn looped(
    captured: &[(Mark, i64)],
    passed: &[(Mark, i64)],
    track: &Track,
    twin: &Twin,
    model: &SpeedLoop,
) -> (Course, Vec<Tie>) {
    let step = TAU / track.edges as f64;
    let clock_hz = twin.timer.clock_hz as f64;
    let shaft = &twin.shaft;
    let target = model.target_rad_s;
    let friction =
        |speed: f64| twin.friction_n_m(speed.abs()) * speed.signum() / shaft.inertia_kg_m2;
    let mut saw = SeenSpeed::new(clock_hz, step, model.timeout_s, None);
    let Some((first, _)) = captured.first() else {
        return (Course::new(), Vec::new());
    };
    let mut ties = Vec::new();
    let mut state = [first.place as f64 * step, target];
    let mut now = first.time_s;
    let mut sample = (now * model.rate_hz).ceil();
    let (mut integral, mut push) = (model.start, model.start);
    let mut before: Option<i64> = None;
    // What it saw before the first mark is not known: the course begins once it has sampled what is.
    let (mut sampled, mut begun) = (0, false);
    // A sample at the very time of an edge may have seen it or not: either way it pushes a little otherwise.
    let jitter_s = twin.timer.jitter_s.max(TIED_JITTER_S);
    let stamp_s = jitter_s.hypot(track.tick_s);
    let tie_s = 5.0 * stamp_s + track.tick_s;
    let (mut last_edge, mut speed_before) = (first.time_s, target);
    let go = |state: [f64; 2], push: f64, after_s: f64| {
        let leap = Leap {
            after_s,
            damping: shaft.viscous_n_m_s / shaft.inertia_kg_m2,
        };
        let push = push - friction(state[1]);
        leap.step(state, [push; 3])
    };
    let each = captured
        .iter()
        .zip(passed)
        .map(|((mark, direction), (passed, _))| {
            while sample / model.rate_hz < mark.time_s {
                let time = sample / model.rate_hz;
                state = go(state, push, (time - now).max(0.0));
                now = now.max(time);
                let seen = saw.at((time * clock_hz).floor());
                sampled += i32::from(seen.is_some());
                let here = seen.unwrap_or(target);
                let otherwise = if mark.time_s - time < tie_s {
                    let next =
                        *direction as f64 * step / (mark.time_s - last_edge).max(track.tick_s);
                    Some((next, mark.time_s - time))
                } else if time - last_edge < tie_s {
                    Some((speed_before, time - last_edge))
                } else {
                    None
                };
                if let Some((other, apart_s)) = otherwise.filter(|_| begun) {
                    ties.push(Tie {
                        at_s: time,
                        until_s: time + 1.0 / model.rate_hz,
                        apart_s,
                        push: model.gains.kp * (here - other),
                        after: model.gains.ki / model.rate_hz * (here - other),
                        turned: false,
                    });
                }
                let miss = target - seen.unwrap_or(target);
                let asked = model.gains.kp * miss + integral;
                push = asked.clamp(-model.limit, model.limit);
                if push == asked || miss * asked < 0.0 {
                    integral += model.gains.ki / model.rate_hz * miss;
                }
                sample += 1.0;
            }
            state = go(state, push, mark.time_s - now);
            now = mark.time_s;
            let steps = before.map_or(1, |place| (mark.place - place).abs().max(1));
            before = Some(mark.place);
            let way = if *direction > 0 {
                Direction::Forward
            } else {
                Direction::Reverse
            };
            let ticks = (mark.time_s / track.tick_s).round() as u64;
            speed_before = saw.at(ticks as f64).unwrap_or(target);
            saw.edge(ticks, way, u32::try_from(steps).unwrap_or(1));
            last_edge = mark.time_s;
            if !begun && sampled < 2 {
                return None;
            }
            if !begun {
                begun = true;
                state = [mark.place as f64 * step, target];
            }
            Some((
                state[0] - state[1] * (mark.time_s - passed.time_s),
                target,
                0.0,
            ))
        });
    let course = each.collect();
    (course, ties)
}
