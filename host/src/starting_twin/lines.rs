//! A starting twin in lines for people: names and values.

use std::fmt::Write as _;

use super::estimate::Starting;
use super::sensor::Found;
use super::write::{interval, sure};
use crate::report::si;
use crate::twin::Encoder;

impl Found {
    /// It in words, with its guess.
    #[must_use]
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let (_, name, count) = self.counted();
        let kind = match &self.encoder {
            Encoder::Quadrature { index: true, .. } => "quadrature with index",
            Encoder::Quadrature { .. } => "quadrature without index",
            Encoder::Hall { .. } => "three Hall sensors",
            Encoder::Wheel { .. } => "toothed wheel",
        };
        let mut gaps = String::new();
        if let Encoder::Wheel {
            teeth,
            missing,
            gaps: some,
        } = &self.encoder
        {
            if *missing > 0 {
                let _ = write!(gaps, ", {missing} missing at the end");
            }
            for gap in some {
                let _ = write!(gaps, ", {} missing at {} of {teeth}", gap.missing, gap.at);
            }
        }
        let sensor = format!("{kind}, {count} {name}{gaps} ({})", self.shown_by());
        let guess = self.guess.iter().map(|guess| ("Guess", guess.clone()));
        std::iter::once(("Sensor", sensor)).chain(guess).collect()
    }
}

/// What was found, in lines for people: names and values.
#[must_use]
pub fn lines_of(starting: &Starting) -> Vec<(&'static str, String)> {
    let mut lines = starting.found.lines();
    lines.push((
        "Recorded",
        format!(
            "{} edges, {:.1} turns, {:.3} s, {:.4} to {:.4} r/min",
            starting.edges,
            starting.turns,
            starting.seconds,
            starting.speed_r_min[0],
            starting.speed_r_min[1]
        ),
    ));
    lines.push((
        "Stamps",
        format!(
            "{} RMS ({})",
            si(starting.stamp_s.value, "s"),
            interval(starting.stamp_s, "s")
        ),
    ));
    let [low, high] = starting.torque.ci95;
    lines.push((
        "Torque noise",
        format!(
            "{:.3e} N^2 m^2 s at 1 kg m^2 ({low:.3e} to {high:.3e})",
            starting.torque.value
        ),
    ));
    let keys = starting.delay_keys();
    for (key, delay) in &keys {
        let value = si(delay.late_s.value, "s");
        lines.push((
            "Delay",
            format!("{key} {value} ({})", interval(delay.late_s, "s")),
        ));
    }
    if let Some(limit_s) = starting.delay_limit_s {
        lines.push(("Delays", format!("none seen above {}", si(limit_s, "s"))));
    }
    for torque in &starting.torques {
        lines.push((
            "Torque",
            format!(
                "order {}: {} at 1 kg m^2 ({})",
                torque.order,
                si(torque.size.value, "N m"),
                interval(torque.size, "N m")
            ),
        ));
    }
    for rhythm in &starting.rhythms {
        lines.push((
            "Swings",
            format!(
                "{}: {} ({})",
                rhythm.words(),
                si(rhythm.size.value, rhythm.keys().3),
                interval(rhythm.size, rhythm.keys().3)
            ),
        ));
    }
    if let Some(disc) = &starting.disc {
        lines.push((
            "Disc",
            format!(
                "{} RMS ({}), each edge ± {}",
                si(disc.rms_rad.value, "rad"),
                interval(disc.rms_rad, "rad"),
                sure(&disc.spread)
            ),
        ));
    }
    let guesses = [
        starting.rhythm_guess().map(str::to_owned),
        starting.disc_guess(),
    ];
    lines.extend(guesses.into_iter().flatten().map(|guess| ("Guess", guess)));
    lines
}
