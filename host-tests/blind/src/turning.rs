//! Turning the shaft: from a rig and its effects to the times at which marks of the disc pass the head.

mod collect;
mod marks;
mod noise;
mod speed_loop;
mod sudden;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

pub use marks::Crossing;

use crate::effect::Effect;
use crate::motion::{Plant, sign};
use crate::random::Dice;
use crate::rig::{Profile, Rig};
use crate::step::{State, Step};
use marks::Track;
use noise::Noise;
use speed_loop::Loop;
use sudden::Sudden;

/// Largest estimated error of a step, rad.
const TOLERANCE_RAD: f64 = 2e-14;
/// Longest step, in radians of the quickest change.
const LONGEST_PHASE: f64 = 0.1;

/// What went by.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Marks crossed, by time.
    pub crossings: Vec<Crossing>,
    /// Levels of A, B, C and Z before the first, as bits.
    pub levels: u8,
    /// Smallest and largest speed at crossings, rad/s.
    pub speeds: (f64, f64),
}

/// Turns the shaft of a rig with effects; with a seed there is torque noise and jitter, without there is none.
#[must_use]
pub fn turn(rig: &Rig, effects: &[Effect], seed: Option<u64>) -> Course {
    Run::new(rig, effects, seed).run()
}

/// The same without noise, and with stamps that a speed loop sees unrounded, so that a small effect has a small answer.
#[must_use]
pub fn turn_evenly(rig: &Rig, effects: &[Effect]) -> Course {
    let mut run = Run::new(rig, effects, None);
    if let Some(control) = &mut run.speed_loop {
        control.rounds = false;
    }
    run.run()
}

impl Run<'_> {
    fn run(mut self) -> Course {
        while self.time_s < self.rig.longest_s && self.travelled < self.rig.turns * TAU {
            self.piece();
        }
        let speeds = self.course.crossings.iter().map(|c| c.speed);
        self.course.speeds = speeds.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        self.course
    }
}

struct Run<'a> {
    rig: &'a Rig,
    effects: &'a [Effect],
    plant: Plant<'a>,
    jumps: Vec<Vec<f64>>,
    moving: bool,
    play: f64,
    sudden: Sudden,
    noise: Option<Noise>,
    speed_loop: Option<Loop>,
    edges: Track,
    index: Option<Track>,
    state: State,
    motion: f64,
    time_s: f64,
    travelled: f64,
    step_s: f64,
    quickest: f64,
    course: Course,
}

impl<'a> Run<'a> {
    fn new(rig: &'a Rig, effects: &'a [Effect], seed: Option<u64>) -> Self {
        let plant = Plant::new(rig, effects);
        let jumps: Vec<_> = effects
            .iter()
            .map(|effect| effect.jumps(rig.longest_s, 2.0 * rig.turns + 10.0))
            .collect();
        let mut speed = plant.start_speed();
        let rate = rig.noise_psd / (rig.inertia * rig.inertia);
        let noise = seed.map(|seed| {
            let damping = rig.noise_damping(0.0);
            if damping > 0.0 && speed != 0.0 {
                speed += (rate / (2.0 * damping)).sqrt() * Dice::new(seed, 1).normal();
            }
            Noise::new(rig, seed)
        });
        let speed_loop = match rig.profile {
            Profile::Loop {
                speed,
                f_hz,
                kp_n_m_s,
                ki_n_m,
            } => Some(Loop {
                target: speed,
                rate_hz: f_hz,
                kp: kp_n_m_s,
                ki: ki_n_m,
                integral: plant.loop_start(),
                samples: 0,
                seen: None,
                last: None,
                rounds: true,
            }),
            _ => None,
        };
        let top = rig.profile.top();
        let quickest = effects
            .iter()
            .map(|effect| effect.quickest(top, rig.longest_s))
            .chain(rig.ripples.iter().map(|ripple| ripple.order * top))
            .fold(rig.damping(true).max(top), f64::max);
        let mut disc = rig.disc_rad.clone();
        for more in effects.iter().filter_map(|e| e.disc(rig.encoder)) {
            disc.iter_mut().zip(more).for_each(|(e, more)| *e += more);
        }
        let edges = Track::edges(rig, &disc);
        let index = rig.encoder.index().then(|| Track::index(rig, &disc));
        let levels = edges.levels | index.as_ref().map_or(0, |index| index.levels);
        Self {
            rig,
            effects,
            moving: effects.iter().any(Effect::moves_marks),
            play: effects.iter().map(Effect::play_rad).sum(),
            sudden: Sudden::new(rig, effects, &jumps),
            jumps,
            noise,
            speed_loop,
            edges,
            index,
            state: [rig.start_rad, speed, rig.start_rad, speed],
            motion: sign(speed),
            time_s: 0.0,
            travelled: 0.0,
            step_s: LONGEST_PHASE / quickest,
            quickest,
            plant,
            course: Course {
                levels,
                ..Course::default()
            },
        }
    }

    /// Moves on to the next sudden change.
    fn piece(&mut self) {
        let mut end = self.sudden.next_after(self.time_s).min(self.rig.longest_s);
        if let Some(noise) = &mut self.noise {
            while noise.held as f64 * noise.hold_s <= self.time_s {
                noise.held += 1;
                self.plant.noise_n_m = noise.torque_n_m(self.state[1]);
            }
            end = end.min(noise.held as f64 * noise.hold_s);
        }
        if let Some(control) = &mut self.speed_loop {
            while control.samples as f64 / control.rate_hz <= self.time_s {
                control.samples += 1;
                let miss = control.target - control.seen.unwrap_or(control.target);
                self.plant.loop_n_m = control.kp * miss + control.integral;
                control.integral += control.ki / control.rate_hz * miss;
            }
            end = end.min(control.samples as f64 / control.rate_hz);
        }
        // Without noise and loop a piece may be the whole run: stop to look at the way travelled.
        end = end.min(self.time_s + 0.5 / self.rig.profile.top());
        self.plant.inside_s = 0.5 * (self.time_s + end);
        while self.time_s < end {
            self.step(end);
        }
    }

    fn step(&mut self, end: f64) {
        let left = end - self.time_s;
        if self.motion == 0.0 {
            let pull = self.plant.pull(self.time_s, self.state[0], 0.0);
            if pull.abs() <= self.plant.dry(0.0) {
                self.rest(left);
                return;
            }
            self.motion = sign(pull);
        }
        let longest = LONGEST_PHASE / self.quickest;
        let mut length = self.step_s.min(longest).min(left);
        let mut step = self.take(length);
        while step.error_rad > TOLERANCE_RAD && length > 1e-12 {
            length *= 0.5;
            step = self.take(length);
        }
        if step.error_rad < TOLERANCE_RAD / 64.0 {
            self.step_s = (2.0 * length).max(self.step_s);
        } else {
            self.step_s = length;
        }
        let stops = self.stop_in(&step);
        if let Some(stop) = stops {
            // Rounding must not keep a shaft that friction stops at once from getting on in time.
            step = self.take(stop.max(1e-9 * length));
        }
        self.collect(&step);
        self.finish(&step, end);
        if stops.is_some() {
            self.state[1] = 0.0;
            self.motion = 0.0;
        }
    }

    fn take(&self, length: f64) -> Step {
        Step::take(self.state, length, |within, state| {
            self.plant.slope(self.time_s + within, state, self.motion)
        })
    }

    /// Time within a step at which the motion comes to a stop.
    fn stop_in(&self, step: &Step) -> Option<f64> {
        let against = |within: f64| step.at(within).1 * self.motion < 0.0;
        if !against(step.length_s) {
            return None;
        }
        let (mut low, mut high) = (0.0, step.length_s);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if against(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high)
    }

    /// Stands still, where dry friction holds, until it lets go or the time is over.
    fn rest(&mut self, left: f64) {
        let loose = |within: f64| {
            let pull = self.plant.pull(self.time_s + within, self.state[0], 0.0);
            pull.abs() > self.plant.dry(0.0)
        };
        let mut length = left;
        if loose(left) {
            let mut low = 0.0;
            for _ in 0..80 {
                let middle = 0.5 * (low + length);
                if loose(middle) {
                    length = middle;
                } else {
                    low = middle;
                }
            }
        }
        let end = self.time_s + left;
        let step = Step::rest(self.state, length.max(1e-9 * left));
        self.collect(&step);
        self.finish(&step, end);
    }

    fn finish(&mut self, step: &Step, end: f64) {
        self.travelled += (step.end[0] - self.state[0]).abs();
        self.state = step.end;
        self.time_s += step.length_s;
        if end - self.time_s < 1e-12 * self.rig.hold_s() {
            self.time_s = end;
        }
    }
}
