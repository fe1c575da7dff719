//! From cells to the catalogue's names: which mechanism a group of effects is, with its numbers by the twin's names and their errors.

use std::f64::consts::TAU;

use super::diagnosis::{AtSpeed, EdgeOff, Parameter, Place};
use super::effect::{Carrier, Effect, Growth, On, Site, is_exact};
use super::model::{Board, Fit, Term};
use super::numbers;
use crate::effect::words::letter;
use crate::mechanism::Mechanism;

/// Deviations of a 95 % interval.
pub const NINETY_FIVE: f64 = 1.96;

/// The mechanism that a group of effects is; none of the catalogue's where none is.
#[must_use]
pub fn mechanism(effects: &[Effect]) -> Mechanism {
    let Some(first) = effects.first() else {
        return Mechanism::Unknown;
    };
    let grows = |effect: &Effect| effect.growth != Growth::Constant;
    if effects.iter().any(grows) {
        return Mechanism::Unknown;
    }
    match (first.site, first.carrier) {
        (Site::Disc(on), Carrier::Steady) if on.rises.is_some() => Mechanism::WidthError,
        (Site::Disc(on), Carrier::Steady) if on != On::ALL => Mechanism::QuadratureError,
        (Site::Stamp(on), Carrier::Steady) if on.rises.is_some() => Mechanism::EdgeDelay,
        (Site::Stamp(on), Carrier::Steady) if on != On::ALL => Mechanism::ChannelSkew,
        (Site::Disc(_), Carrier::Order(1.0)) => Mechanism::Eccentricity,
        (Site::Disc(_), Carrier::Order(2.0)) => Mechanism::DiscTilt,
        (Site::Disc(_), Carrier::Order(order)) if order.fract() == 0.0 => Mechanism::LineError,
        (Site::Disc(_), Carrier::Order(_)) => Mechanism::Bearing,
        (Site::Disc(_), Carrier::Bump(..)) => Mechanism::LocalDefect,
        (Site::Disc(_), Carrier::Direction) => Mechanism::Hysteresis,
        (Site::Level(_), Carrier::Tone(_)) => Mechanism::ThresholdRipple,
        (Site::Level(_), Carrier::Settling(..)) => Mechanism::ThresholdDrift,
        (Site::Torque, Carrier::Order(order)) if is_exact(order) => Mechanism::TorqueRipple,
        (Site::Torque, Carrier::Order(_)) => Mechanism::GearMesh,
        (Site::Torque, Carrier::Tone(_)) => Mechanism::TorqueTone,
        (Site::Torque, Carrier::Window(..)) => Mechanism::LoadStep,
        (Site::Torque, Carrier::Power(0.0 | 1.0 | 2.0) | Carrier::Stribeck(_)) => {
            Mechanism::Friction
        }
        (Site::Drive, Carrier::Time | Carrier::Settling(..)) => Mechanism::SpeedDrift,
        _ => Mechanism::Unknown,
    }
}

/// A number of a finding with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// The twin's name of it.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error; none where it is exact.
    pub error: Option<f64>,
}

impl Number {
    /// As a finding has it.
    #[must_use]
    pub fn parameter(&self, unit: &str) -> Parameter {
        let by = self.error.map(|error| NINETY_FIVE * error);
        Parameter {
            ci95: by.map(|by| [self.value - by, self.value + by]),
            unit: unit.to_owned(),
            ..Parameter::exact(self.value)
        }
    }
}

impl Fit {
    /// Column of a term's number.
    #[must_use]
    pub fn column(&self, term: usize, number: usize) -> Option<usize> {
        self.of.iter().position(|of| *of == (term, number))
    }

    /// Covariance of two columns; nothing of what is none.
    #[must_use]
    pub fn covariance_of(&self, columns: [Option<usize>; 2]) -> [[f64; 2]; 2] {
        columns.map(|one| {
            columns.map(|other| one.zip(other).map_or(0.0, |both| self.covariance[both]))
        })
    }

    /// Numbers of a finding.
    #[must_use]
    pub fn numbers(&self, group: usize) -> Vec<Number> {
        let own = self.model.finding(group);
        let each = own.enumerate().map(|(nth, (at, term))| {
            let mut numbers = self.numbers_of(at, term);
            // Harmonics go by their orders, as far as these are read.
            if let (1.., Carrier::Order(order)) = (nth, term.effect.carrier) {
                let order = (1e4 * order).round() / 1e4;
                numbers.retain(|number| number.name != "order");
                let named = numbers.iter_mut();
                named.for_each(|number| number.name = format!("order_{order}.{}", number.name));
            }
            numbers
        });
        each.flatten().collect()
    }

    /// 95 % intervals of a term's size, or of its amplitude, and of its effect's numbers; none of what is not fitted.
    #[must_use]
    pub fn intervals(&self, at: usize) -> Vec<Option<[f64; 2]>> {
        let term = &self.model.terms[at];
        let column = |number: usize| self.column(at, number);
        let covariance = self.covariance_of([column(0), column(1)]);
        let size = match term.sizes[..] {
            [cos, sin] => (
                cos.hypot(sin),
                numbers::wave_errors([cos, sin], &covariance)[0],
            ),
            _ => (term.sizes[0], covariance[0][0].max(0.0).sqrt()),
        };
        let knobs = term.effect.knobs().into_iter().enumerate();
        let knobs = knobs.map(|(number, knob)| {
            let column = column(term.effect.sizes() + number)?;
            Some((knob, self.covariance[(column, column)].max(0.0).sqrt()))
        });
        let each = std::iter::once(Some(size)).chain(knobs);
        let within = |(value, error): (f64, f64)| {
            let by = NINETY_FIVE * error;
            [value - by, value + by]
        };
        each.map(|one| one.map(within)).collect()
    }

    /// The size, or amplitude, of a term that goes with the speed at one speed, with its 95 % interval: at 1 rad/s, which no shaft may have
    /// had, hardly anything is known of it. None of other terms.
    #[must_use]
    pub fn at_speed(&self, at: usize, rad_s: f64) -> Option<AtSpeed> {
        let term = &self.model.terms[at];
        let Growth::Speed(power) = term.effect.growth else {
            return None;
        };
        let by = rad_s.powf(power);
        let (size, along) = match term.sizes[..] {
            [cos, sin] => {
                let size = cos.hypot(sin).max(f64::MIN_POSITIVE);
                (size, vec![cos / size, sin / size])
            }
            _ => (term.sizes[0], vec![1.0]),
        };
        // Along what one of each number changes.
        let last = term.effect.sizes() + term.effect.knobs().len() - 1;
        let sizes = along.into_iter().enumerate();
        let each = sizes.chain([(last, size * rad_s.ln())]);
        let each = each.filter_map(|(number, slope)| Some((self.column(at, number)?, slope * by)));
        let each: Vec<(usize, f64)> = each.collect();
        let wide = NINETY_FIVE * self.error_along(&each);
        let there = size * by;
        // Its logarithm goes evenly with the power, where the sign is sure.
        let ci95 = if wide < there.abs() {
            let factor = (wide / there.abs()).exp();
            let [near, far] = [there / factor, there * factor];
            [near.min(far), near.max(far)]
        } else {
            [there - wide, there + wide]
        };
        Some(AtSpeed {
            rad_s,
            size: there,
            ci95,
        })
    }

    /// Standard error of what goes with columns by slopes.
    fn error_along(&self, slopes: &[(usize, f64)]) -> f64 {
        let pairs = slopes
            .iter()
            .flat_map(|a| slopes.iter().map(move |b| (a, b)));
        let variance = pairs.map(|(a, b)| a.1 * b.1 * self.covariance[(a.0, b.0)]);
        variance.sum::<f64>().max(0.0).sqrt()
    }

    /// Edges of the disc that a term moves about a place of it, with 95 % intervals; none where these are many. Between a few edges the place
    /// may be wider and its height larger, and move each edge as much: that, and not the height, is what the recordings say.
    #[must_use]
    pub fn edges_off(&self, at: usize, board: &Board) -> Vec<EdgeOff> {
        /// Edges at the most, and the part of the largest error that is none.
        const MOST: usize = 6;
        const NONE: f64 = 0.02;
        let term = &self.model.terms[at];
        let (Site::Disc(_), Carrier::Bump(..), Growth::Constant) =
            (term.effect.site, term.effect.carrier, term.effect.growth)
        else {
            return Vec::new();
        };
        let Some(record) = board.benches.first().map(|bench| &bench.record) else {
            return Vec::new();
        };
        let error = |effect: &Effect, size, slot| record.error_of(slot, effect, &[size]);
        let (effect, size, knobs) = (term.effect, term.sizes[0], term.effect.knobs());
        let seen = board.seen();
        let each = (0..seen.len()).filter(|slot| seen[*slot]);
        let each: Vec<(usize, f64)> = each
            .map(|slot| (slot, error(&effect, size, slot)))
            .collect();
        let most = each
            .iter()
            .fold(0.0, |most: f64, (_, off)| most.max(off.abs()));
        let each = each.into_iter().filter(|(_, off)| off.abs() > NONE * most);
        let each: Vec<(usize, f64)> = each.collect();
        if each.len() > MOST {
            return Vec::new();
        }
        let numbers = 0..=knobs.len();
        let columns = numbers.filter_map(|number| Some((number, self.column(at, number)?)));
        let columns: Vec<(usize, usize)> = columns.collect();
        let off = |(slot, off): (usize, f64)| {
            let slope = |(number, column): &(usize, usize)| {
                // Small beside how far off it may be, up to where the error bends.
                let step = 1e-3 * self.covariance[(*column, *column)].max(0.0).sqrt();
                let (mut size, mut knobs) = (size, knobs.clone());
                match number.checked_sub(1) {
                    None => size += step,
                    Some(knob) => knobs[knob] += step,
                }
                let more = error(&effect.with_knobs(&knobs), size, slot) - off;
                if step > 0.0 { more / step } else { 0.0 }
            };
            let slopes: Vec<(usize, f64)> = columns.iter().map(|one| (one.1, slope(one))).collect();
            let by = NINETY_FIVE * self.error_along(&slopes);
            EdgeOff {
                edge: record.edge_of(slot) as usize,
                error_rad: off,
                ci95: [off - by, off + by],
            }
        };
        each.into_iter().map(off).collect()
    }

    fn numbers_of(&self, at: usize, term: &Term) -> Vec<Number> {
        let Effect { site, carrier, .. } = term.effect;
        let mut all = Vec::new();
        let mut add = |name: &str, value: f64, error: Option<f64>| {
            let name = name.to_owned();
            all.push(Number { name, value, error });
        };
        let covariance = self.covariance_of([0, 1].map(|number| self.column(at, number)));
        let name = self.size_name(&term.effect);
        if let [cos, sin] = term.sizes[..] {
            let [of_amplitude, of_phase] = numbers::wave_errors([cos, sin], &covariance);
            // amplitude sin(x + phase), or sin(x - phase) of a disc's orders.
            let phase = match name.as_str() {
                "amplitude_rad" => -cos.atan2(sin),
                _ => cos.atan2(sin),
            };
            add(&name, cos.hypot(sin), Some(of_amplitude));
            add("phase_rad", phase.rem_euclid(TAU), Some(of_phase));
        } else {
            // Of falls alone it counts the other way.
            let size = match site {
                Site::Stamp(on) if on.rises == Some(false) => -1.0,
                _ => 1.0,
            } * term.sizes[0];
            add(&name, size, Some(covariance[0][0].max(0.0).sqrt()));
        }
        let names: &[&str] = match (site, carrier) {
            (Site::Disc(_), Carrier::Order(1.0 | 2.0)) => &[],
            (_, Carrier::Order(_)) => &["order"],
            (_, Carrier::Tone(_)) => &["f_hz"],
            (_, Carrier::Chirp(..)) => &["f_hz", "rate_hz_s"],
            (_, Carrier::Bump(..)) => &["angle_rad", "width_rad"],
            (_, Carrier::Window(..)) => &["from_s", "until_s"],
            (_, Carrier::Settling(..)) => &["from_s", "tau_s"],
            (_, Carrier::Stribeck(_)) => &["stribeck_rad_s"],
            _ => &[],
        };
        for ((number, name), knob) in (0..).zip(names).zip(term.effect.knobs()) {
            let column = self.column(at, term.effect.sizes() + number);
            let error = column.map(|column| self.covariance[(column, column)].max(0.0).sqrt());
            match (site, carrier, *name) {
                // What is open at an end has none, and a drive settles from the start on.
                (_, Carrier::Window(..), _) if error.is_none() => {}
                (Site::Drive, _, "from_s") => {}
                (_, Carrier::Bump(..), "angle_rad") => add(name, knob.rem_euclid(TAU), error),
                _ => add(name, knob, error),
            }
        }
        all
    }

    /// The name of an effect's size.
    fn size_name(&self, effect: &Effect) -> String {
        let third =
            |term: &Term| matches!(term.effect.site, Site::Disc(on) if on.channel == Some(2));
        let of = |on: On| {
            on.channel
                .map_or_else(String::new, |one| letter(one).to_lowercase())
        };
        let name = match (effect.site, effect.carrier) {
            (Site::Disc(on), Carrier::Steady) if on.rises.is_some() => match on.channel {
                None => "width_rad",
                Some(_) => return format!("width_{}_rad", of(on)),
            },
            (Site::Disc(on), Carrier::Steady) if self.model.terms.iter().any(third) => {
                return format!("shift_{}_rad", of(on));
            }
            (Site::Disc(_), Carrier::Steady) => "quadrature_rad",
            (Site::Disc(_), Carrier::Order(order)) if order.fract() == 0.0 => "amplitude_rad",
            (Site::Disc(_), Carrier::Bump(..)) => "error_rad",
            (Site::Disc(_), Carrier::Direction) | (Site::Level(_), _) => "angle_rad",
            (Site::Disc(_), _) => "runout_rad",
            (Site::Stamp(on), Carrier::Steady) => match (on.channel, on.rises) {
                (None, _) => "rise_less_fall_s",
                (_, Some(_)) => return format!("{}.rise_less_fall_s", of(on)),
                (_, None) => return format!("{}_less_a_s", of(on)),
            },
            (Site::Stamp(_), _) => "delay_s",
            (Site::Drive, Carrier::Time) => "fraction_per_s",
            (Site::Drive, _) => "fraction",
            (Site::Torque, Carrier::Power(0.0)) => "coulomb_n_m",
            (Site::Torque, Carrier::Power(1.0)) => "viscous_n_m_s",
            (Site::Torque, Carrier::Power(_)) => "drag_n_m_s2",
            (Site::Torque, Carrier::Stribeck(_)) => "stribeck_n_m",
            (Site::Torque, _) => "torque_n_m",
            (Site::Declared(_), _) => "size",
        };
        name.to_owned()
    }
}

/// The unit of a mechanism's number; where the twin declares no inertia only torque over inertia is known.
#[must_use]
pub fn unit(mechanism: Mechanism, name: &str, inertia_known: bool) -> String {
    let unit = mechanism.card().unit(name);
    match inertia_known || !unit.starts_with("N m") {
        true => unit.to_owned(),
        false => format!("{unit}/(kg m^2)"),
    }
}

/// Where a group of effects shows.
#[must_use]
pub fn place(board: &Board, effects: &[Effect]) -> Place {
    let mut place = Place::default();
    let first = board.benches.first();
    let classes = first.map_or(1, |bench| bench.record.classes);
    let add = |all: &mut Vec<String>, name: String| {
        if !all.contains(&name) {
            all.push(name);
        }
    };
    for effect in effects {
        match effect.carrier {
            Carrier::Order(order) => place.orders.push(order),
            Carrier::Tone(f_hz) | Carrier::Chirp(f_hz, _) => place.frequencies_hz.push(f_hz),
            Carrier::Bump(angle, _) => place.angles_deg.push(angle.rem_euclid(TAU).to_degrees()),
            Carrier::Window(from, until) => place
                .times_s
                .extend([from, until].into_iter().filter(|t| t.is_finite())),
            Carrier::Settling(from, _) if from > 0.0 => place.times_s.push(from),
            _ => {}
        }
        let on = match effect.site {
            Site::Disc(on) | Site::Stamp(on) | Site::Level(on) => on,
            _ => continue,
        };
        for class in 0..classes as usize {
            let change = super::record::change(class, classes);
            if on != On::ALL && on.has(change) {
                let flank = if change.rises { "rise" } else { "fall" };
                let name = match classes > 2 {
                    true => format!("{} {flank}", letter(change.channel)),
                    false => flank.to_owned(),
                };
                add(&mut place.edge_classes, name);
            }
        }
        if let Some(channel) = on.channel {
            add(&mut place.channels, letter(channel).to_owned());
        }
    }
    place
}
