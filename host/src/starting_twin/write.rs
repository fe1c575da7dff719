//! A starting twin as TOML, and its numbers for JSON.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use super::delays;
use super::estimate::{Starting, changes};
use super::sensor::{Found, Source};
use super::{ClassDelay, Estimate, Rhythm};
use crate::diagnose::spread::Spread;
use crate::report::si;
use crate::twin::{Encoder, Twin, TwinError};

/// A number of the twin, as JSON has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Number {
    /// Its key in the twin.
    pub key: String,
    /// Its value.
    pub value: f64,
    /// Its unit; 1 of a count.
    pub unit: &'static str,
    /// Its 95 % interval; null of a count.
    pub ci95: Option<[f64; 2]>,
    /// Why it is a guess, and how to make it sure; null where it is none.
    pub guess: Option<String>,
}

/// How torques without an inertia are to be read.
const OF_INERTIA: &str = "in units of an inertia of 1 kg m^2";

impl Found {
    /// Where the counts of the sensor come from.
    pub(super) fn shown_by(&self) -> &'static str {
        match self.source {
            Source::Given => "as given",
            Source::Index => "edges between index pulses",
            Source::Header => "the recording's header",
            Source::Pattern => "the pattern that repeats",
        }
    }

    /// Key, name and count of what the sensor counts.
    pub(super) fn counted(&self) -> (&'static str, &'static str, u32) {
        match self.encoder {
            Encoder::Quadrature { lines, .. } => ("lines", "lines", lines),
            Encoder::Hall { pole_pairs } => ("pole_pairs", "pole pairs", pole_pairs),
            Encoder::Wheel { teeth, .. } => ("teeth", "teeth", teeth),
        }
    }
}

impl Starting {
    /// What orders of the disc may be beside it.
    pub(super) fn disc_guess(&self) -> Option<String> {
        let disc = self.disc.as_ref()?;
        let mut guesses = Vec::new();
        if !disc.alike.is_empty() {
            let some: Vec<String> = disc
                .alike
                .iter()
                .map(|(order, amplitude)| format!("{order} ({})", plain(&si(*amplitude, "rad"))))
                .collect();
            guesses.push(format!(
                "orders {} may be torque ripple in place of the disc: record a second speed, half as fast again, and give both recordings",
                some.join(", ")
            ));
        }
        if !self.anchored {
            guesses.push(
                "nothing marks a place of the turn, so edge 0 is where this recording starts: connect an index to keep it".to_owned(),
            );
        }
        (!guesses.is_empty()).then(|| guesses.join("; "))
    }

    /// What one speed does not tell of what swings.
    pub(super) fn rhythm_guess(&self) -> Option<&'static str> {
        let one_speed = !changes(self.speed_r_min) && !self.rhythms.is_empty();
        one_speed.then_some("at one speed an order and a frequency look the same, and torque and run-out: record a second speed, half as fast again, and give both recordings")
    }

    /// Delays as keys of the twin.
    pub(super) fn delay_keys(&self) -> Vec<(String, &ClassDelay)> {
        let (_, skew) = delays::declared(&self.delays);
        let name = |channel: u8| ["a", "b", "c"][usize::from(channel.min(2))];
        let told = self.delays.iter().filter(|delay| delay.late_s.value > 0.0);
        let each = told.filter_map(|delay| {
            let channel = name(delay.channel);
            match (skew.is_some(), delay.rises) {
                (true, true) => Some((format!("channel_skew.{channel}_s"), delay)),
                (true, false) => None,
                (false, rises) => {
                    let flank = if rises { "rise_s" } else { "fall_s" };
                    Some((format!("edge_delay.{channel}.{flank}"), delay))
                }
            }
        });
        each.collect()
    }
}

/// A text without the spaces that only print.
fn plain(text: &str) -> String {
    text.replace(['\u{a0}', '\u{202f}'], " ")
}

pub(super) fn interval(estimate: Estimate, unit: &str) -> String {
    let [low, high] = estimate.ci95;
    plain(&format!("{} to {}", si(low, unit), si(high, unit)))
}

/// All numbers that were found.
#[must_use]
pub fn numbers(starting: &Starting) -> Vec<Number> {
    let (key, _, count) = starting.found.counted();
    let mut all = vec![Number {
        key: key.to_owned(),
        value: f64::from(count),
        unit: "1",
        ci95: None,
        guess: starting.found.guess.clone(),
    }];
    let mut add = |key: String, estimate: Estimate, unit: &'static str, guess: Option<String>| {
        all.push(Number {
            key,
            value: estimate.value,
            unit,
            ci95: Some(estimate.ci95),
            guess,
        });
    };
    if let Some(jitter) = starting.jitter_s {
        add("timer.jitter_s".to_owned(), jitter, "s", None);
    }
    let unit = "N^2 m^2 s at 1 kg m^2";
    add(
        "noise.white.psd_n2_m2_s".to_owned(),
        starting.torque,
        unit,
        None,
    );
    for (key, delay) in starting.delay_keys() {
        add(key, delay.late_s, "s", None);
    }
    for (at, torque) in starting.torques.iter().enumerate() {
        let key = format!("ripple[{at}].torque_n_m");
        add(key, torque.size, "N m at 1 kg m^2", None);
    }
    for (at, rhythm) in starting.rhythms.iter().enumerate() {
        let (section, _, size, unit) = rhythm.keys();
        let before = starting.rhythms[..at].iter();
        let at = before.filter(|one| one.keys().0 == section).count();
        let guess = starting.rhythm_guess().map(str::to_owned);
        add(format!("{section}[{at}].{size}"), rhythm.size, unit, guess);
    }
    if let Some(disc) = &starting.disc {
        let key = "errors.rms_rad".to_owned();
        add(key, disc.rms_rad, "rad", starting.disc_guess());
    }
    all
}

/// The twin's text; `recordings` are named in it, `errors` is the file of the disc's errors beside it.
///
/// # Errors
/// [`TwinError`] where what was found is no twin.
pub fn text(
    starting: &Starting,
    recordings: &[String],
    errors: Option<&Path>,
) -> Result<String, TwinError> {
    let text = written(starting, recordings, errors);
    // What can't be read back is not written.
    Twin::parse(&text, "twin")?;
    Ok(text)
}

fn written(starting: &Starting, recordings: &[String], errors: Option<&Path>) -> String {
    let mut text = String::new();
    // Writing to a string never fails.
    let mut line = |words: String| {
        let _ = writeln!(text, "{words}");
    };
    line(format!(
        "# A starting twin of {}: {} edges, {:.1} turns, {:.3} s.",
        recordings.join(", ").replace(char::is_control, "?"),
        starting.edges,
        starting.turns,
        starting.seconds
    ));
    line("# Behind a number stands its 95 % interval. What the recordings do not make sure is marked as a guess.".to_owned());
    line("seed = 1".to_owned());
    line(format!(
        "duration = {{ turns = {:.0} }}",
        starting.turns.ceil()
    ));
    free_phases(&starting.rhythms, &mut line);
    line(String::new());
    sensor(&starting.found, &mut line);
    disc(starting, errors, &mut line);
    line(format!(
        "# No [drive]: the course of the speed is the recordings' own, {:.4} to {:.4} r/min. To simulate, add one.",
        starting.speed_r_min[0], starting.speed_r_min[1]
    ));
    line(format!(
        "# No [shaft]: torques are {OF_INERTIA}. With shaft.inertia_kg_m2 = J multiply torques by J, the density of the noise by J^2."
    ));
    line(String::new());
    for torque in &starting.torques {
        line("[[ripple]]".to_owned());
        line(format!("order = {:?}", torque.order));
        line(format!(
            "torque_n_m = {:.4e}  # {}",
            torque.size.value,
            interval(torque.size, "N m")
        ));
        line(format!("phase_rad = {:.4}", torque.phase_rad));
        line(String::new());
    }
    sections(&starting.rhythms, starting.rhythm_guess(), &mut line);
    line("[noise.white]".to_owned());
    let [low, high] = starting.torque.ci95;
    line(format!(
        "psd_n2_m2_s = {:.4e}  # {low:.3e} to {high:.3e}",
        starting.torque.value
    ));
    line(String::new());
    timing(starting, &mut line);
    text
}

/// The text of a twin of a sensor and a clock, and of what swings, which knows nothing else.
#[must_use]
pub fn bare_text(found: &Found, clock_hz: u64, rhythms: &[Rhythm]) -> String {
    let mut text = "seed = 1\nduration = { turns = 1 }\n".to_owned();
    let mut line = |words: String| {
        let _ = writeln!(text, "{words}");
    };
    free_phases(rhythms, &mut line);
    line(String::new());
    sensor(found, &mut line);
    sections(rhythms, None, &mut line);
    line("[timer]".to_owned());
    line(format!("clock_hz = {clock_hz}"));
    text
}

fn sensor(found: &Found, line: &mut impl FnMut(String)) {
    let shown_by = found.shown_by();
    if let Some(guess) = &found.guess {
        line(format!("# guess: {guess}"));
    }
    match &found.encoder {
        Encoder::Quadrature { lines, index } => {
            line("[encoder.quadrature]".to_owned());
            line(format!("lines = {lines}  # {shown_by}"));
            line(format!("index = {index}"));
        }
        Encoder::Hall { pole_pairs } => {
            line("[encoder.hall]".to_owned());
            line(format!("pole_pairs = {pole_pairs}  # {shown_by}"));
        }
        Encoder::Wheel {
            teeth,
            missing,
            gaps,
        } => {
            line("[encoder.wheel]".to_owned());
            line(format!(
                "teeth = {teeth}  # {shown_by}, missing ones counted"
            ));
            if *missing > 0 {
                line(format!("missing = {missing}"));
            }
            if !gaps.is_empty() {
                let each = gaps
                    .iter()
                    .map(|gap| format!("{{ at = {}, missing = {} }}", gap.at, gap.missing));
                line(format!("gaps = [{}]", each.collect::<Vec<_>>().join(", ")));
            }
        }
    }
    line(String::new());
}

fn free_phases(rhythms: &[Rhythm], line: &mut impl FnMut(String)) {
    if !rhythms.is_empty() {
        line("free_phases = true  # a recording begins anywhere in the turn of a belt or a gear, or in a tone's cycle".to_owned());
    }
}

fn sections(rhythms: &[Rhythm], guess: Option<&str>, line: &mut impl FnMut(String)) {
    for rhythm in rhythms {
        if let Some(guess) = guess {
            line(format!("# guess: {guess}"));
        }
        let (section, rate, size, unit) = rhythm.keys();
        line(format!("[[{section}]]"));
        let [low, high] = rhythm.rate.ci95;
        // Digits of a hundredth of the interval, and one more.
        let digits = (3.0 - (high - low).log10()).clamp(1.0, 15.0) as usize;
        line(format!(
            "{rate} = {:.digits$}  # {low:.digits$} to {high:.digits$}",
            rhythm.rate.value
        ));
        line(format!(
            "{size} = {:.4e}  # {}",
            rhythm.size.value,
            interval(rhythm.size, unit)
        ));
        line(format!("phase_rad = {:.4}", rhythm.phase_rad));
        line(String::new());
    }
}

fn disc(starting: &Starting, errors: Option<&Path>, line: &mut impl FnMut(String)) {
    let Some(disc) = &starting.disc else {
        line("# No [errors]: no pattern repeats every turn beyond noise.".to_owned());
        line(String::new());
        return;
    };
    if let Some(guess) = starting.disc_guess() {
        line(format!("# guess: {guess}"));
    }
    let size = format!(
        "RMS {} ({}), standard error of an edge {}",
        plain(&si(disc.rms_rad.value, "rad")),
        interval(disc.rms_rad, "rad"),
        plain(&sure(&disc.spread))
    );
    match errors {
        Some(path) => {
            line("[errors]".to_owned());
            let name = toml::Value::String(path.display().to_string());
            line(format!("csv = {name}  # {size}"));
            let waves = disc.spread.rounded_waves_rad();
            if !waves.is_empty() {
                let waves: Vec<String> = waves.iter().map(|wave| format!("{wave:e}")).collect();
                line(format!(
                    "wave_standard_errors_rad = [{}]  # of orders 1 to {}",
                    waves.join(", "),
                    waves.len()
                ));
            }
            if starting.delay_keys().is_empty() && starting.delay_limit_s.is_none() {
                line(format!(
                    "learned_r_min = {:.6}  # delays of edge classes, which one speed does not tell from the disc, are in the list",
                    0.5 * (starting.speed_r_min[0] + starting.speed_r_min[1])
                ));
            }
        }
        None => line(format!(
            "# No [errors], as they need a file (--errors PATH): {size}"
        )),
    }
    line(String::new());
}

fn timing(starting: &Starting, line: &mut impl FnMut(String)) {
    let keys = starting.delay_keys();
    match (&keys[..], starting.delay_limit_s) {
        ([], Some(limit_s)) => line(format!(
            "# No delays of edge classes are seen; between rise and fall, or channels, they are less than {} (95 %).",
            plain(&si(limit_s, "s"))
        )),
        ([], None) => line(
            "# Delays of edge classes can't be told from the disc at one speed: record another one.".to_owned(),
        ),
        _ => {
            line("# Delays against the edges that come first.".to_owned());
            let (section, _) = keys[0].0.split_once('.').unwrap_or(("edge_delay", ""));
            line(format!("[{section}]"));
        }
    }
    for (key, delay) in &keys {
        let (_, key) = key.split_once('.').unwrap_or(("", key));
        line(format!(
            "{key} = {:.4e}  # {}",
            delay.late_s.value,
            interval(delay.late_s, "s")
        ));
    }
    line(String::new());
    line("[timer]".to_owned());
    line(format!("clock_hz = {}", starting.clock_hz));
    match starting.jitter_s {
        Some(jitter) => line(format!(
            "jitter_s = {:.4e}  # {}",
            jitter.value,
            interval(jitter, "s")
        )),
        None => line(format!(
            "# Stamps: {} RMS, {}; a tick's rounding is all that is sure.",
            plain(&si(starting.stamp_s.value, "s")),
            interval(starting.stamp_s, "s")
        )),
    }
}

/// Standard error of an edge, and without the slow waves that make most of it.
pub(super) fn sure(spread: &Spread) -> String {
    let whole = si(spread.whole_rad(), "rad");
    match spread.waves_rad.len() {
        0 => whole,
        waves => format!(
            "{whole} (but for orders 1 to {waves} {})",
            si(spread.edge_rad, "rad")
        ),
    }
}
