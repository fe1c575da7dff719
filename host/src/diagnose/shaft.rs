//! What a push does to the shaft: the twin's law of motion, linear about its course.
//!
//! A small acceleration f changes angle and speed by y and v with dy/dt = v and dv/dt = -b v + f, where b is friction, and the
//! stiffness of a drive that is on, over the inertia. A speed loop is no part of it: what it saw is in the recording, so its push is
//! known (see [`super::turning`]).
//!
//! Where a share of the inertia is behind a spring, the angle is that of the near side, and the swing against the common motion is a
//! state beside it (see [`super::spring`]).

use super::spring::Spring;
use crate::twin::{Drive, Noise, Twin};

/// The law of one twin.
#[derive(Clone, Copy, Debug)]
pub struct ShaftLaw {
    /// Moment of inertia, kg m^2.
    pub inertia: f64,
    /// Viscous friction, 1/s.
    viscous: f64,
    /// What an open-loop drive adds to it while it is on, 1/s.
    stiffness: f64,
    drag: f64,
    stribeck: f64,
    stribeck_rad_s: f64,
    /// When the drive goes off, s.
    off_s: f64,
    /// The spring before a part of the inertia.
    pub spring: Option<Spring>,
    /// Density of the acceleration noise behind it, (rad/s^2)^2 s.
    pub load: f64,
}

impl ShaftLaw {
    /// Of a twin.
    #[must_use]
    pub fn of(twin: &Twin) -> Self {
        let shaft = &twin.shaft;
        let inertia = shaft.inertia_kg_m2;
        let viscous = shaft.viscous_n_m_s / inertia;
        let held = match twin.noise {
            Some(Noise::SpeedWander {
                correlation_rad: Some(correlation),
                ..
            }) => twin.drive.nominal_rad_s().abs() / correlation,
            _ => viscous + shaft.stiffness_n_m_s / inertia,
        };
        let looped = twin.speed_loop().is_some();
        Self {
            inertia,
            viscous,
            stiffness: if looped { 0.0 } else { held - viscous },
            drag: shaft.drag_n_m_s2 / inertia,
            stribeck: shaft.stribeck_n_m / inertia,
            stribeck_rad_s: shaft.stribeck_rad_s,
            off_s: match twin.drive {
                Drive::RunDown { off_s, .. } => off_s,
                _ => f64::INFINITY,
            },
            spring: twin.torsional_resonance.as_ref().map(Spring::of),
            load: twin.torsional_resonance.map_or(0.0, |mode| {
                mode.load_psd_n2_m2_s.unwrap_or(0.0) / (inertia * inertia)
            }),
        }
    }

    /// Whether an open-loop drive holds the speed at a time.
    #[must_use]
    pub fn driven(&self, time_s: f64) -> bool {
        time_s < self.off_s
    }

    /// Damping b at a time and a speed, 1/s.
    #[must_use]
    pub fn damping(&self, time_s: f64, speed: f64) -> f64 {
        let mut damping = self.viscous + 2.0 * self.drag * speed.abs();
        if self.stribeck > 0.0 {
            let over = speed / self.stribeck_rad_s;
            damping -=
                2.0 * self.stribeck * over.abs() / self.stribeck_rad_s * (-over * over).exp();
        }
        if self.driven(time_s) {
            damping += self.stiffness;
        }
        damping
    }

    /// Whether the twin says anything that holds the speed.
    #[must_use]
    pub fn held(&self) -> bool {
        self.viscous + self.stiffness > 0.0 || self.drag > 0.0
    }
}

/// Angle and speed, and how much of both is the near side's swing against the common motion of both masses.
pub type State = [f64; 4];

/// At rest, where it should be.
pub const AT_REST: State = [0.0; 4];

/// A way from one edge to the next.
#[derive(Clone, Copy, Debug)]
pub struct Leap {
    /// Time, s.
    pub after_s: f64,
    /// Damping, 1/s.
    pub damping: f64,
    /// The spring before a part of the inertia.
    pub spring: Option<Spring>,
}

impl Leap {
    /// Angle that a speed makes, and what stays of the speed, of a stiff shaft.
    #[must_use]
    pub fn reach(&self, after_s: f64) -> (f64, f64) {
        let x = self.damping * after_s;
        if x.abs() < 1e-4 {
            (after_s * (1.0 - 0.5 * x), 1.0 - x + 0.5 * x * x)
        } else {
            let forgotten = -(-x).exp_m1();
            (forgotten / self.damping, 1.0 - forgotten)
        }
    }

    /// State after a push given at start, middle and end, rad/s^2.
    #[must_use]
    pub fn step(&self, state: State, push: [f64; 3]) -> State {
        self.stride().step(state, push)
    }

    /// The same for several steps of this length.
    #[must_use]
    pub fn stride(&self) -> Stride {
        Stride {
            leap: *self,
            whole: self.reach(self.after_s),
            half: self.reach(0.5 * self.after_s),
        }
    }
}

/// Steps of one length, whose exponentials are worked out once.
#[derive(Clone, Copy, Debug)]
pub struct Stride {
    leap: Leap,
    /// Angle that a speed makes, and what stays of the speed, over all of it and over its half.
    whole: (f64, f64),
    half: (f64, f64),
}

impl Stride {
    /// State after a push given at start, middle and end, rad/s^2.
    #[must_use]
    pub fn step(&self, state: State, push: [f64; 3]) -> State {
        let h = self.leap.after_s;
        if let Some(spring) = &self.leap.spring {
            return spring.step(h, self.leap.damping, state, push);
        }
        let [y, v, ..] = state;
        let (reach, stays) = self.whole;
        let (half_reach, half_stays) = self.half;
        [
            y + reach * v + h / 6.0 * (reach * push[0] + 4.0 * half_reach * push[1]),
            stays * v + h / 6.0 * (stays * push[0] + 4.0 * half_stays * push[1] + push[2]),
            0.0,
            0.0,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Response of the angle to sin(w t), once the start is forgotten.
    #[test]
    fn a_push_swings_the_shaft_as_its_transfer_function_says() {
        let leap = Leap {
            after_s: 2e-3,
            damping: 3.0,
            spring: None,
        };
        let w = 60.0;
        let mut state = AT_REST;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..10_000 {
            let at = |share: f64| (w * leap.after_s * (f64::from(i) + share)).sin();
            state = leap.step(state, [at(0.0), at(0.5), at(1.0)]);
            if i > 8_000 {
                (least, most) = (state[0].min(least), state[0].max(most));
            }
        }
        let expected = 1.0 / ((w * w).powi(2) + (3.0 * w).powi(2)).sqrt();
        // The start leaves an offset, as nothing pulls the angle back.
        let swing = 0.5 * (most - least);
        assert!((swing / expected - 1.0).abs() < 5e-3, "{swing} {expected}");
    }
}
