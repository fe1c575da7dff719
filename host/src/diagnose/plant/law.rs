//! Inertia, friction and drive of a twin, and its second mass.

use std::f64::consts::TAU;

use crate::effect::Carrier;
use crate::sim;
use crate::twin::{Drive, Twin};

/// How a drive that nobody declared holds the shaft. It keeps up a speed that changes slowly; a torque's swing and noise it damps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hold {
    /// By how much it damps what torques do, 1/s.
    pub stiffness: f64,
    /// How fast it forgets what noise did to the speed, 1/s: as much, where the noise is of a torque and white.
    pub forgets: f64,
    /// How far off that may be, 1/s; as far as it is itself where nothing says so.
    pub open: f64,
    /// Whether noise goes all the same as if nothing held the shaft.
    pub loose: bool,
}

/// A share of the inertia behind a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Square of the free frequency, 1/s^2.
    pub square: f64,
    /// Damping of the swing, 1/s.
    pub damping: f64,
    /// Inertia of the far side over that of the near one.
    pub ratio: f64,
    /// Density of the noise of the far side's torque over the square of the inertia, (rad/s^2)^2 s.
    pub load: f64,
}

impl Mode {
    /// How fast its motion may go where the near side is damped by so much, 1/s.
    pub(super) fn rate(&self, b: f64) -> f64 {
        self.square.sqrt() + self.damping + (1.0 + self.ratio) * b.abs()
    }

    /// Two masses over a short step, pushed near at its start, middle and end: Runge and Kutta's fourth order.
    pub(super) fn swung(&self, b: f64, h: f64, state: [f64; 4], push: [f64; 3]) -> [f64; 4] {
        let slope = |[_, v, q, u]: [f64; 4], push: f64| {
            let near = push - b * v;
            let swing = -self.square * q - self.damping * u;
            let (one, both) = (self.ratio * near, (1.0 + self.ratio) * near);
            [v, both + swing, u, one + swing]
        };
        let along = |k: [f64; 4], by: f64| {
            let mut at = state;
            at.iter_mut().zip(k).for_each(|(at, k)| *at += by * k);
            at
        };
        let k1 = slope(state, push[0]);
        let k2 = slope(along(k1, 0.5 * h), push[1]);
        let k3 = slope(along(k2, 0.5 * h), push[1]);
        let k4 = slope(along(k3, h), push[2]);
        let mut end = state;
        for at in 0..4 {
            end[at] += h / 6.0 * (k1[at] + 2.0 * k2[at] + 2.0 * k3[at] + k4[at]);
        }
        end
    }
}

/// Friction and drive of a twin, over its inertia.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Law {
    /// Inertia, kg m^2.
    pub inertia: f64,
    /// Viscous friction, 1/s.
    pub viscous: f64,
    /// What an open-loop drive adds while it is on, 1/s.
    pub stiffness: f64,
    /// Coulomb friction, rad/s^2.
    pub coulomb: f64,
    /// Drag, 1/rad.
    pub drag: f64,
    /// Stribeck friction, rad/s^2.
    pub stribeck: f64,
    /// Its speed, rad/s.
    pub stribeck_rad_s: f64,
    /// When the drive goes off, s.
    pub off_s: f64,
    /// Second mass.
    pub mode: Option<Mode>,
    /// Time for which torque noise is held, s; 0 where it is white.
    pub hold_s: f64,
    /// Whether nobody knows what drives it.
    pub undriven: bool,
    /// How such a drive holds it.
    pub hold: Hold,
}

impl Law {
    /// Of a twin.
    pub fn of(twin: &Twin) -> Self {
        let shaft = &twin.shaft;
        let inertia = shaft.inertia_or_one();
        let plant = sim::Plant::new(twin);
        let viscous = plant.viscous;
        if twin.drive == Drive::Unknown {
            return Self::undriven(inertia, viscous);
        }
        let looped = twin.speed_loop().is_some();
        let hold_s = plant.hold_s(twin).filter(|hold_s| hold_s.is_finite());
        Self {
            inertia,
            viscous,
            stiffness: if looped { 0.0 } else { plant.damping - viscous },
            coulomb: plant.coulomb,
            drag: shaft.drag_n_m_s2 / inertia,
            stribeck: shaft.stribeck_n_m / inertia,
            stribeck_rad_s: shaft.stribeck_rad_s,
            off_s: match twin.drive {
                Drive::RunDown { off_s, .. } => off_s,
                _ => f64::INFINITY,
            },
            mode: twin.torsional_resonance.as_ref().map(|mode| {
                let free = TAU * mode.f_hz;
                Mode {
                    square: free * free,
                    damping: 2.0 * mode.damping_ratio * free,
                    ratio: mode.inertia_share / (1.0 - mode.inertia_share),
                    load: mode.load_psd_n2_m2_s.unwrap_or(0.0) / (inertia * inertia),
                }
            }),
            hold_s: hold_s.unwrap_or(0.0),
            undriven: false,
            hold: Hold::default(),
        }
    }

    /// The same as it was found to be held.
    #[must_use]
    pub fn held(self, hold: Hold) -> Self {
        Self {
            stiffness: self.stiffness + hold.stiffness,
            hold,
            ..self
        }
    }

    /// Of a shaft whose drive is unknown: what that does against friction is in the free course, which nothing damps. What a torque adds
    /// to the course is damped all the same.
    pub(super) fn undriven(inertia: f64, viscous: f64) -> Self {
        Self {
            inertia,
            viscous,
            off_s: f64::INFINITY,
            undriven: true,
            ..Self::default()
        }
    }

    /// Size of the friction without the viscous part at a speed, rad/s^2, and its slope, 1/s.
    pub fn friction(&self, speed: f64) -> (f64, f64) {
        let size = speed.abs();
        let mut at = self.coulomb + self.drag * size * size;
        let mut slope = 2.0 * self.drag * size;
        if self.stribeck > 0.0 {
            let over = size / self.stribeck_rad_s;
            let left = self.stribeck * (-over * over).exp();
            at += left;
            slope -= 2.0 * over / self.stribeck_rad_s * left;
        }
        (at, slope)
    }

    /// What it has of one kind of friction, over the inertia.
    pub fn coefficient(&self, kind: Carrier) -> f64 {
        match kind {
            Carrier::Power(0.0) => self.coulomb,
            Carrier::Power(1.0) => self.viscous,
            Carrier::Power(2.0) => self.drag,
            Carrier::Stribeck(_) => self.stribeck,
            _ => 0.0,
        }
    }

    /// Share of a time for which the drive is on.
    pub(super) fn share_on(&self, from_s: f64, until_s: f64) -> f64 {
        if until_s <= self.off_s {
            1.0
        } else if from_s >= self.off_s {
            0.0
        } else {
            (self.off_s - from_s) / (until_s - from_s)
        }
    }

    /// Damping at a time and a speed, 1/s.
    pub fn damping(&self, time_s: f64, speed: f64) -> f64 {
        let drive = if time_s < self.off_s {
            self.stiffness
        } else {
            0.0
        };
        self.viscous + drive + self.friction(speed).1
    }
}

/// -1, 0 or 1.
pub fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// How a twin sizes a torque that swings: as such, or without an inertia as the swing of the speed that it makes.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    /// The drive's nominal speed, rad/s.
    pub nominal: f64,
    plant: sim::Plant,
    inertia: f64,
    torques: bool,
}

impl Swing {
    /// Of a twin.
    pub fn of(twin: &Twin) -> Self {
        let plant = sim::Plant::new(twin);
        Self {
            nominal: plant.nominal.abs(),
            plant,
            inertia: twin.shaft.inertia_or_one(),
            torques: twin.shaft.inertia_kg_m2 != 0.0,
        }
    }

    /// A torque, N m, that is given as such or as a relative swing; `turning` is its rate, rad/s.
    pub fn torque(&self, turning: f64, torque: Option<f64>, fraction: Option<f64>) -> f64 {
        let of_swing = || self.inertia * self.plant.size(self.inertia, turning, None, fraction);
        torque.unwrap_or_else(of_swing)
    }

    /// The same the other way: the torque as the twin gives it.
    pub fn sized(&self, turning: f64, torque: f64) -> (Option<f64>, Option<f64>) {
        if self.torques {
            (Some(torque), None)
        } else {
            (None, Some(torque / self.torque(turning, None, Some(1.0))))
        }
    }
}
