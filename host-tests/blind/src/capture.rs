//! The capture unit: from marks crossed to rows of ticks and levels.

use crate::effect::{Effect, Site};
use crate::random::Dice;
use crate::rig::Rig;
use crate::turning::{Course, Crossing};

/// One row: ticks and the levels as bits 1, 2, 4, 8 of A, B, C, Z.
pub type Row = (u64, u8);

/// Time of each crossing as it would be stamped without any noise, s: delays and blocked captures included.
#[must_use]
pub fn arrivals(course: &Course, rig: &Rig, effects: &[Effect]) -> Vec<f64> {
    course
        .crossings
        .iter()
        .map(|crossing| {
            let channel = crossing.bit.trailing_zeros() as usize;
            let mut time = crossing.time_s;
            if crossing.class.is_some() {
                for effect in effects {
                    time += effect.delay_s(channel, crossing.high) + late_s(effect, rig, crossing);
                }
            }
            effects.iter().fold(time, |time, effect| match effect {
                Effect::CaptureTask {
                    task_hz,
                    busy_s,
                    phase_s,
                } => {
                    let since = (time - phase_s).rem_euclid(1.0 / task_hz);
                    if since < *busy_s {
                        time - since + busy_s
                    } else {
                        time
                    }
                }
                _ => time,
            })
        })
        .collect()
}

/// By how much an effect put together makes a stamp late, s.
fn late_s(effect: &Effect, rig: &Rig, crossing: &Crossing) -> f64 {
    match effect {
        Effect::Cell(cell) if cell.site == Site::Stamp && cell.touches(crossing.class) => {
            let theta = crossing.place as f64 * rig.encoder.step_rad();
            cell.value(crossing.time_s, crossing.time_s, theta, crossing.speed)
        }
        _ => 0.0,
    }
}

/// What the random part of an effect adds to a stamp.
struct Errors<'a> {
    effect: &'a Effect,
    dice: Dice,
    bursts: Vec<f64>,
}

impl<'a> Errors<'a> {
    fn new(effect: &'a Effect, seed: u64, until_s: f64) -> Self {
        let mut bursts = Vec::new();
        if let Effect::BurstNoise { rate_hz, seed, .. } = effect {
            let mut dice = Dice::new(*seed, 0);
            let mut at = dice.exponential() / rate_hz;
            while at < until_s {
                bursts.push(at);
                at += dice.exponential() / rate_hz;
            }
        }
        Self {
            effect,
            dice: Dice::new(seed, 4),
            bursts,
        }
    }

    fn of(&mut self, crossing: &Crossing) -> f64 {
        match self.effect {
            Effect::TimestampJitter { jitter_s } => jitter_s * self.dice.normal(),
            Effect::CaptureLatency { mean_s } => mean_s * self.dice.exponential(),
            Effect::BurstNoise {
                angle_rad,
                share,
                rate_hz,
                ..
            } => {
                let normal = self.dice.normal();
                let last = self.bursts.partition_point(|&b| b <= crossing.time_s);
                let within = last > 0 && crossing.time_s - self.bursts[last - 1] < share / rate_hz;
                if within {
                    angle_rad * normal / crossing.speed.abs()
                } else {
                    0.0
                }
            }
            _ => 0.0,
        }
    }
}

/// Rows of a recording, and the times at which edges were lost or added, s.
#[must_use]
pub fn rows(course: &Course, rig: &Rig, effects: &[Effect], seed: u64) -> (Vec<Row>, Vec<f64>) {
    let clock = rig.clock_hz as f64;
    let crossings = &course.crossings;
    let until = crossings.last().map_or(0.0, |c| c.time_s);
    let mut errors: Vec<Errors> = (effects.iter().zip(10..))
        .map(|(effect, own)| Errors::new(effect, seed ^ own, until))
        .collect();
    let times = arrivals(course, rig, effects);
    // Time of arrival, of the stamp, bit to set or toggle, whether its capture is taken.
    let mut changes: Vec<(f64, f64, Change, bool)> = Vec::with_capacity(crossings.len());
    for (crossing, &time) in crossings.iter().zip(&times) {
        let random: f64 = errors.iter_mut().map(|e| e.of(crossing)).sum();
        let change = Change {
            bit: crossing.bit,
            to: Some(crossing.high),
        };
        changes.push((time, time + crossing.error_s + random, change, true));
    }
    let mut events = Vec::new();
    for effect in effects {
        faults(effect, rig, crossings, &times, &mut changes, &mut events);
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut levels = course.levels;
    let mut flipped = 0;
    let mut last = 0;
    let mut rows = Vec::with_capacity(changes.len());
    for (_, stamp, change, taken) in changes {
        match change.to {
            Some(true) => levels |= change.bit,
            Some(false) => levels &= !change.bit,
            None => flipped ^= change.bit,
        }
        if taken {
            // `as` holds negative times at 0; stamps never fall.
            last = last.max((stamp * clock).floor() as u64);
            rows.push((last, levels ^ flipped));
        }
    }
    (rows, events)
}

#[derive(Clone, Copy, Debug)]
struct Change {
    bit: u8,
    /// The level; none toggles it.
    to: Option<bool>,
}

/// Marks lost edges and adds glitches.
fn faults(
    effect: &Effect,
    rig: &Rig,
    crossings: &[Crossing],
    times: &[f64],
    changes: &mut Vec<(f64, f64, Change, bool)>,
    events: &mut Vec<f64>,
) {
    let (count, seed) = match effect {
        Effect::LostEdges { count, seed } | Effect::ExtraEdges { count, seed } => (*count, *seed),
        _ => return,
    };
    let mut dice = Dice::new(seed, 0);
    // Away from the ends and from each other, so that each is an event of its own.
    let share = crossings.len() as f64 * 0.9 / f64::from(count);
    for number in 0..count {
        let place =
            0.05 * crossings.len() as f64 + share * (f64::from(number) + dice.between(0.2, 0.8));
        let mut at = place as usize;
        while at + 2 < crossings.len() && crossings[at].class.is_none() {
            at += 1;
        }
        if at + 1 >= crossings.len() {
            continue;
        }
        events.push(times[at]);
        if matches!(effect, Effect::LostEdges { .. }) {
            changes[at].3 = false;
        } else {
            let interval = rig.encoder.step_rad() / crossings[at].speed.abs();
            let bit = 1 << (dice.unit() * rig.encoder.channels() as f64) as u8;
            let start = times[at] + interval * dice.between(0.2, 0.5);
            for time in [start, start + interval * dice.between(0.05, 0.2)] {
                changes.push((time, time, Change { bit, to: None }, true));
            }
        }
    }
}
