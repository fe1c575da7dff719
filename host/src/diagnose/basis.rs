//! Patterns that physics leaves in the angle, of unit size: a mechanism is one or a few of them.

use std::f64::consts::TAU;

use super::seen::Seen;
use super::shaft::{Leap, ShaftLaw};

/// A pattern without its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// The disc's error is cos and sin of so many cycles a turn, rad.
    Round {
        /// Cycles a turn.
        order: f64,
    },
    /// The same by the true angle of each edge in place of its grid angle: what a bent shaft would do.
    Lagged {
        /// Cycles a turn.
        order: f64,
    },
    /// A torque goes as cos and sin of so many cycles a turn, N m.
    TorqueOrder {
        /// Cycles a turn.
        order: f64,
    },
    /// A torque goes as cos and sin of a frequency, N m.
    TorqueTone {
        /// Hz.
        f_hz: f64,
    },
    /// A comparator's level goes as cos and sin of a frequency: rises meet it 1 rad later, falls earlier.
    LevelTone {
        /// Hz.
        f_hz: f64,
        /// On one channel, or all.
        channel: Option<usize>,
    },
    /// Falls of a channel are ahead by 1 rad.
    Width {
        /// One channel, or all.
        channel: Option<usize>,
    },
    /// All edges of a channel are ahead by 1 rad.
    Shift {
        /// The channel.
        channel: usize,
    },
    /// Rises of a channel come 1 s late.
    RiseLate {
        /// One channel, or all.
        channel: Option<usize>,
    },
    /// All edges of a channel come 1 s late.
    Late {
        /// The channel.
        channel: usize,
    },
    /// A level settles from a time on: 1 - exp(-(t - from) / tau), rises later by that, rad.
    LevelDrift {
        /// When it begins, s.
        from_s: f64,
        /// Time constant, s.
        tau_s: f64,
    },
    /// A bump exp(-d^2 / 2 width^2) of the disc's error around an angle, rad.
    Bump {
        /// Centre.
        angle_rad: f64,
        /// Sigma.
        width_rad: f64,
        /// One channel, or all.
        channel: Option<usize>,
        /// Rises only, falls only, or both.
        rises: Option<bool>,
    },
    /// 1 N m from a time to another.
    Load {
        /// From, s.
        from_s: f64,
        /// Until, s.
        until_s: f64,
    },
    /// The speed asked for grows by its whole every second.
    Drift,
    /// Dry friction of 1 N m.
    Coulomb,
    /// Viscous friction of 1 N m s.
    Viscous,
    /// Drag of 1 N m s^2.
    Drag,
    /// Friction of 1 N m that goes with the speed as exp(-(w / stribeck)^2).
    Stribeck {
        /// Speed, rad/s.
        rad_s: f64,
    },
    /// Marks lie 1 rad further along forward than in reverse.
    Direction,
    /// A task blocks captures: edges come late by what is left of its time.
    Task {
        /// Its rate, Hz.
        f_hz: f64,
        /// How long it blocks, s.
        busy_s: f64,
        /// When it first blocks, s.
        phase_s: f64,
    },
}

/// Channel and kind of change of a class, seen forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// 0 is A.
    pub channel: usize,
    /// Whether the level rises.
    pub rises: bool,
}

/// What changes at an edge of a class, of so many.
#[must_use]
pub fn change_of(class: usize, classes: i64) -> Change {
    let (channel, rises) = match classes {
        4 => (class % 2, class < 2),
        // A fall, B rise, C fall, A rise, B fall, C rise.
        6 => (class % 3, class % 2 == 1),
        2 => (0, class == 0),
        _ => (0, true),
    };
    Change { channel, rises }
}

/// Channels of a sensor with so many classes.
#[must_use]
pub fn channels(classes: i64) -> usize {
    match classes {
        4 => 2,
        6 => 3,
        _ => 1,
    }
}

impl Basis {
    /// How many numbers size it.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Round { .. }
            | Self::Lagged { .. }
            | Self::TorqueOrder { .. }
            | Self::TorqueTone { .. }
            | Self::LevelTone { .. } => 2,
            _ => 1,
        }
    }

    /// Whether each recording has a size, or a phase, of its own: nothing ties the times of two recordings.
    #[must_use]
    pub const fn timed(self) -> bool {
        matches!(
            self,
            Self::TorqueTone { .. }
                | Self::LevelTone { .. }
                | Self::LevelDrift { .. }
                | Self::Load { .. }
                | Self::Drift
                | Self::Task { .. }
        )
    }

    /// Whether it counts from an angle of the disc.
    #[must_use]
    pub const fn placed(self) -> bool {
        matches!(
            self,
            Self::Round { .. } | Self::Lagged { .. } | Self::TorqueOrder { .. } | Self::Bump { .. }
        )
    }

    /// The pattern along a residual: one column for each number that sizes it.
    #[must_use]
    pub fn columns(self, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
        let each = |value: &dyn Fn(usize, Change) -> f64| -> Vec<Vec<f64>> {
            let disc: Vec<f64> = (0..seen.len())
                .map(|at| value(at, change_of(seen.class(at), seen.classes)))
                .collect();
            vec![disc]
        };
        let hit =
            |channel: Option<usize>, change: Change| channel.is_none_or(|c| c == change.channel);
        let reverse = |at: usize| seen.speeds[at] < 0.0;
        match self {
            Self::Round { order } => {
                let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
                for at in 0..seen.len() {
                    (sin[at], cos[at]) = (order * seen.theta(at)).sin_cos();
                }
                vec![cos, sin]
            }
            Self::Lagged { order } => {
                let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
                for at in 0..seen.len() {
                    (sin[at], cos[at]) = (order * seen.true_theta(at)).sin_cos();
                }
                vec![cos, sin]
            }
            Self::TorqueOrder { order } => {
                let theta: Vec<f64> = (0..seen.len()).map(|at| seen.true_theta(at)).collect();
                pushed_round(seen, law, &|at, share| {
                    // Where the shaft turned round in between, it was just past the place.
                    let came = theta[at] - theta[at.saturating_sub(1)];
                    order * (theta[at] + share * came)
                })
            }
            Self::TorqueTone { f_hz } => pushed_round(seen, law, &|at, share| {
                TAU * f_hz * (seen.times_s[at] + share * seen.readings[at].leap.after_s)
            }),
            Self::LevelTone { f_hz, channel } => {
                let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
                for at in 0..seen.len() {
                    let change = change_of(seen.class(at), seen.classes);
                    if hit(channel, change) {
                        let size = if change.rises { -1.0 } else { 1.0 };
                        let (s, c) = (TAU * f_hz * (seen.times_s[at])).sin_cos();
                        (sin[at], cos[at]) = (size * s, size * c);
                    }
                }
                vec![cos, sin]
            }
            Self::Width { channel } => {
                each(&|_, change| f64::from(u8::from(!change.rises && hit(channel, change))))
            }
            Self::Shift { channel } => {
                each(&|_, change| f64::from(u8::from(change.channel == channel)))
            }
            Self::RiseLate { channel } => each(&|at, change| {
                // Backwards a rise is passed as a fall.
                let late = hit(channel, change) && change.rises != reverse(at);
                if late { -seen.speeds[at] } else { 0.0 }
            }),
            Self::Late { channel } => each(&|at, change| {
                if change.channel == channel {
                    -seen.speeds[at]
                } else {
                    0.0
                }
            }),
            Self::LevelDrift { from_s, tau_s } => each(&|at, change| {
                let since = (seen.times_s[at] - from_s).max(0.0);
                let size = -(-since / tau_s).exp_m1();
                if change.rises { -size } else { size }
            }),
            Self::Bump {
                angle_rad,
                width_rad,
                channel,
                rises,
            } => {
                let bump: Vec<f64> = (0..seen.edges)
                    .map(|edge| {
                        let class = (edge + seen.shift).rem_euclid(seen.classes);
                        let change = change_of(usize::try_from(class).unwrap_or(0), seen.classes);
                        if !hit(channel, change) || rises.is_some_and(|rises| rises != change.rises)
                        {
                            return 0.0;
                        }
                        let way = edge as f64 * TAU / seen.edges as f64 - angle_rad;
                        let way = way.rem_euclid(TAU);
                        let widths = way.min(TAU - way) / width_rad;
                        (-0.5 * widths * widths).exp()
                    })
                    .collect();
                each(&|at, _| bump[seen.edge(at)])
            }
            Self::Load { from_s, until_s } => {
                vec![pushed(seen, &|at, _| {
                    let now = seen.times_s[at];
                    let before = now - seen.readings[at].leap.after_s;
                    // The part of the interval under load pushes as much as the whole would in part.
                    let under = (now.min(until_s) - before.max(from_s)).max(0.0);
                    if now > before {
                        under / (now - before) / law.inertia
                    } else {
                        0.0
                    }
                })]
            }
            Self::Drift => vec![pushed(seen, &|at, end| {
                // What the drive adds to follow: J dw/dt and damping times what it asks for on top.
                let h = seen.readings[at].leap.after_s;
                let time = seen.times_s[at] - (1.0 - end) * h;
                let speed = seen.speeds[at];
                speed + law.damping(time, speed) * speed * time
            })],
            Self::Coulomb => braked(seen, law, &|speed| speed.signum()),
            Self::Viscous => braked(seen, law, &|speed| speed),
            Self::Drag => braked(seen, law, &|speed| speed * speed.abs()),
            Self::Stribeck { rad_s } => braked(seen, law, &|speed| {
                speed.signum() * (-(speed / rad_s).powi(2)).exp()
            }),
            Self::Direction => each(&|at, _| if reverse(at) { 0.5 } else { -0.5 }),
            Self::Task {
                f_hz,
                busy_s,
                phase_s,
            } => each(&|at, _| {
                let since = (seen.times_s[at] - phase_s).rem_euclid(1.0 / f_hz);
                if since < busy_s {
                    -seen.speeds[at].abs() * (busy_s - since)
                } else {
                    0.0
                }
            }),
        }
    }
}

/// Response of the angle to an acceleration, rad/s^2, given at an edge's interval: at its start 0, middle 0.5, end 1.
fn pushed(seen: &Seen, push: &dyn Fn(usize, f64) -> f64) -> Vec<f64> {
    let mut state = [0.0; 2];
    (0..seen.len())
        .map(|at| {
            if seen.follows(at) {
                state = [0.0; 2];
            } else if at > 0 {
                let leap = seen.readings[at].leap;
                state = leap.step(state, [push(at, 0.0), push(at, 0.5), push(at, 1.0)]);
            }
            state[0]
        })
        .collect()
}

/// Response to torques that go as cos and sin of a phase, which is given at a share of the interval before an edge.
fn pushed_round(seen: &Seen, law: &ShaftLaw, phase: &dyn Fn(usize, f64) -> f64) -> Vec<Vec<f64>> {
    /// Radians of a rhythm that a step may take.
    const STEP: f64 = 0.7;
    let size = 1.0 / law.inertia;
    let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
    let (mut even, mut odd) = ([0.0; 2], [0.0; 2]);
    let mut last = phase(0, 0.0).sin_cos();
    for at in 1..seen.len() {
        if seen.follows(at) {
            (even, odd) = ([0.0; 2], [0.0; 2]);
            last = phase(at, 0.0).sin_cos();
            continue;
        }
        let whole = seen.readings[at].leap;
        let steps = ((phase(at, 0.0) - phase(at, -1.0)).abs() / STEP)
            .ceil()
            .clamp(1.0, 200.0);
        let leap = Leap {
            after_s: whole.after_s / steps,
            ..whole
        };
        for step in 1..=steps as usize {
            let share = |part: f64| (step as f64 + part) / steps - 1.0;
            let half = phase(at, share(-0.5)).sin_cos();
            let here = phase(at, share(0.0)).sin_cos();
            even = leap.step(even, [last.1 * size, half.1 * size, here.1 * size]);
            odd = leap.step(odd, [last.0 * size, half.0 * size, here.0 * size]);
            last = here;
        }
        (cos[at], sin[at]) = (even[0], odd[0]);
    }
    vec![cos, sin]
}

/// Response to a friction, N m at a speed, while the drive is off: what is on balances friction.
fn braked(seen: &Seen, law: &ShaftLaw, friction: &dyn Fn(f64) -> f64) -> Vec<Vec<f64>> {
    vec![pushed(seen, &|at, _| {
        if law.driven(seen.times_s[at]) {
            0.0
        } else {
            -friction(seen.speeds[at]) / law.inertia
        }
    })]
}
