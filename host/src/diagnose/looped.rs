//! The course of a shaft that a speed loop drives, from the edges that the loop saw.

use std::f64::consts::TAU;
use std::ops::Range;

use quadcal::edge::Direction;

use super::shaft::{Leap, ShaftLaw, State};
use super::ties::Tie;
use super::track::{Mark, Track};
use super::turning::Course;
use crate::twin::{SeenSpeed, SpeedLoop, Twin};

/// Least error of a stamp that a tie is reckoned with, s.
pub const TIED_JITTER_S: f64 = 3e-7;

/// Times as far apart that edge and sample of a tie may be that was decided.
const DECIDED: f64 = 4.0;

/// A shaft that a speed loop drives.
#[derive(Clone, Debug, Default)]
pub struct Looped {
    /// Where it is at each mark.
    pub course: Course,
    /// How its way over the interval before each mark is bent, rad/s^2: the steady acceleration that would have it as far off the
    /// straight way half-way.
    pub bends: Vec<f64>,
    /// Samples that may have seen an edge or not.
    pub ties: Vec<Tie>,
}

/// The shaft as a speed loop sends it that saw these edges as they were captured, at the times at which their marks passed. The push
/// before the first is not known: a constant one is anyone's guess.
#[must_use]
pub fn looped(
    captured: &[(Mark, i64)],
    passed: &[(Mark, i64)],
    track: &Track,
    twin: &Twin,
    model: &SpeedLoop,
) -> Looped {
    let step = TAU / track.edges as f64;
    let clock_hz = twin.timer.clock_hz as f64;
    let shaft = &twin.shaft;
    let target = model.target_rad_s;
    let spring = ShaftLaw::of(twin).spring;
    let friction =
        |speed: f64| twin.friction_n_m(speed.abs()) * speed.signum() / shaft.inertia_kg_m2;
    let mut saw = SeenSpeed::new(clock_hz, step, model.timeout_s, None);
    let Some((first, _)) = captured.first() else {
        return Looped::default();
    };
    let mut ties = Vec::new();
    let mut state = [first.place as f64 * step, target, 0.0, 0.0];
    let mut now = first.time_s;
    let mut sample = (now * model.rate_hz).ceil();
    let (mut integral, mut push) = (model.start, model.start);
    let mut before: Option<i64> = None;
    // What it saw before the first mark is not known: the course begins once it has sampled what is.
    let (mut sampled, mut begun) = (0, false);
    // A sample at the very time of an edge may have seen it or not: either way it pushes a little otherwise.
    let jitter_s = twin.timer.jitter_s.max(TIED_JITTER_S);
    let stamp_s = jitter_s.hypot(track.tick_s);
    // Ties that were decided are all found again, whatever stamps were then thought to be.
    let wider = if track.turned.is_some() { DECIDED } else { 1.0 };
    let tie_s = wider * (5.0 * stamp_s + track.tick_s);
    let (mut last_edge, mut speed_before) = (first.time_s, target);
    let go = |state: State, push: f64, after_s: f64| {
        let leap = Leap {
            after_s,
            damping: shaft.viscous_n_m_s / shaft.inertia_kg_m2,
            spring,
        };
        let push = push - friction(state[1]);
        leap.step(state, [push; 3])
    };
    let mut bends = Vec::with_capacity(captured.len());
    let each = captured
        .iter()
        .zip(passed)
        .map(|((mark, direction), (passed, _))| {
            let whole = last_edge..mark.time_s;
            let mut bend = 0.0;
            while sample / model.rate_hz < mark.time_s {
                let time = sample / model.rate_hz;
                bend += push * weight(&whole, &(now..time));
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
            bend += push * weight(&whole, &(now..mark.time_s));
            bends.push(bend);
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
                state = [mark.place as f64 * step, target, 0.0, 0.0];
            }
            Some((
                state[0] - state[1] * (mark.time_s - passed.time_s),
                target,
                0.0,
            ))
        });
    let course = each.collect();
    Looped {
        course,
        bends,
        ties,
    }
}

/// What a push over a part of an interval counts for in how far off the straight way the shaft is half-way: the integral of a triangle
/// over the whole, which is 1.
fn weight(whole: &Range<f64>, part: &Range<f64>) -> f64 {
    let length = whole.end - whole.start;
    if length <= 0.0 {
        return 0.0;
    }
    let below = |time: f64| {
        let share = ((time - whole.start) / length).clamp(0.0, 1.0);
        let short = share.min(1.0 - share);
        let rising = 2.0 * short * short;
        if share < 0.5 { rising } else { 1.0 - rising }
    };
    below(part.end) - below(part.start)
}
