//! The mark that a mechanism leaves: what it is locked to, how its size goes with speed, which edges it moves.

use serde::{Deserialize, Serialize};

use super::Mechanism;

/// What a residual keeps step with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LockedTo {
    /// The angle: it repeats each turn, with any content.
    Angle,
    /// Order 1 alone.
    FirstOrder,
    /// Order 2 alone.
    SecondOrder,
    /// One angle of the turn.
    OneAngle,
    /// A few whole orders.
    WholeOrders,
    /// An order that is not whole: it turns with the shaft and does not repeat each turn.
    FractionalOrder,
    /// A fixed frequency in time.
    Frequency,
    /// A band around a fixed frequency.
    FrequencyBand,
    /// Time since the start, slowly.
    SlowTime,
    /// Single instants.
    Instants,
    /// The speed.
    Speed,
    /// The direction of motion.
    Direction,
    /// The way since the last reversal.
    Reversals,
    /// Nothing: a noise.
    Nothing,
}

/// How a mechanism tells edges apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeClasses {
    /// All edges alike.
    Alike,
    /// Every edge has its own.
    Own,
    /// Rises one way, falls the other.
    RiseAgainstFall,
    /// One channel against the others.
    ChannelAgainstChannel,
    /// Often one channel, or one edge of it.
    OftenOne,
}

impl Mechanism {
    /// What it keeps step with: one, or each that it may. A delay that is the same for every edge of a class is locked to the angle,
    /// as the classes are, at one speed.
    #[must_use]
    pub const fn locked_to(self) -> &'static [LockedTo] {
        match self {
            Self::LineError
            | Self::WidthError
            | Self::QuadratureError
            | Self::EdgeDelay
            | Self::ChannelSkew
            | Self::ClosedLoop => &[LockedTo::Angle],
            Self::Eccentricity => &[LockedTo::FirstOrder],
            Self::DiscTilt => &[LockedTo::SecondOrder],
            Self::LocalDefect => &[LockedTo::OneAngle],
            Self::Hysteresis => &[LockedTo::Direction],
            Self::ThresholdRipple | Self::TorqueTone => &[LockedTo::Frequency],
            Self::ThresholdDrift | Self::SpeedDrift => &[LockedTo::SlowTime],
            Self::TimestampJitter => &[LockedTo::Nothing],
            Self::CaptureLatency => &[LockedTo::Frequency, LockedTo::Nothing],
            Self::LostEdges | Self::ExtraEdges | Self::IndexSlip | Self::LoadStep => {
                &[LockedTo::Instants]
            }
            Self::TorqueRipple => &[LockedTo::WholeOrders],
            Self::GearMesh | Self::Bearing => &[LockedTo::FractionalOrder],
            Self::TorsionalResonance => &[LockedTo::FrequencyBand],
            Self::Friction | Self::StickSlip => &[LockedTo::Speed],
            Self::Backlash => &[LockedTo::Reversals],
            Self::Unknown => &[],
        }
    }

    /// Exponent n where the size of the angle residual goes as speed^n; none where it follows no power of the speed. What is fixed
    /// in time, such as a torque tone, swings the shaft by the same angle at any speed: 0. A [`Mechanism::Bearing`] has 0 as run-out
    /// and -2 as torque, so none.
    #[must_use]
    pub const fn speed_exponent(self) -> Option<i8> {
        match self {
            Self::LineError
            | Self::WidthError
            | Self::QuadratureError
            | Self::Eccentricity
            | Self::DiscTilt
            | Self::LocalDefect
            | Self::Hysteresis
            | Self::ThresholdRipple
            | Self::ThresholdDrift
            | Self::LostEdges
            | Self::ExtraEdges
            | Self::IndexSlip
            | Self::TorqueTone
            | Self::TorsionalResonance
            | Self::Backlash => Some(0),
            Self::EdgeDelay | Self::ChannelSkew | Self::TimestampJitter | Self::CaptureLatency => {
                Some(1)
            }
            Self::TorqueRipple | Self::GearMesh => Some(-2),
            Self::Bearing
            | Self::Friction
            | Self::StickSlip
            | Self::LoadStep
            | Self::SpeedDrift
            | Self::ClosedLoop
            | Self::Unknown => None,
        }
    }

    /// How it tells edges apart.
    #[must_use]
    pub const fn edge_classes(self) -> EdgeClasses {
        match self {
            Self::LineError => EdgeClasses::Own,
            Self::WidthError | Self::EdgeDelay | Self::ThresholdRipple | Self::ThresholdDrift => {
                EdgeClasses::RiseAgainstFall
            }
            Self::QuadratureError | Self::ChannelSkew => EdgeClasses::ChannelAgainstChannel,
            Self::LocalDefect | Self::LostEdges | Self::ExtraEdges => EdgeClasses::OftenOne,
            Self::Eccentricity
            | Self::DiscTilt
            | Self::Hysteresis
            | Self::TimestampJitter
            | Self::CaptureLatency
            | Self::IndexSlip
            | Self::TorqueRipple
            | Self::GearMesh
            | Self::Bearing
            | Self::TorqueTone
            | Self::TorsionalResonance
            | Self::Friction
            | Self::StickSlip
            | Self::Backlash
            | Self::LoadStep
            | Self::SpeedDrift
            | Self::ClosedLoop
            | Self::Unknown => EdgeClasses::Alike,
        }
    }
}
