//! What pushes the shaft: open-loop profiles, the sampled speed loop, torque noise.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use quadcal::edge::Direction;

use super::plant::Plant;
use super::random::Stream;
use super::shaft::sign;
use crate::twin::{self, Drive, SeenSpeed, Twin};

/// From a time on: speed asked for and the acceleration that open-loop drive makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub(super) from_s: f64,
    /// Acceleration at `from_s`, rad/s^2, damping not yet taken off.
    pub(super) level: f64,
    /// Its rate, rad/s^3.
    pub(super) slope: f64,
    /// Viscous friction and stiffness, 1/s.
    pub(super) damping: f64,
    /// Speed asked for at `from_s`, rad/s.
    pub(super) speed: f64,
    /// Its rate, rad/s^2.
    pub(super) rate: f64,
    /// Direction in which friction is balanced: -1, 0 or 1.
    pub(super) towards: f64,
    /// Whether an open-loop drive is on.
    pub(super) driven: bool,
}

impl Knot {
    /// The push that makes the shaft follow a speed w at rate dw, from equation J dw/dt + b w + coulomb + stiffness (w* - w).
    fn following(plant: &Plant, from_s: f64, w: f64, dw: f64) -> Self {
        let towards = if w == 0.0 { sign(dw) } else { sign(w) };
        Self {
            from_s,
            level: dw + plant.damping * w + plant.coulomb * towards,
            slope: plant.damping * dw,
            damping: plant.damping,
            speed: w,
            rate: dw,
            towards,
            driven: true,
        }
    }

    /// No push of a profile from a time on.
    fn free(plant: &Plant, from_s: f64) -> Self {
        Self::pushed(plant, from_s, 0.0, 0.0)
    }

    /// A push from a time on that follows no speed.
    fn pushed(plant: &Plant, from_s: f64, level: f64, slope: f64) -> Self {
        Self {
            from_s,
            level,
            slope,
            damping: plant.viscous,
            speed: 0.0,
            rate: 0.0,
            towards: 0.0,
            driven: false,
        }
    }
}

/// The profile of a drive as knots, by time, the first at 0. A speed that drifts down to zero stays there.
pub(super) fn knots(twin: &Twin, plant: &Plant) -> Vec<Knot> {
    let mut knots = profile_knots(twin, plant);
    let rate = twin.speed_drift.and_then(|drift| drift.fraction_per_s);
    if let Some(rate) = rate.filter(|rate| *rate < 0.0) {
        let ends_s = -1.0 / rate;
        let from = knots.partition_point(|knot| knot.from_s < ends_s);
        for knot in knots[from..].iter_mut().filter(|knot| knot.driven) {
            *knot = Knot::following(plant, knot.from_s, 0.0, 0.0);
        }
        if knots[from - 1].driven {
            knots.insert(from, Knot::following(plant, ends_s, 0.0, 0.0));
        }
    }
    knots
}

fn profile_knots(twin: &Twin, plant: &Plant) -> Vec<Knot> {
    let rad_s = |r_min: f64| r_min * (TAU / 60.0);
    let hold = |from_s, r_min| Knot::following(plant, from_s, rad_s(r_min), 0.0);
    match &twin.drive {
        Drive::Constant { r_min } => vec![hold(0.0, *r_min)],
        Drive::Ramp {
            from_r_min,
            to_r_min,
            over_s,
        } => {
            let mut knots = ramp(plant, 0.0, *over_s, (rad_s(*from_r_min), rad_s(*to_r_min)));
            knots.push(hold(*over_s, *to_r_min));
            knots
        }
        Drive::Steps(steps) => steps
            .iter()
            .enumerate()
            .map(|(i, step)| hold(if i == 0 { 0.0 } else { step.t_s }, step.r_min))
            .collect(),
        Drive::RunDown { r_min, off_s } => {
            vec![hold(0.0, *r_min), Knot::free(plant, *off_s)]
        }
        Drive::Profile(profile) => {
            let points = profile.points();
            let mut knots = match points.first() {
                Some(first) if first.t_s > 0.0 => vec![hold(0.0, first.r_min)],
                _ => Vec::new(),
            };
            for (from, to) in points.iter().zip(points.iter().skip(1)) {
                if to.t_s > from.t_s {
                    let speeds = (rad_s(from.r_min), rad_s(to.r_min));
                    knots.extend(ramp(plant, from.t_s, to.t_s - from.t_s, speeds));
                }
            }
            knots.extend(points.last().map(|last| hold(last.t_s, last.r_min)));
            knots
        }
        Drive::Torque(torque) => {
            let points = torque.points();
            let inertia = twin.shaft.inertia_or_one();
            let push = |from_s, torque_n_m: f64, slope| {
                Knot::pushed(plant, from_s, torque_n_m / inertia, slope)
            };
            let mut knots = match points.first() {
                Some(first) if first.t_s > 0.0 => vec![push(0.0, first.torque_n_m, 0.0)],
                _ => Vec::new(),
            };
            for (from, to) in points.iter().zip(points.iter().skip(1)) {
                let (length_s, more) = (to.t_s - from.t_s, to.torque_n_m - from.torque_n_m);
                if length_s > 0.0 {
                    knots.push(push(from.t_s, from.torque_n_m, more / length_s / inertia));
                }
            }
            knots.extend(
                points
                    .last()
                    .map(|last| push(last.t_s, last.torque_n_m, 0.0)),
            );
            knots
        }
        Drive::SpeedLoop { .. } | Drive::Unknown => vec![Knot::free(plant, 0.0)],
    }
}

/// The knots of a speed, rad/s, that changes at a constant rate for a time.
fn ramp(plant: &Plant, from_s: f64, length_s: f64, (from, to): (f64, f64)) -> Vec<Knot> {
    let rate = (to - from) / length_s;
    let mut knots = vec![Knot::following(plant, from_s, from, rate)];
    if from * to < 0.0 {
        // Friction turns its sign here. The speed is exactly 0, so the knot takes the sign of the rate.
        knots.push(Knot::following(plant, from_s - from / rate, 0.0, rate));
    }
    knots
}

/// The sampled PI speed loop and the speed that it sees. Gains and output are accelerations: torque over inertia.
#[derive(Clone, Debug)]
pub(super) struct SpeedLoop {
    model: twin::SpeedLoop,
    clock_hz: f64,
    seen: SeenSpeed,
    /// Edges that no sample has come after yet, by the time of their capture.
    captured: VecDeque<Captured>,
    integral: f64,
    samples: u64,
}

/// An edge that the loop will see.
#[derive(Clone, Copy, Debug)]
struct Captured {
    at_s: f64,
    ticks: u64,
    direction: Direction,
    steps: u32,
}

impl SpeedLoop {
    /// The loop of a twin, if its drive is one.
    pub(super) fn new(twin: &Twin, plant: &Plant) -> Option<Self> {
        let model = twin.speed_loop()?;
        let clock_hz = twin.timer.clock_hz as f64;
        Some(Self {
            model,
            clock_hz,
            seen: SeenSpeed::new(clock_hz, plant.step_rad, model.timeout_s, Some(0)),
            captured: VecDeque::new(),
            integral: model.start,
            samples: 0,
        })
    }

    /// Takes an edge captured at a time, `steps` of the grid after the one before: samples from then on see it.
    pub(super) fn edge(&mut self, at_s: f64, ticks: u64, direction: Direction, steps: u32) {
        let after = self.captured.partition_point(|edge| edge.at_s <= at_s);
        let edge = Captured {
            at_s,
            ticks,
            direction,
            steps,
        };
        self.captured.insert(after, edge);
    }

    /// Time of the next sample, s.
    pub(super) fn next_s(&self) -> f64 {
        self.samples as f64 / self.model.rate_hz
    }

    /// Takes a sample: the acceleration the drive gives until the next one.
    pub(super) fn sample(&mut self) -> f64 {
        let now_s = self.next_s();
        while let Some(edge) = self.captured.pop_front_if(|edge| edge.at_s <= now_s) {
            self.seen.edge(edge.ticks, edge.direction, edge.steps);
        }
        let now = (now_s * self.clock_hz).floor();
        self.samples += 1;
        let model = &self.model;
        let miss = model.target_rad_s - self.seen.at(now).unwrap_or(model.target_rad_s);
        let asked = model.gains.kp * miss + self.integral;
        let given = asked.clamp(-model.limit, model.limit);
        if given == asked || miss * asked < 0.0 {
            self.integral += model.gains.ki / model.rate_hz * miss;
        }
        given
    }
}

/// White torque noise on its own time grid.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    random: Stream,
    sigma: f64,
    hold_s: f64,
    steps: u64,
}

impl Noise {
    /// Noise of `sigma` rad/s^2, new every `hold_s`.
    pub(super) fn new(random: Stream, sigma: f64, hold_s: f64) -> Self {
        Self {
            random,
            sigma,
            hold_s,
            steps: 0,
        }
    }

    /// Time of the next change, s.
    pub(super) fn next_s(&self) -> f64 {
        self.steps as f64 * self.hold_s
    }

    /// The acceleration until the next change.
    pub(super) fn change(&mut self) -> f64 {
        self.steps += 1;
        self.sigma * self.random.normal()
    }
}
