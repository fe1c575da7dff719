//! The equation of motion: drive, friction, torques and noise on one or two masses.

use crate::effect::Effect;
use crate::rig::{Profile, Rig};
use crate::step::State;

/// Everything that pushes the shaft over one piece of time in which nothing changes suddenly.
#[derive(Clone, Debug)]
pub struct Plant<'a> {
    rig: &'a Rig,
    effects: &'a [Effect],
    masses: Masses,
    /// A time inside the piece, s.
    pub inside_s: f64,
    /// Torque noise held over the piece, N m.
    pub noise_n_m: f64,
    /// Torque that a speed loop gives, N m.
    pub loop_n_m: f64,
}

#[derive(Clone, Copy, Debug)]
struct Masses {
    near: f64,
    far: f64,
    spring: f64,
    damper: f64,
}

impl Masses {
    fn new(rig: &Rig, effects: &[Effect]) -> Self {
        let total = rig.inertia;
        for effect in effects {
            if let Effect::TorsionalResonance {
                f_hz,
                damping_ratio,
                inertia_share,
            } = effect
            {
                let (near, far) = (total * (1.0 - inertia_share), total * inertia_share);
                let reduced = near * far / total;
                let mode = std::f64::consts::TAU * f_hz;
                return Self {
                    near,
                    far,
                    spring: mode * mode * reduced,
                    damper: 2.0 * damping_ratio * mode * reduced,
                };
            }
        }
        Self {
            near: total,
            far: 0.0,
            spring: 0.0,
            damper: 0.0,
        }
    }
}

impl<'a> Plant<'a> {
    /// The plant of a rig with effects.
    #[must_use]
    pub fn new(rig: &'a Rig, effects: &'a [Effect]) -> Self {
        Self {
            rig,
            effects,
            masses: Masses::new(rig, effects),
            inside_s: 0.0,
            noise_n_m: 0.0,
            loop_n_m: 0.0,
        }
    }

    /// Speed asked for at a time and its rate, rad/s and rad/s^2.
    #[must_use]
    pub fn asked(&self, time_s: f64) -> (f64, f64) {
        let (speed, rate) = match self.rig.profile {
            Profile::Ramp { from, to, over_s } if self.inside_s < over_s => {
                let rate = (to - from) / over_s;
                (from + rate * time_s, rate)
            }
            Profile::Ramp { to, .. } => (to, 0.0),
            Profile::Free(pieces) => pieces.at(time_s, self.inside_s),
            Profile::Constant { speed }
            | Profile::RunDown { speed, .. }
            | Profile::Loop { speed, .. } => (speed, 0.0),
        };
        self.effects
            .iter()
            .fold((speed, rate), |(speed, rate), effect| {
                let (factor, change) = effect.asked(time_s);
                (speed * factor, rate * factor + speed * change)
            })
    }

    /// Dry friction at a speed, N m, without sign.
    #[must_use]
    pub fn dry(&self, speed: f64) -> f64 {
        let more = self.effects.iter().map(|effect| effect.dry(speed));
        self.rig.coulomb + more.sum::<f64>()
    }

    /// Torque on the encoder's side without dry friction and spring, N m.
    #[must_use]
    pub fn pull(&self, time_s: f64, theta: f64, speed: f64) -> f64 {
        let rig = self.rig;
        let mut torque = self.noise_n_m - rig.viscous * speed;
        if matches!(rig.profile, Profile::Loop { .. }) {
            torque += self.loop_n_m;
        } else if rig.driven(self.inside_s) {
            let (asked, rate) = self.asked(time_s);
            // Which way friction is fed forward must not hang on rounding where the speed asked for is zero.
            let (towards, _) = self.asked(self.inside_s);
            torque += match self.spring() {
                Some(spring) => spring * (rig.start_rad + asked * time_s - theta),
                None => {
                    rig.inertia * rate
                        + (rig.viscous + rig.stiffness) * asked
                        + rig.coulomb * sign(towards)
                        - rig.stiffness * speed
                }
            };
        }
        for ripple in &rig.ripples {
            torque += ripple.torque_n_m * libm::sin(ripple.order * theta + ripple.phase_rad);
        }
        for effect in self.effects {
            torque += effect.torque(time_s, self.inside_s, theta, speed, 0.0);
        }
        torque
    }

    /// Stiffness of a spring that the drive pulls through, N m/rad.
    fn spring(&self) -> Option<f64> {
        self.effects.iter().find_map(|effect| match effect {
            Effect::StickSlip {
                stiffness_n_m_rad, ..
            } => Some(*stiffness_n_m_rad),
            _ => None,
        })
    }

    /// Derivative of the state while the shaft moves in a direction.
    #[must_use]
    pub fn slope(&self, time_s: f64, state: &State, motion: f64) -> State {
        let masses = self.masses;
        let [theta, speed, far_theta, far_speed] = *state;
        let pull = self.pull(time_s, theta, speed) - motion * self.dry(speed);
        if masses.far == 0.0 {
            return [speed, pull / masses.near, 0.0, 0.0];
        }
        let spring = masses.spring * (far_theta - theta) + masses.damper * (far_speed - speed);
        [
            speed,
            (pull + spring) / masses.near,
            far_speed,
            -spring / masses.far,
        ]
    }

    /// Speed at time 0, rad/s, without noise: what is asked for, with the swing and the lag of the torques as if it had run so for
    /// long, first order in the torques. Behind a spring the shaft starts at rest.
    #[must_use]
    pub fn start_speed(&self) -> f64 {
        let rig = self.rig;
        let asked = rig.profile.start();
        if asked == 0.0 || self.spring().is_some() {
            return 0.0;
        }
        let damping = rig.damping(rig.driven(0.0));
        let swing = |turning: f64, phase: f64, torque: f64| {
            let (sin, cos) = libm::sincos(phase);
            torque / rig.inertia * (damping * sin - turning * cos)
                / (turning * turning + damping * damping)
        };
        let mut speed = asked;
        for o in &rig.ripples {
            let phase = o.order * rig.start_rad + o.phase_rad;
            speed += swing(o.order * asked, phase, o.torque_n_m);
        }
        for effect in self.effects {
            speed += match effect {
                Effect::TorqueRipple(o) | Effect::GearMesh(o) | Effect::BearingTorque(o) => swing(
                    o.order * asked,
                    o.order * rig.start_rad + o.phase_rad,
                    o.torque_n_m,
                ),
                Effect::TorqueTone {
                    f_hz,
                    phase_rad,
                    torque_n_m,
                } => swing(std::f64::consts::TAU * f_hz, *phase_rad, *torque_n_m),
                Effect::Friction { .. } if damping > 0.0 => {
                    effect.torque(0.0, 0.0, 0.0, asked, sign(asked)) / (damping * rig.inertia)
                }
                _ => 0.0,
            };
        }
        speed
    }

    /// Torque that a speed loop's integrator holds at the start: that of friction at the speed asked for, N m.
    #[must_use]
    pub fn loop_start(&self) -> f64 {
        let speed = self.rig.profile.start();
        self.rig.viscous * speed + self.rig.coulomb * sign(speed)
    }
}

/// -1, 0 or 1.
#[must_use]
pub fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}
