//! The torque that a speed loop asked for, worked out again from the edges that it saw.

use quadcal::edge::Direction;

use super::model::LoopModel;
use super::motion::Motion;
use crate::twin::SeenSpeed;

/// Shares of a motion: what the proportional gain made a unit of it, the integral gain, and what depends on neither (a drive at its
/// limit).
pub type Shares = [f64; 3];

/// A loop at work on captured edges, and the displacement of the shaft that it makes, by gain.
///
/// Where no limit is reached the displacement is kp times its first share and ki times its second, exactly, for the integrator is
/// linear and the edges are as recorded.
#[derive(Clone, Debug)]
pub struct Command {
    model: LoopModel,
    clock_hz: f64,
    motion: Motion<3>,
    /// What pushes now.
    push: Shares,
    /// Integral of the miss, rad.
    integral: f64,
    seen: SeenSpeed,
    /// Ticks at which the motion stands.
    now: f64,
    /// Number of the next sample and its time, ticks.
    sample: u64,
    next: f64,
}

impl Command {
    /// A loop that starts at tick `from`; `step_rad` is a step of the grid.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn new(model: &LoopModel, clock_hz: u64, step_rad: f64, from: u64) -> Self {
        let (clock_hz, from) = (clock_hz as f64, from as f64);
        let first = ((from / clock_hz - model.phase_s) * model.rate_hz).ceil();
        let mut command = Self {
            model: *model,
            clock_hz,
            motion: Motion::new(model.viscous),
            push: [0.0; 3],
            integral: 0.0,
            seen: SeenSpeed::new(clock_hz, step_rad, model.timeout_s, None),
            now: from,
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            sample: first.max(0.0) as u64,
            next: 0.0,
        };
        command.next = command.time_of_sample();
        command
    }

    #[allow(clippy::cast_precision_loss)]
    fn time_of_sample(&self) -> f64 {
        // In this order a rate that divides the clock gives whole ticks exactly.
        self.sample as f64 * self.clock_hz / self.model.rate_hz + self.model.phase_s * self.clock_hz
    }

    /// Goes on to a tick, which is not before the last one, and gives the displacement there, rad by unit of each gain.
    #[allow(clippy::cast_precision_loss)]
    pub fn reach(&mut self, ticks: u64) -> Shares {
        let ticks = ticks as f64;
        // A stamp is rounded down: an edge stamped with the tick of a sample came after it.
        while self.next <= ticks {
            self.advance(self.next);
            self.take_sample();
        }
        self.advance(ticks);
        self.motion.angle()
    }

    fn advance(&mut self, to: f64) {
        self.motion
            .advance((to - self.now) / self.clock_hz, &self.push);
        self.now = self.now.max(to);
    }

    /// Takes an edge at the tick just reached, `steps` of the grid after the one before.
    pub fn edge(&mut self, ticks: u64, direction: Direction, steps: u16) {
        self.seen.edge(ticks, direction, u32::from(steps));
    }

    fn take_sample(&mut self) {
        let model = &self.model;
        let miss = model.miss(self.seen.at(self.next.floor()));
        let asked = model.gains.kp * miss + model.gains.ki * self.integral + model.start;
        let given = asked.clamp(-model.limit, model.limit);
        self.push = if given == asked {
            [miss, self.integral, 0.0]
        } else {
            [0.0, 0.0, given - model.start]
        };
        if given == asked || miss * asked < 0.0 {
            self.integral += miss / model.rate_hz;
        }
        self.sample += 1;
        self.next = self.time_of_sample();
    }
}

impl LoopModel {
    /// Speed asked for less speed seen; none is seen until the first interval ends.
    fn miss(&self, measured: Option<f64>) -> f64 {
        self.target_rad_s - measured.unwrap_or(self.target_rad_s)
    }
}
