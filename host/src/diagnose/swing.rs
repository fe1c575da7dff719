//! What the twin's own torques do to the shaft along the way that it really went.
//!
//! A torque that goes with the angle acts at the shaft's true angle: that of each edge at its time, and in between on the way from
//! edge to edge, with the swing that the torques themselves give it. A strong ripple against a coarse encoder swings the shaft by a
//! good part of a cycle between two edges, so the swing is found in passes, each along the way that the one before it found.

use std::f64::consts::TAU;

use super::seen::Seen;
use super::shaft::{AT_REST, Leap, ShaftLaw};
use crate::twin::Twin;

/// Radians of the fastest rhythm that a step may take.
const STEP: f64 = 0.5;
/// Steps from edge to edge at the most.
const STEPS_MOST: f64 = 400.0;
/// Passes at the most: each adds a power of the swing over a cycle.
const PASSES: usize = 8;
/// Swing over a cycle, rad, that no second pass is needed for.
const SLIGHT: f64 = 1e-4;
/// Change of the swing from pass to pass, over a cycle, rad, that is small enough.
const SMALL: f64 = 1e-6;
/// Square of the phase by which the torques alone would swing a shaft within an interval, from which on its ends do not say its way.
const UNSEEN: f64 = 8.0;

/// One torque: its rate, cycles a turn or Hz, acceleration, rad/s^2, and phase, rad.
#[derive(Clone, Copy, Debug)]
struct Torque {
    rate: f64,
    acceleration: f64,
    phase: f64,
}

/// The torques of a twin that keep step with turn or time.
#[derive(Clone, Debug, Default)]
pub struct Torques {
    turning: Vec<Torque>,
    tones: Vec<Torque>,
}

impl Torques {
    /// Of a twin.
    #[must_use]
    pub fn of(twin: &Twin, law: &ShaftLaw) -> Self {
        let tones = twin.torque_tone.iter().map(|tone| Torque {
            rate: TAU * tone.f_hz,
            acceleration: tone.torque_n_m.unwrap_or(0.0) / law.inertia,
            phase: tone.phase_rad,
        });
        Self {
            turning: turning(twin, law),
            tones: tones.collect(),
        }
    }

    /// Most cycles a turn of a torque that goes with the angle; 0 where none does.
    #[must_use]
    pub fn order(&self) -> f64 {
        self.turning
            .iter()
            .map(|t| t.rate.abs())
            .fold(0.0, f64::max)
    }
}

/// What the torques do to the shaft along a residual.
#[derive(Clone, Debug)]
pub struct Swing {
    /// Angle that they give each edge, rad.
    pub angles: Vec<f64>,
    /// Speed that they give it at each edge, rad/s.
    pub speeds: Vec<f64>,
    /// How well the way of the interval before each edge is known.
    pub ways: Vec<Known>,
}

/// How well the way of an interval is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// Its ends say it, but for a speed at its end that may be off by so much, rad/s.
    Within(f64),
    /// It may have gone to and fro unseen.
    Unseen,
}

/// What the torques do.
#[must_use]
pub fn swing(seen: &Seen, torques: &Torques) -> Swing {
    let Torques { turning, tones } = torques;
    let mut angles = vec![0.0; seen.len()];
    let mut speeds = vec![0.0; seen.len()];
    let mut ways = vec![Known::Within(0.0); seen.len()];
    if turning.is_empty() && tones.is_empty() {
        return Swing {
            angles,
            speeds,
            ways,
        };
    }
    let fastest = |torques: &[Torque]| torques.iter().map(|t| t.rate.abs()).fold(0.0, f64::max);
    let (order, pulsation) = (fastest(turning), fastest(tones));
    let hardest: f64 = turning.iter().map(|t| t.acceleration.abs()).sum();
    let stiffness: f64 = turning
        .iter()
        .map(|t| (t.rate * t.acceleration).abs())
        .sum();
    let theta: Vec<f64> = (0..seen.len()).map(|at| seen.true_theta(at)).collect();
    let mut path = Path::default();
    let mut gains = vec![0.0; seen.len()];
    for pass in 0..PASSES {
        let before = std::mem::take(&mut path);
        let mut state = AT_REST;
        let mut cursor = 0;
        let (mut most, mut furthest) = (0.0_f64, 0.0_f64);
        for at in 1..seen.len() {
            let whole = seen.readings[at].leap;
            let came = theta[at] - theta[at - 1];
            let bend = seen.bends[at];
            let bowed = 0.25 * (hardest + bend.abs()) * whole.after_s * whole.after_s;
            let cycles = order * (came.abs() + bowed) + pulsation * whole.after_s;
            let steps = (cycles / STEP).ceil().clamp(1.0, STEPS_MOST);
            let leap = Leap {
                after_s: whole.after_s / steps,
                ..whole
            };
            let half_leap = Leap {
                after_s: 0.5 * leap.after_s,
                ..leap
            };
            let (stride, half_stride) = (leap.stride(), half_leap.stride());
            // Twice as many places as steps: middles count too.
            let places = 2 * steps as usize;
            let push = |place: usize| {
                let share = place as f64 / places as f64;
                let off = before.at(cursor, place, places);
                let bow = 0.5 * bend * share * (share - 1.0) * whole.after_s * whole.after_s;
                let angle = theta[at - 1] + share * came + bow + off;
                let time = seen.times_s[at] - (1.0 - share) * whole.after_s;
                sum(turning, angle) + sum(tones, time)
            };
            path.swings.push(state[0]);
            let free = whole.step(state, [0.0; 3]);
            let mut first = push(0);
            for step in 0..places / 2 {
                let [half, last] = [push(2 * step + 1), push(2 * step + 2)];
                let middle = half_stride.step(state, [first, 0.5 * (first + half), half]);
                state = stride.step(state, [first, half, last]);
                path.swings.extend([middle[0], state[0]]);
                first = last;
            }
            cursor += places + 1;
            let gain = state[1] - free[1];
            let change = (gain - std::mem::replace(&mut gains[at], gain)).abs();
            furthest = furthest.max(change * whole.after_s);
            ways[at] = if stiffness * whole.after_s * whole.after_s > UNSEEN {
                Known::Unseen
            } else {
                Known::Within(change)
            };
            if seen.follows(at) {
                state = AT_REST;
            }
            [angles[at], speeds[at], ..] = state;
            most = most.max(state[0].abs());
        }
        // The first pass goes the straight way, which a slight swing hardly leaves.
        if pass == 0 && order * most < SLIGHT {
            ways.fill(Known::Within(0.0));
            break;
        }
        if order * furthest < SMALL {
            break;
        }
    }
    Swing {
        angles,
        speeds,
        ways,
    }
}

/// Swings of a pass at every place of every interval, its ends included.
#[derive(Debug, Default)]
struct Path {
    swings: Vec<f64>,
}

impl Path {
    /// How far the shaft is off the straight way between two edges, at a place of the interval that begins at `first`.
    fn at(&self, first: usize, place: usize, places: usize) -> f64 {
        let Some(swings) = self.swings.get(first..=first + places) else {
            return 0.0;
        };
        let share = place as f64 / places as f64;
        swings[place] - (1.0 - share) * swings[0] - share * swings[places]
    }
}

/// Torques that go with the angle.
fn turning(twin: &Twin, law: &ShaftLaw) -> Vec<Torque> {
    let ripples = twin.ripple.iter().chain(&twin.gear_mesh);
    let ripples = ripples.map(|r| (r.order, r.torque_n_m, r.phase_rad));
    let bearings = twin
        .bearing
        .iter()
        .map(|b| (b.order, b.torque_n_m, b.phase_rad));
    ripples
        .chain(bearings)
        .filter_map(|(order, torque_n_m, phase)| {
            Some(Torque {
                rate: order,
                acceleration: torque_n_m? / law.inertia,
                phase,
            })
        })
        .collect()
}

fn sum(torques: &[Torque], along: f64) -> f64 {
    torques
        .iter()
        .map(|t| t.acceleration * (t.rate * along + t.phase).sin())
        .sum()
}
