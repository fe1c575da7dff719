//! An effect in plain words, from its cell alone: where it enters, what it follows, how its size goes.

use std::f64::consts::TAU;

use super::{Carrier, Effect, Growth, On, Site};
use crate::report::si_digits;

/// An effect as a clause: `torque at 41.3 Hz, its amplitude grows by 3 % a second`.
#[must_use]
pub fn words(effect: &Effect) -> String {
    let only = effect.only.map_or_else(String::new, |only| {
        format!(", in recording {} alone", u16::from(only) + 1)
    });
    format!(
        "{}{}{}{only}",
        site(&effect.site),
        carrier(effect),
        growth(effect)
    )
}

/// The letter of a channel.
#[must_use]
pub fn letter(channel: u8) -> &'static str {
    ["A", "B", "C"][usize::from(channel.min(2))]
}

/// What an effect changes, as a noun.
#[must_use]
pub fn site(site: &Site) -> String {
    match site {
        Site::Torque => "torque".to_owned(),
        Site::Drive => "drive speed".to_owned(),
        Site::Disc(on) => format!("angle of {}", edges(*on)),
        Site::Level(On { channel: None, .. }) => "comparator level".to_owned(),
        Site::Level(On {
            channel: Some(channel),
            ..
        }) => format!("comparator level of channel {}", letter(*channel)),
        Site::Stamp(on) => format!("delay of {}", edges(*on)),
        Site::Declared(_) => "a number that the twin declares".to_owned(),
    }
}

fn edges(on: On) -> String {
    let edges = match (on.rises, on.channel) {
        (None, None) => "all edges",
        (None, Some(_)) => "the edges",
        (Some(true), _) => "rising edges",
        (Some(false), _) => "falling edges",
    };
    match on.channel {
        None => edges.to_owned(),
        Some(channel) => format!("{edges} of channel {}", letter(channel)),
    }
}

fn carrier(effect: &Effect) -> String {
    match effect.carrier {
        Carrier::Steady => String::new(),
        Carrier::Order(order) => format!(" at order {}", number(order, "")),
        Carrier::Tone(f_hz) => format!(" at {}", number(f_hz, "Hz")),
        Carrier::Chirp(f_hz, rate) => format!(
            " at {} at time 0, {} by {} a second",
            number(f_hz, "Hz"),
            if rate < 0.0 { "falling" } else { "rising" },
            number(rate.abs(), "Hz")
        ),
        Carrier::Bump(middle, sigma) => format!(
            " around {} degrees, with a sigma of {} degrees",
            number(middle.rem_euclid(TAU).to_degrees(), ""),
            number(sigma.abs().to_degrees(), "")
        ),
        Carrier::Window(from_s, until_s) => match (from_s.is_finite(), until_s.is_finite()) {
            (true, true) => format!(
                " from {} until {}",
                number(from_s, "s"),
                number(until_s, "s")
            ),
            (true, false) => format!(" from {} on", number(from_s, "s")),
            (false, true) => format!(" until {}", number(until_s, "s")),
            (false, false) => " all the time".to_owned(),
        },
        Carrier::Settling(from_s, tau_s) => format!(
            " from {} on, settling with a time constant of {}",
            number(from_s, "s"),
            number(tau_s, "s")
        ),
        Carrier::Time => " in proportion to time".to_owned(),
        Carrier::Direction => " by the direction of motion".to_owned(),
        Carrier::Power(power) => format!(" against the motion, {}", power_of_speed(power)),
        Carrier::Stribeck(speed) => format!(
            " against the motion, fading above {} (Stribeck)",
            number(speed, "rad/s")
        ),
    }
}

fn power_of_speed(power: f64) -> String {
    match power {
        0.0 => "the same at every speed (Coulomb)".to_owned(),
        1.0 => "proportional to speed (viscous)".to_owned(),
        2.0 => "proportional to the square of the speed".to_owned(),
        power => format!("with the power {} of the speed", number(power, "")),
    }
}

/// How the size of an effect goes, after what it changes and follows.
#[must_use]
pub fn growth(effect: &Effect) -> String {
    let amplitude = match effect.sizes() {
        2 => "its amplitude",
        _ => "its size",
    };
    match effect.growth {
        Growth::Constant => match effect.carrier {
            Carrier::Steady
            | Carrier::Order(_)
            | Carrier::Tone(_)
            | Carrier::Chirp(..)
            | Carrier::Bump(..) => ", constant".to_owned(),
            _ => String::new(),
        },
        Growth::Own => ", as the own errors of the marks".to_owned(),
        Growth::Past(_) => ", past the speed at which the disc was learned".to_owned(),
        Growth::Even(rate) => format!(
            ", {amplitude} {} by {} % a second",
            if rate < 0.0 { "falls" } else { "grows" },
            number(100.0 * rate.abs(), "")
        ),
        Growth::Speed(power) => match power {
            0.0 => format!(", {amplitude} the same at every speed"),
            1.0 => format!(", {amplitude} proportional to speed"),
            2.0 => format!(", {amplitude} proportional to the square of the speed"),
            power => format!(
                ", {amplitude} with the power {} of the speed",
                number(power, "")
            ),
        },
        Growth::Modulated(f_hz, depth, _) => format!(
            ", {amplitude} swings by {} % at {}",
            number(100.0 * depth.abs(), ""),
            number(f_hz, "Hz")
        ),
    }
}

/// Four digits without zeros at their end, with unit.
#[must_use]
pub fn number(value: f64, unit: &str) -> String {
    let (digits, unit) = si_digits(value, unit, 4);
    let digits = match digits.contains('.') && !digits.contains('×') {
        true => digits.trim_end_matches('0').trim_end_matches('.'),
        false => &digits,
    };
    format!("{digits} {unit}").trim_end().to_owned()
}
