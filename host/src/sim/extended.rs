//! Terms of the equation of motion beyond the plain one: torque tones, drifting profiles, drag and Stribeck friction, springs, and
//! effects that a twin declares as such.
//!
//! With a the sum of all torques over the whole inertia, s the far side's share and q = w_n^2 d + 2 zeta w_n d' of the twist d:
//! dw/dt = a / (1 - s) + s q and d'' = far push - (1 - s) q - dw/dt. Without a second mass s is 0.

use super::drive::Knot;
use super::effects::{self, Effects, Start};
use super::plant::Plant;
use super::profile::Profile;
use super::shaft::ROUNDING;
use super::spring::{DriveSpring, State, Twist};
use super::taylor::{DEGREE, Piece, Series, bisect};
use super::tone::Tone;
use crate::twin::Twin;

/// Length of a rest over the shortest time in which a push changes: its series is then good to rounding.
const REST_SHARE: f64 = 0.5;

/// Friction that is no straight line, over inertia.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction {
    /// Drag: acceleration a (rad/s)^2.
    pub(super) drag: f64,
    /// Stribeck friction at rest, rad/s^2.
    pub(super) stribeck: f64,
    /// Speed over which it goes, rad/s; any where there is none.
    pub(super) stribeck_speed: f64,
}

impl Friction {
    fn new(twin: &Twin) -> Self {
        let shaft = &twin.shaft;
        Self {
            drag: shaft.drag_n_m_s2 / shaft.inertia_or_one(),
            stribeck: shaft.stribeck_n_m / shaft.inertia_or_one(),
            stribeck_speed: if shaft.stribeck_n_m > 0.0 {
                shaft.stribeck_rad_s
            } else {
                1.0
            },
        }
    }

    /// Term `k` of its size against the motion for a speed of which terms 0 to `k` are known; `falling` keeps the terms of
    /// exp(-(w / ws)^2).
    pub(super) fn term(&self, k: usize, speed: &Series, falling: &mut Series) -> f64 {
        let square = |k: usize| (0..=k).map(|j| speed[j] * speed[k - j]).sum::<f64>();
        if self.stribeck > 0.0 {
            // g' = u' g with u = -(w / ws)^2.
            let scale = -1.0 / (self.stribeck_speed * self.stribeck_speed);
            falling[k] = if k == 0 {
                libm::exp(scale * square(0))
            } else {
                let sum = (1..=k).map(|j| j as f64 * square(j) * falling[k - j]);
                scale * sum.sum::<f64>() / k as f64
            };
        }
        let drag = if self.drag > 0.0 {
            self.drag * square(k)
        } else {
            0.0
        };
        drag + self.stribeck * falling[k]
    }

    /// Its size at a speed, rad/s^2.
    pub(super) fn at(&self, speed: f64) -> f64 {
        let mut series = [0.0; DEGREE];
        series[0] = speed;
        self.term(0, &series, &mut [0.0; DEGREE])
    }

    /// How it grows with the speed's size, 1/s.
    pub(super) fn slope_at(&self, speed: f64) -> f64 {
        let over = speed.abs() / self.stribeck_speed;
        let falling = libm::exp(-over * over);
        2.0 * (self.drag * speed.abs() - self.stribeck * falling * over / self.stribeck_speed)
    }

    /// How fast it changes with the speed, s/rad.
    pub(super) fn per_speed(&self) -> f64 {
        if self.stribeck > 0.0 {
            1.0 / self.stribeck_speed
        } else {
            0.0
        }
    }
}

/// The terms, and those of their states at the step's start.
#[derive(Clone, Debug)]
pub(super) struct Extended {
    profile: Profile,
    pub(super) tones: Vec<Tone>,
    pub(super) friction: Friction,
    pub(super) spring: Option<DriveSpring>,
    pub(super) twist: Option<Twist>,
    pub(super) effects: Effects,
    /// Whether the drive's spring pulls.
    pulls: bool,
    /// The drive from the step's start on, if it follows a speed that effects change.
    changed: Option<Knot>,
    /// The step's start.
    start: Start,
    /// Around the step's start: push, speed asked for, and the fastest rate of change, 1/s.
    push: Series,
    asked: Series,
    /// What is asked for without effects.
    given: Series,
    fastest: f64,
    falling: Series,
    /// As that, of the speed asked for.
    followed: Series,
    /// Sign of the motion that friction acts against; 0 where the shaft is held.
    motion: f64,
}

impl Extended {
    /// The terms of a twin; none if the plain equation is all it has.
    pub(super) fn new(twin: &Twin, plant: &Plant) -> Option<Self> {
        let friction = Friction::new(twin);
        let spring = twin.stick_slip.map(|spring| DriveSpring {
            stiffness: spring.stiffness_n_m_rad / twin.shaft.inertia_or_one(),
            stretch: State::default(),
        });
        let effects = Effects::new(twin);
        let any = !effects.is_empty()
            || !twin.torque_tone.is_empty()
            || twin.speed_drift.is_some()
            || friction.drag > 0.0
            || friction.stribeck > 0.0
            || spring.is_some()
            || twin.torsional_resonance.is_some();
        any.then(|| Self {
            profile: Profile::new(twin, plant, friction),
            tones: plant.tones(twin),
            friction,
            spring,
            twist: twin.torsional_resonance.as_ref().map(Twist::new),
            effects,
            pulls: false,
            changed: None,
            start: Start::default(),
            push: [0.0; DEGREE],
            asked: [0.0; DEGREE],
            given: [0.0; DEGREE],
            fastest: 0.0,
            falling: [0.0; DEGREE],
            followed: [0.0; DEGREE],
            motion: 0.0,
        })
    }

    /// Inertia over that of the near side.
    pub(super) fn gain(&self) -> f64 {
        self.twist
            .as_ref()
            .map_or(1.0, |twist| 1.0 / (1.0 - twist.share))
    }

    /// Works out what is given in time around a step's start.
    pub(super) fn prepare(&mut self, knot: &Knot, start: Start, far_push: f64) {
        let now_s = start.time_s;
        self.start = start;
        (self.push, self.asked) = self.profile.around(knot, now_s);
        self.given = self.asked;
        self.changed = (knot.driven && self.effects.drives()).then_some(*knot);
        self.pulls = knot.driven;
        self.fastest = self.profile.fastest(knot).max(self.effects.fastest(now_s));
        for tone in &self.tones {
            tone.add_to(&mut self.push, now_s);
            self.fastest = self.fastest.max(tone.turning);
        }
        if let Some(twist) = &mut self.twist {
            twist.push = far_push;
            self.fastest = self.fastest.max(twist.square.sqrt() + twist.damping);
        }
    }

    /// Sets the sign of the motion that friction acts against.
    pub(super) fn set_motion(&mut self, motion: f64) {
        self.motion = motion;
    }

    /// Term `k` of the acceleration, given that of the plain torques and terms 0 to `k` of the speed; works out the states' next.
    pub(super) fn term(&mut self, k: usize, plain: f64, omega: &Series) -> f64 {
        let mut all = plain + self.push[k];
        if let Some(knot) = self.changed {
            let share = self.effects.share(k, &self.start, omega, self.motion);
            let (asked, rate) = effects::changed(&self.given, &share, k);
            self.asked[k] = asked;
            // In place of the push that follows the speed as given, that of the changed one.
            all += self
                .profile
                .push(k, &knot, &self.asked, rate, &mut self.followed)
                - self.push[k];
        }
        if !self.effects.is_empty() {
            all += self.effects.term(k, &self.start, omega, self.motion);
        }
        if self.motion != 0.0 {
            all -= self.motion * self.friction.term(k, omega, &mut self.falling);
        }
        if let Some(spring) = &mut self.spring {
            if self.pulls {
                all += spring.stiffness * spring.stretch.series[k];
            }
            spring.stretch.series[k + 1] = (self.asked[k] - omega[k]) / (k as f64 + 1.0);
        }
        let gain = self.gain();
        if let Some(twist) = &mut self.twist {
            let near = gain * all + twist.share * twist.pull(k);
            // Held by friction, the near side does not move whatever pulls.
            twist.grow(k, if self.motion == 0.0 { 0.0 } else { near });
            near
        } else {
            all
        }
    }

    /// A piece of standing still against friction that holds up to `coulomb` and its Stribeck part, `plain` being the acceleration of
    /// plain torques; the sign of the motion in which the shaft breaks away, if it does at once.
    pub(super) fn rest(&mut self, plain: f64, coulomb: f64, longest_s: f64) -> Result<Piece, f64> {
        self.set_motion(0.0);
        let length = longest_s.min(REST_SHARE / self.fastest);
        let mut pull = [0.0; DEGREE];
        for (k, pull) in pull[..DEGREE - 1].iter_mut().enumerate() {
            let torque = if k == 0 { plain } else { 0.0 };
            *pull = self.term(k, torque, &[0.0; DEGREE]);
        }
        let gain = self.gain();
        let mut holds = [0.0; DEGREE];
        if !self.effects.is_empty() {
            for (k, hold) in holds[..DEGREE - 1].iter_mut().enumerate() {
                *hold = gain * self.effects.hold(k, &self.start);
            }
        }
        holds[0] += gain * (coulomb + self.friction.stribeck);
        let hold = holds[0];
        let holding = |tau: f64| holds.iter().rev().fold(0.0, |sum, c| sum * tau + c);
        let value = |tau: f64| pull.iter().rev().fold(0.0, |sum, c| sum * tau + c);
        let rate = |of: &Series, tau: f64| {
            (1..DEGREE)
                .rev()
                .fold(0.0, |sum, k| sum * tau + of[k] * k as f64)
        };
        let rounding = ROUNDING * (hold.abs() + gain * (plain.abs() + self.push[0].abs()));
        let mut until = length;
        for side in [1.0, -1.0] {
            let spare = |tau: f64| holding(tau) - side * value(tau);
            let growth = |tau: f64| side * rate(&pull, tau) - rate(&holds, tau);
            let grows = growth(0.0) > 0.0;
            if spare(0.0) < 0.0 || (spare(0.0) <= rounding && grows) {
                return Err(side);
            }
            // The pull may also peak within the piece.
            let peak = if spare(until) >= 0.0 && grows && growth(until) < 0.0 {
                bisect(0.0, until, 1.0, growth)
            } else {
                until
            };
            if spare(peak) < 0.0 {
                until = bisect(0.0, peak, 1.0, spare);
                if until <= length * 1e-12 {
                    return Err(side);
                }
            }
        }
        Ok(Piece::rest(until))
    }

    /// Goes to the end of a piece; `terms` of its series are known.
    pub(super) fn finish(&mut self, length_s: f64, terms: usize) {
        if let Some(spring) = &mut self.spring {
            spring.stretch.go_to(length_s, terms);
        }
        if let Some(twist) = &mut self.twist {
            twist.angle.go_to(length_s, terms);
            twist.speed.go_to(length_s, terms);
        }
    }
}
