//! One slip of a shaft that a spring pulls over friction that falls with speed.
//!
//! From the instant of breaking away, with u the way since and friction F(v) = F_c + F_s exp(-(v / v_s)^2), the spring holding
//! F(0) at first and its far end going on at w: J u'' = K (w t - u) + F_s (1 - exp(-(u' / v_s)^2)) - b u'. Coulomb friction F_c is in
//! none of it. A torque T sin(n theta + phi) that the shaft has anyway adds what it changes on the way. Source: B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods
//! for the control of machines with friction, Automatica 30 (1994), section 2.

use crate::twin::Twin;

/// What shapes a slip; torques over the inertia.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipLaw {
    /// Spring, 1/s^2.
    pub spring: f64,
    /// Drop of friction, rad/s^2.
    pub drop: f64,
    /// Speed over which it drops, rad/s.
    pub over_rad_s: f64,
    /// Damping, 1/s.
    pub damping: f64,
    /// Speed of the spring's far end, rad/s.
    pub pull_rad_s: f64,
    /// Torques locked to the shaft.
    pub waves: Vec<Wave>,
}

/// A torque over the inertia, push sin(order u + phase), u being the way from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Cycles a turn.
    pub order: f64,
    /// Phase at rest.
    pub phase_rad: f64,
    /// Size, rad/s^2.
    pub push: f64,
}

/// A slip on a grid of times.
#[derive(Clone, Debug)]
pub struct Slip {
    step_s: f64,
    /// Way and speed, from breaking away to the stop.
    states: Vec<[f64; 2]>,
}

/// Steps of a quarter of the free period.
const STEPS: f64 = 40.0;
/// Steps after which a shaft is taken to go on for ever.
const STEPS_MOST: usize = 2_000;

impl Wave {
    /// The torques that a twin's shaft has at a speed, phases at angle 0.
    #[must_use]
    pub fn of(twin: &Twin, speed: f64) -> Vec<Self> {
        let shaft = &twin.shaft;
        let held = (shaft.viscous_n_m_s + shaft.stiffness_n_m_s) / shaft.inertia_kg_m2;
        let each = twin.ripple.iter().chain(&twin.gear_mesh);
        each.map(|ripple| Self {
            order: ripple.order,
            phase_rad: ripple.phase_rad,
            push: match (ripple.torque_n_m, ripple.speed_fraction) {
                (Some(torque), _) => torque / shaft.inertia_kg_m2,
                (None, swing) => swing.unwrap_or(0.0) * speed * held.hypot(ripple.order * speed),
            },
        })
        .collect()
    }

    /// The same with the rest a way further.
    #[must_use]
    pub fn on(&self, way: f64) -> Self {
        Self {
            phase_rad: self.phase_rad + self.order * way,
            ..*self
        }
    }

    /// What it pushes more than at rest.
    fn more(&self, way: f64) -> f64 {
        self.push * ((self.order * way + self.phase_rad).sin() - self.phase_rad.sin())
    }
}

impl SlipLaw {
    /// Acceleration at a time, way and speed.
    fn push(&self, time_s: f64, [way, speed]: [f64; 2]) -> f64 {
        let over = speed / self.over_rad_s;
        self.spring * (self.pull_rad_s * time_s - way)
            - self.drop * (-over * over).exp_m1()
            - self.damping * speed
            + self.waves.iter().map(|wave| wave.more(way)).sum::<f64>()
    }

    /// The slip; none where it never comes to a stop.
    #[must_use]
    pub fn slip(&self) -> Option<Slip> {
        let step_s = 0.5 * std::f64::consts::PI / self.spring.sqrt() / STEPS;
        let mut states = vec![[0.0; 2]];
        let mut now = [0.0; 2];
        for i in 0..STEPS_MOST {
            now = self.stepped(i as f64 * step_s, now, step_s);
            if now[1] <= 0.0 {
                // The stop within the step, by its acceleration.
                let last = states[states.len() - 1];
                let share = last[1] / (last[1] - now[1]);
                states.push([last[0] + 0.5 * share * step_s * last[1], 0.0]);
                return (states.len() > 8).then_some(Slip { step_s, states });
            }
            states.push(now);
        }
        None
    }

    /// A step of Runge and Kutta's.
    fn stepped(&self, time_s: f64, state: [f64; 2], step_s: f64) -> [f64; 2] {
        let rate = |after: f64, s: [f64; 2]| [s[1], self.push(time_s + after, s)];
        let on = |rate: [f64; 2], share: f64| {
            [
                state[0] + share * step_s * rate[0],
                state[1] + share * step_s * rate[1],
            ]
        };
        let first = rate(0.0, state);
        let second = rate(0.5 * step_s, on(first, 0.5));
        let third = rate(0.5 * step_s, on(second, 0.5));
        let last = rate(step_s, on(third, 1.0));
        std::array::from_fn(|i| {
            state[i] + step_s / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i])
        })
    }
}

impl Slip {
    /// Way at a time after breaking away, by the cubic through ways and speeds.
    #[must_use]
    pub fn way(&self, time_s: f64) -> f64 {
        if time_s <= 0.0 {
            return 0.0;
        }
        let at = time_s / self.step_s;
        let index = at as usize;
        let last = self.states.len() - 1;
        if index >= last {
            return self.states[last][0];
        }
        let ([a, va], [b, vb]) = (self.states[index], self.states[index + 1]);
        let s = at - index as f64;
        let (va, vb) = (va * self.step_s, vb * self.step_s);
        let (up, r) = (s * s * (3.0 - 2.0 * s), 1.0 - s);
        a + (b - a) * up + va * s * r * r - vb * s * s * r
    }

    /// Whole way, rad.
    #[must_use]
    pub fn whole(&self) -> f64 {
        self.states[self.states.len() - 1][0]
    }

    /// How long it takes, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        (self.states.len() - 1) as f64 * self.step_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drop of friction at once leaves a free oscillation about the place where the spring holds the rest.
    #[test]
    fn a_sudden_drop_of_friction_makes_half_a_free_swing() {
        let law = SlipLaw {
            spring: 100.0,
            drop: 20.0,
            over_rad_s: 1e-4,
            damping: 0.0,
            pull_rad_s: 0.01,
            waves: Vec::new(),
        };
        let slip = law.slip().unwrap();
        assert!((slip.whole() / 0.4 - 1.0).abs() < 0.02, "{}", slip.whole());
    }

    #[test]
    fn much_damping_never_lets_it_stop() {
        let law = SlipLaw {
            spring: 100.0,
            drop: 1.0,
            over_rad_s: 1.0,
            damping: 50.0,
            pull_rad_s: 1.0,
            waves: Vec::new(),
        };
        assert!(law.slip().is_none());
    }
}
