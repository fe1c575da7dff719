//! Patterns that physics leaves in the angle, of unit size: a mechanism is one or a few of them. Its file makes their columns.

pub use super::classes::{Change, change_of, channels};
use super::seen::Seen;
use super::shaft::ShaftLaw;

/// A pattern without its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// The disc's error is cos and sin of so many cycles a turn, rad.
    Round {
        /// Cycles a turn.
        order: f64,
    },
    /// The same by the true angle of each edge in place of its grid angle: what a bent shaft or a bearing does.
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
    /// Falls of a channel come 1 s early, its rises staying with those of the others.
    FallEarly {
        /// The channel.
        channel: usize,
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
        /// On one channel, or all.
        channel: Option<usize>,
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
    /// The speed asked for settles at twice itself: 1 - exp(-t / tau) more.
    Warming {
        /// Time constant, s.
        tau_s: f64,
    },
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
                | Self::Warming { .. }
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
        (self.mechanism().card().handling.columns)(self, seen, law)
    }
}
