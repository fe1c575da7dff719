//! What pushes the shaft: open-loop profiles, the sampled speed loop, torque noise.

use std::f64::consts::TAU;

use quadcal::edge::Direction;

use super::plant::Plant;
use super::random::{Purpose, Stream};
use super::shaft::sign;
use crate::twin::{Drive, Twin};

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
        }
    }
}

/// The profile of a drive as knots, by time, the first at 0.
pub(super) fn knots(twin: &Twin, plant: &Plant) -> Vec<Knot> {
    let rad_s = |r_min: f64| r_min * (TAU / 60.0);
    let hold = |from_s, r_min| Knot::following(plant, from_s, rad_s(r_min), 0.0);
    match &twin.drive {
        Drive::Constant { r_min } => vec![hold(0.0, *r_min)],
        Drive::Ramp {
            from_r_min,
            to_r_min,
            over_s,
        } => {
            let (from, to) = (rad_s(*from_r_min), rad_s(*to_r_min));
            let rate = (to - from) / over_s;
            let mut knots = vec![Knot::following(plant, 0.0, from, rate)];
            if from * to < 0.0 {
                // Friction turns its sign here. The speed is exactly 0, so the knot takes the sign of the rate.
                knots.push(Knot::following(plant, -from / rate, 0.0, rate));
            }
            knots.push(hold(*over_s, *to_r_min));
            knots
        }
        Drive::Steps(steps) => steps
            .iter()
            .enumerate()
            .map(|(i, step)| hold(if i == 0 { 0.0 } else { step.t_s }, step.r_min))
            .collect(),
        Drive::RunDown { r_min, off_s } => {
            let off = Knot {
                from_s: *off_s,
                level: 0.0,
                slope: 0.0,
                damping: plant.viscous,
            };
            vec![hold(0.0, *r_min), off]
        }
        Drive::SpeedLoop { .. } => vec![Knot {
            from_s: 0.0,
            level: 0.0,
            slope: 0.0,
            damping: plant.viscous,
        }],
    }
}

/// The sampled PI speed loop and the T-method speed it sees. Gains and output are accelerations: torque over inertia.
#[derive(Clone, Debug)]
pub(super) struct SpeedLoop {
    target: f64,
    f_hz: f64,
    kp: f64,
    ki: f64,
    limit: f64,
    integral: f64,
    samples: u64,
    clock_hz: f64,
    timeout_ticks: f64,
    step_rad: f64,
    last: Option<(u64, Direction)>,
    measured: Option<f64>,
}

impl SpeedLoop {
    /// The loop of a twin, if its drive is one.
    pub(super) fn new(twin: &Twin, plant: &Plant) -> Option<Self> {
        let Drive::SpeedLoop {
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            timeout_s,
            limit_n_m,
            ..
        } = twin.drive
        else {
            return None;
        };
        let target = plant.nominal;
        let inertia = twin.shaft.inertia_kg_m2;
        let (kp, ki) = match bandwidth_hz {
            Some(bandwidth) => {
                let kp = TAU * bandwidth;
                (kp, kp * TAU * bandwidth / 5.0)
            }
            None => (
                kp_n_m_s.unwrap_or(0.0) / inertia,
                ki_n_m.unwrap_or(0.0) / inertia,
            ),
        };
        let clock_hz = twin.timer.clock_hz as f64;
        let timeout_s = timeout_s.unwrap_or(20.0 * plant.nominal_interval_s);
        Some(Self {
            target,
            f_hz,
            kp,
            ki,
            limit: limit_n_m.map_or(f64::INFINITY, |limit| limit / inertia),
            integral: plant.viscous * target + plant.coulomb * sign(target),
            samples: 0,
            clock_hz,
            timeout_ticks: timeout_s * clock_hz,
            step_rad: plant.step_rad,
            last: None,
            measured: None,
        })
    }

    /// Takes a captured edge, `steps` of the grid after the one before.
    pub(super) fn edge(&mut self, ticks: u64, direction: Direction, steps: u32) {
        if let Some((last, last_direction)) = self.last {
            let interval = ticks.saturating_sub(last);
            if last_direction != direction {
                // The same edge again: the shaft turned round in between.
                self.measured = Some(0.0);
            } else if interval > 0 {
                let way = f64::from(direction.sign()) * f64::from(steps) * self.step_rad;
                self.measured = Some(way * self.clock_hz / interval as f64);
            }
        }
        self.last = Some((ticks, direction));
    }

    /// Time of the next sample, s.
    pub(super) fn next_s(&self) -> f64 {
        self.samples as f64 / self.f_hz
    }

    /// Takes a sample: the acceleration the drive gives until the next one.
    pub(super) fn sample(&mut self) -> f64 {
        let now = (self.next_s() * self.clock_hz).floor();
        self.samples += 1;
        let last = self.last.map_or(0.0, |(ticks, _)| ticks as f64);
        if now - last > self.timeout_ticks {
            self.measured = Some(0.0);
        }
        let miss = self.target - self.measured.unwrap_or(self.target);
        let asked = self.kp * miss + self.integral;
        let given = asked.clamp(-self.limit, self.limit);
        if given == asked || miss * asked < 0.0 {
            self.integral += self.ki / self.f_hz * miss;
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
    pub(super) fn new(seed: u64, sigma: f64, hold_s: f64) -> Self {
        Self {
            random: Stream::new(seed, Purpose::Torque),
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
