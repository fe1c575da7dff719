//! What a finding's effects make, as fitted, over what they follow: drawn from the very effects and sizes that the words come from.

use std::f64::consts::{PI, TAU};

use crate::diagnose::diagnosis::{Answer, RecordingFacts, Sized};
use crate::diagnose::effect::{Carrier, Effect, Growth, Site};
use crate::diagnose::plant::{Here, sign};
use crate::report::plot::{Axis, Series, Xy};
use crate::report::{Colour, Plot};
use crate::reports::diagnose::words::sentence;

use super::cells::{amplitude, site_unit};
use super::told;
use crate::effect::words::site;

/// Points of a curve.
const POINTS: usize = 400;
/// Cycles that are drawn of what repeats.
const CYCLES: f64 = 3.0;
/// Deviations of a bump that are drawn to either side.
const REACH: f64 = 6.0;

/// What a curve is drawn over.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    /// Angle of the shaft, rad, between two ends.
    Angle(f64, f64),
    /// Time, s, until an end.
    Time(f64),
    /// Speed, rad/s, between two ends.
    Speed(f64, f64),
}

/// A plot of a finding's effects with its caption; none where a curve would say no more than the words.
pub(super) fn plot(answer: &Answer, index: usize) -> Option<(Plot, String)> {
    let effects = told::effects(answer, index);
    let recordings = &answer.diagnosis.recordings;
    let first = effects.first()?;
    if effects
        .iter()
        .any(|other| other.effect.site != first.effect.site)
    {
        return None;
    }
    let growth = first.effect.growth != Growth::Constant;
    let plain = matches!(
        first.effect.carrier,
        Carrier::Steady | Carrier::Order(_) | Carrier::Tone(_) | Carrier::Chirp(..)
    );
    if growth && (effects.len() > 1 || !plain) {
        return None;
    }
    let over = over(&first.effect, recordings)?;
    // All effects of a curve follow the same: else a sum of them means nothing.
    let same = |sized: &Sized| same_kind(&sized.effect, &first.effect);
    if !effects.iter().all(same) {
        return None;
    }
    let (from, until, axis) = match over {
        Over::Angle(from, until) => (from, until, Axis::new("Shaft angle", "deg")),
        Over::Time(until) => (0.0, until, Axis::new("Time", "s")),
        Over::Speed(from, until) => (from, until, Axis::new("Speed", "rad/s")),
    };
    let at = |step: usize| from + (until - from) * step as f64 / POINTS as f64;
    let value = |x: f64| -> f64 {
        let here = here(over, x);
        match growth {
            // How it grows, whatever its phase.
            true => {
                let still = Effect {
                    carrier: Carrier::Steady,
                    ..first.effect
                };
                amplitude(first) * still.value(here)[0]
            }
            false => effects.iter().map(|sized| sum(sized, here)).sum(),
        }
    };
    let scale = match over {
        Over::Angle(..) => 360.0 / TAU,
        _ => 1.0,
    };
    let x: Vec<f64> = (0..=POINTS).map(|step| scale * at(step)).collect();
    let factor = match first.effect.site {
        Site::Drive => 100.0,
        _ => 1.0,
    };
    let y: Vec<f64> = (0..=POINTS).map(|step| factor * value(at(step))).collect();
    let noun = site(&first.effect.site);
    let name = match (growth, first.effect.sizes()) {
        (true, 2) => format!("Amplitude of {noun}"),
        _ => sentence(&noun),
    };
    let unit = match first.effect.site {
        Site::Drive => "%",
        site => site_unit(&site, answer.inertia_known),
    };
    let mut y_axis = Axis::new(name, unit);
    let most = y.iter().copied().fold(0.0, f64::max);
    if growth && y.iter().all(|y| *y >= 0.0) {
        // A growth is to be seen beside the size itself.
        y_axis = y_axis.range(0.0, 1.08 * most);
    }
    let plot = Xy::new(axis, y_axis).series(Series::line("fitted", &x, &y).colour(Colour::Green));
    let caption = match growth {
        true => "How its size goes, as fitted.",
        false => "Its course as fitted.",
    };
    Some((plot.into(), caption.to_owned()))
}

fn sum(sized: &Sized, here: Here) -> f64 {
    let value = sized.effect.value(here);
    sized
        .sizes
        .iter()
        .zip(value)
        .map(|(size, value)| size * value)
        .sum()
}

fn here(over: Over, x: f64) -> Here {
    let (angle, time, speed) = match over {
        Over::Angle(..) => (x, 0.0, 0.0),
        Over::Time(_) => (0.0, x, 0.0),
        Over::Speed(..) => (0.0, 0.0, x),
    };
    Here {
        time_s: time,
        inside_s: time,
        angle,
        speed,
        way: sign(speed),
    }
}

fn same_kind(effect: &Effect, other: &Effect) -> bool {
    let kind = |carrier: &Carrier| match carrier {
        Carrier::Power(_) | Carrier::Stribeck(_) => 1,
        Carrier::Order(_) => 2,
        Carrier::Bump(..) => 3,
        Carrier::Tone(_) => 4,
        _ => 5,
    };
    kind(&effect.carrier) == kind(&other.carrier)
}

/// What an effect's curve goes over; none where it is a number and no curve, or the recordings show only one value.
fn over(effect: &Effect, recordings: &[RecordingFacts]) -> Option<Over> {
    let longest = recordings
        .iter()
        .map(|facts| facts.seconds)
        .fold(0.0, f64::max);
    let speeds = recordings.iter().flat_map(|facts| facts.speed_r_min);
    let fastest = speeds.map(f64::abs).fold(0.0, f64::max) * TAU / 60.0;
    let time = (longest > 0.0).then_some(Over::Time(longest));
    let speed = |from: f64| (fastest > 0.0).then_some(Over::Speed(from * fastest, fastest));
    match effect.growth {
        Growth::Even(_) => return time,
        Growth::Modulated(f_hz, ..) => {
            return (f_hz > 0.0).then(|| Over::Time(longest.min(CYCLES / f_hz)));
        }
        Growth::Speed(power) => return speed(if power < 0.0 { 0.1 } else { 0.0 }),
        Growth::Constant | Growth::Own | Growth::Past(_) => {}
    }
    match effect.carrier {
        Carrier::Order(order) if order > 0.0 => {
            Some(Over::Angle(0.0, TAU * (CYCLES / order).min(1.0)))
        }
        Carrier::Tone(f_hz) if f_hz > 0.0 => Some(Over::Time(CYCLES / f_hz)),
        Carrier::Bump(middle, sigma) => {
            let reach = (REACH * sigma.abs()).min(PI);
            let middle = middle.rem_euclid(TAU);
            (reach > 0.0).then_some(Over::Angle(middle - reach, middle + reach))
        }
        Carrier::Window(..) | Carrier::Settling(..) => time,
        Carrier::Time => time,
        Carrier::Power(_) | Carrier::Stribeck(_) => speed(1e-3),
        Carrier::Order(_)
        | Carrier::Tone(_)
        | Carrier::Chirp(..)
        | Carrier::Steady
        | Carrier::Direction => None,
    }
}
