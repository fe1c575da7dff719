//! The sensor of a recording: its lines, pole pairs or teeth with all gaps, and where that is a guess.

use realfft::RealFftPlanner;
use thiserror::Error;

use crate::diagnose::edges::{Sensor, WheelFound, find_wheel};
use crate::pattern;
use crate::recording::{Channels, Header, Row};
use crate::survey::Survey;
use crate::twin::{Encoder, Gap};

/// What the command line says of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Given {
    /// Lines, pole pairs or teeth (missing ones counted) a turn.
    pub lines: Option<u32>,
    /// Teeth missing at the end of the turn.
    pub missing: u32,
}

/// Where the number of lines comes from, best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// The intervals repeat.
    Pattern,
    /// The recording's header says it.
    Header,
    /// The edges between index pulses were counted.
    Index,
    /// An option says it.
    Given,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// As a twin declares it.
    pub encoder: Encoder,
    /// As edges are placed by it.
    pub sensor: Sensor,
    /// Where its counts come from.
    pub source: Source,
    /// Why it is a guess, and how to make it sure; none where it is sure.
    pub guess: Option<String>,
}

/// A sensor whose turn can't be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the {name} a turn can't be told: no header says them and no pattern repeats every turn; give --lines M"
)]
pub struct SensorUnknown {
    /// What is counted.
    pub name: &'static str,
}

/// Finds the sensor of a recording.
///
/// # Errors
/// [`SensorUnknown`] where nothing tells how many edges a turn has.
pub fn find(survey: &Survey, rows: &[Row], given: Given) -> Result<Found, SensorUnknown> {
    match survey.header.channels {
        Channels::Quadrature { .. } => quadrature(survey, rows, given),
        Channels::Hall => hall(survey, given),
        Channels::Wheel | Channels::Pulses => wheel(survey, rows, given),
    }
}

/// A number of lines in a header, under the name that the sensor's lines have.
fn noted(header: &Header, wanted: &str) -> Option<u32> {
    let (_, value) = header.notes.iter().find(|(key, _)| key == wanted)?;
    value.parse().ok().filter(|&lines| lines > 0)
}

/// The guess that a turn is what intervals repeat after.
fn repeats(name: &str, count: u32) -> String {
    format!(
        "the intervals repeat after {count} {name}; a turn of 2 or 3 times as many can't be told from it. Count the {name} and give --lines"
    )
}

fn quadrature(survey: &Survey, rows: &[Row], given: Given) -> Result<Found, SensorUnknown> {
    let index = (survey.index_pulses > 0).then(|| survey.index_state());
    let found = |lines: u32, source: Source, guess: Option<String>| Found {
        encoder: Encoder::Quadrature {
            lines,
            index: index.is_some(),
        },
        sensor: Sensor::Quadrature { lines, index },
        source,
        guess,
    };
    if let Some(lines) = given.lines {
        return Ok(found(lines, Source::Given, None));
    }
    if let Some(lines) = survey.lines() {
        return Ok(found(lines, Source::Index, None));
    }
    if let Some(lines) = noted(&survey.header, "lines") {
        return Ok(found(lines, Source::Header, None));
    }
    let short = survey
        .repeat(4)
        .and_then(|repeat| repeat.edges.try_into().ok());
    let edges: Option<u32> = short.or_else(|| long_repeat(rows, 4));
    let lines = edges.ok_or(SensorUnknown { name: "lines" })? / 4;
    Ok(found(lines, Source::Pattern, Some(repeats("lines", lines))))
}

fn hall(survey: &Survey, given: Given) -> Result<Found, SensorUnknown> {
    let found = |pole_pairs: u32, source: Source, guess: Option<String>| Found {
        encoder: Encoder::Hall { pole_pairs },
        sensor: Sensor::Hall { pole_pairs },
        source,
        guess,
    };
    if let Some(pairs) = given.lines {
        return Ok(found(pairs, Source::Given, None));
    }
    if let Some(pairs) = noted(&survey.header, "pole_pairs") {
        return Ok(found(pairs, Source::Header, None));
    }
    let edges = survey
        .repeat(6)
        .and_then(|repeat| u32::try_from(repeat.edges).ok());
    let pairs = edges.ok_or(SensorUnknown { name: "pole pairs" })? / 6;
    let guess = repeats("pole pairs", pairs);
    Ok(found(pairs, Source::Pattern, Some(guess)))
}

fn wheel(survey: &Survey, rows: &[Row], given: Given) -> Result<Found, SensorUnknown> {
    let both_edges = survey.header.channels == Channels::Wheel;
    let found = |present: Vec<bool>, source: Source, guess: Option<String>| Found {
        encoder: encoder_of(&present),
        sensor: Sensor::Wheel {
            present,
            both_edges,
        },
        source,
        guess,
    };
    if let Some(teeth) = given.lines {
        let there = teeth.saturating_sub(given.missing);
        let present = (0..teeth).map(|tooth| tooth < there).collect();
        return Ok(found(present, Source::Given, None));
    }
    let seen = find_wheel(rows, both_edges);
    let noted = noted(&survey.header, "teeth");
    Ok(match (seen, noted) {
        (Some(wheel), Some(teeth)) => {
            let turn = wheel.present.len();
            if (teeth as usize).is_multiple_of(turn) {
                let present = wheel.present.repeat(teeth as usize / turn);
                found(present, Source::Header, None)
            } else {
                let guess = format!(
                    "the header says {teeth} teeth, the intervals repeat after {turn}. Count the teeth and give --lines and --missing"
                );
                found(vec![true; teeth as usize], Source::Header, Some(guess))
            }
        }
        (Some(wheel), None) => {
            let guess = guessed(&wheel, survey, both_edges);
            found(wheel.present, Source::Pattern, Some(guess))
        }
        (None, Some(teeth)) => found(vec![true; teeth as usize], Source::Header, None),
        (None, None) => return Err(SensorUnknown { name: "teeth" }),
    })
}

/// A wheel as a twin declares it.
fn encoder_of(present: &[bool]) -> Encoder {
    let mut gaps: Vec<Gap> = Vec::new();
    for (tooth, _) in present.iter().enumerate().filter(|(_, there)| !**there) {
        let at = tooth as u32;
        match gaps.last_mut() {
            Some(gap) if gap.at + gap.missing == at => gap.missing += 1,
            _ => gaps.push(Gap { at, missing: 1 }),
        }
    }
    let teeth = present.len() as u32;
    match gaps[..] {
        [Gap { at, missing }] if at + missing == teeth => Encoder::Wheel {
            teeth,
            missing,
            gaps: Vec::new(),
        },
        _ => Encoder::Wheel {
            teeth,
            missing: 0,
            gaps,
        },
    }
}

/// Why a wheel that was found is a guess.
fn guessed(wheel: &WheelFound, survey: &Survey, both_edges: bool) -> String {
    let teeth = wheel.present.len();
    let there = wheel.present.iter().filter(|there| **there).count();
    let mut guess = format!(
        "{:.0} % of the turns looked at show {there} teeth on {teeth} places",
        100.0 * wheel.confidence
    );
    let others = wheel.alternatives.iter().take(2);
    for (present, share) in others {
        let there = present.iter().filter(|there| **there).count();
        guess += &format!(
            ", {:.0} % show {there} on {} places",
            100.0 * share,
            present.len()
        );
    }
    // A turn of several such patterns, whose parts differ a little, repeats better as a whole.
    let edges = there as u32 * (1 + u32::from(both_edges));
    let once = survey.repeat_at(edges);
    let better = (2..=3).find(|times| {
        const LESS_LEFT: f64 = 0.5;
        let more = survey.repeat_at(times * edges);
        matches!((once, more), (Some(once), Some(more)) if more.left < LESS_LEFT * once.left)
    });
    guess += &match better {
        Some(times) => format!("; the intervals repeat better after {times} of them"),
        None => "; a turn of 2 or 3 times as many can't be told from it".to_owned(),
    };
    guess + ". Count the teeth and give --lines and --missing"
}

/// Edges after which the intervals of a long turn come again: the first high peak of their autocorrelation.
fn long_repeat(rows: &[Row], classes: usize) -> Option<u32> {
    // Peak over the standard error of a correlation by chance; share of the highest that the first one has to have.
    const SURE: f64 = 8.0;
    const NEARLY: f64 = 0.7;
    let intervals: Vec<f64> = rows
        .windows(2)
        .map(|pair| (pair[1].ticks - pair[0].ticks) as f64)
        .collect();
    let mut relative = pattern::relative(&intervals);
    for class in 0..classes {
        let own = || relative.iter().skip(class).step_by(classes);
        let mean = own().sum::<f64>() / own().count().max(1) as f64;
        let each = relative.iter_mut().skip(class).step_by(classes);
        each.for_each(|value| *value = (*value - mean).clamp(-1.0, 1.0));
    }
    let count = relative.len();
    if count < 4 * classes {
        return None;
    }
    let length = (2 * count).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (
        planner.plan_fft_forward(length),
        planner.plan_fft_inverse(length),
    );
    relative.resize(length, 0.0);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut relative, &mut spectrum).ok()?;
    spectrum
        .iter_mut()
        .for_each(|value| *value = value.norm_sqr().into());
    let mut products = back.make_output_vec();
    back.process(&mut spectrum, &mut products).ok()?;
    let whole = products[0];
    // What neighbours share says nothing of a turn; three turns have to be there.
    let lags = (30..=count / (3 * classes)).map(|lines| lines * classes);
    let correlations: Vec<(usize, f64)> = lags
        .map(|lag| {
            let share = count as f64 / (count - lag) as f64;
            (lag, share * products[lag] / whole)
        })
        .collect();
    let highest = correlations
        .iter()
        .fold(0.0, |highest: f64, (_, height)| highest.max(*height));
    if highest * (count as f64).sqrt() < SURE {
        return None;
    }
    let first = correlations
        .iter()
        .find(|(_, height)| *height > NEARLY * highest);
    first.and_then(|(lag, _)| u32::try_from(*lag).ok())
}
