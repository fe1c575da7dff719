//! The mark that a mechanism leaves: what it is locked to, how its size goes with speed, which edges it moves.

use std::fmt;

use serde::Deserialize;

/// What a residual keeps step with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
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

impl fmt::Display for LockedTo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Angle => "the angle, each turn alike",
            Self::FirstOrder => "order 1 of the turn",
            Self::SecondOrder => "order 2 of the turn",
            Self::OneAngle => "one angle of the turn",
            Self::WholeOrders => "whole orders of the turn",
            Self::FractionalOrder => "an order that is not whole",
            Self::Frequency => "a fixed frequency",
            Self::FrequencyBand => "a band around a fixed frequency",
            Self::SlowTime => "time, slowly",
            Self::Instants => "single instants",
            Self::Speed => "the speed",
            Self::Direction => "the direction of motion",
            Self::Reversals => "the way since the last reversal",
            Self::Nothing => "nothing: a noise",
        })
    }
}

/// How a mechanism tells edges apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
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

impl fmt::Display for EdgeClasses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Alike => "all edges alike",
            Self::Own => "every edge by its own",
            Self::RiseAgainstFall => "rising against falling edges",
            Self::ChannelAgainstChannel => "channel against channel",
            Self::OftenOne => "often one channel, or one kind of edge",
        })
    }
}
