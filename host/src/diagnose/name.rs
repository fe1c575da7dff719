//! From cells to the catalogue's names: which mechanism a group of effects is, with its numbers by the twin's names and their errors.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::DVector;

use super::effect::{Carrier, Effect, Growth, On, Site, is_exact};
use super::model::{Board, Fit, Term};
use crate::diagnose::diagnosis::{Parameter, Place};
use crate::mechanism::Mechanism;

/// Deviations of a 95 % interval.
pub const NINETY_FIVE: f64 = 1.96;

/// The mechanism that a group of effects is; none of the catalogue's where none is.
#[must_use]
pub fn mechanism(effects: &[Effect]) -> Mechanism {
    let Some(first) = effects.first() else {
        return Mechanism::Unknown;
    };
    if effects
        .iter()
        .any(|effect| effect.growth != Growth::Constant)
    {
        return Mechanism::Unknown;
    }
    match (first.site, first.carrier) {
        (Site::Disc(On { rises: Some(_), .. }), Carrier::Steady) => Mechanism::WidthError,
        (
            Site::Disc(On {
                channel: Some(_),
                rises: None,
            }),
            Carrier::Steady,
        ) => Mechanism::QuadratureError,
        (Site::Stamp(On { rises: Some(_), .. }), Carrier::Steady) => Mechanism::EdgeDelay,
        (
            Site::Stamp(On {
                channel: Some(_),
                rises: None,
            }),
            Carrier::Steady,
        ) => Mechanism::ChannelSkew,
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
        (Site::Torque, Carrier::Power(power)) if [0.0, 1.0, 2.0].contains(&power) => {
            Mechanism::Friction
        }
        (Site::Torque, Carrier::Stribeck(_)) => Mechanism::Friction,
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

impl Fit {
    /// Columns of a term's number.
    fn column(&self, term: usize, number: usize) -> Option<usize> {
        self.of.iter().position(|of| *of == (term, number))
    }

    /// Standard error of a function of numbers, from its slopes.
    fn error(&self, slopes: &[(Option<usize>, f64)]) -> f64 {
        let mut gradient = DVector::zeros(self.covariance.nrows());
        for (column, slope) in slopes {
            if let Some(column) = column {
                gradient[*column] += slope;
            }
        }
        let variance = gradient.dot(&(&self.covariance * &gradient));
        variance.max(0.0).sqrt()
    }

    /// Numbers of a group of terms.
    #[must_use]
    pub fn numbers(&self, group: usize) -> Vec<Number> {
        let terms = self.model.terms.iter().enumerate();
        let own = terms.filter(|(_, term)| term.group == group);
        let each = own.enumerate().map(|(nth, (at, term))| {
            let mut numbers = self.numbers_of(at, term);
            // Harmonics go by their orders.
            if let (1.., Carrier::Order(order)) = (nth, term.effect.carrier) {
                numbers.retain(|number| number.name != "order");
                let named = numbers.iter_mut();
                named.for_each(|number| number.name = format!("order_{order}.{}", number.name));
            }
            numbers
        });
        each.flatten().collect()
    }

    fn numbers_of(&self, at: usize, term: &Term) -> Vec<Number> {
        let mut all = Vec::new();
        let sizes = term.effect.sizes();
        let mut add = |name: &str, value: f64, error: Option<f64>| {
            all.push(Number {
                name: name.to_owned(),
                value,
                error,
            })
        };
        let knob = |number: usize| self.column(at, sizes + number);
        let of_knob = |number: usize| {
            knob(number).map(|column| self.covariance[(column, column)].max(0.0).sqrt())
        };
        let channel = |on: On| {
            on.channel
                .map_or("", |channel| ["a", "b", "c"][usize::from(channel.min(2))])
        };
        if sizes == 2 {
            let (cos, sin) = (term.sizes[0], term.sizes[1]);
            let amplitude = cos.hypot(sin);
            let columns = (self.column(at, 0), self.column(at, 1));
            let square = (amplitude * amplitude).max(f64::MIN_POSITIVE);
            let of_amplitude =
                self.error(&[(columns.0, cos / amplitude), (columns.1, sin / amplitude)]);
            let of_phase = self.error(&[(columns.0, sin / square), (columns.1, -cos / square)]);
            let (name, minus) = match (term.effect.site, term.effect.carrier) {
                (Site::Disc(_), Carrier::Order(order)) if order.fract() == 0.0 => {
                    ("amplitude_rad", true)
                }
                (Site::Disc(_), _) => ("runout_rad", false),
                (Site::Level(_), _) => ("angle_rad", false),
                (Site::Stamp(_), _) => ("delay_s", false),
                _ => ("torque_n_m", false),
            };
            // amplitude sin(x + phase), or sin(x - phase) of a disc's orders.
            let phase = cos.atan2(sin);
            let phase = if minus { -phase } else { phase };
            add(name, amplitude, Some(of_amplitude));
            add("phase_rad", phase.rem_euclid(TAU), Some(of_phase));
            match term.effect.carrier {
                Carrier::Order(order) if minus && order <= 2.0 => {}
                Carrier::Order(order) => add("order", order, of_knob(0)),
                Carrier::Tone(f_hz) => add("f_hz", f_hz, of_knob(0)),
                Carrier::Chirp(f_hz, rate) => {
                    add("f_hz", f_hz, of_knob(0));
                    add("rate_hz_s", rate, of_knob(1));
                }
                _ => {}
            }
            return all;
        }
        let size = term.sizes[0];
        let of_size = Some(self.error(&[(self.column(at, 0), 1.0)]));
        match (term.effect.site, term.effect.carrier) {
            (Site::Disc(on), Carrier::Steady) if on.rises.is_some() => match on.channel {
                None => add("width_rad", size, of_size),
                Some(_) => add(&format!("width_{}_rad", channel(on)), size, of_size),
            },
            (Site::Disc(on), Carrier::Steady) => {
                let hall = self.model.terms.iter().any(|t| {
                    matches!(
                        t.effect.site,
                        Site::Disc(On {
                            channel: Some(2),
                            ..
                        })
                    )
                });
                let name = if hall {
                    format!("shift_{}_rad", channel(on))
                } else {
                    "quadrature_rad".to_owned()
                };
                add(&name, size, of_size);
            }
            (Site::Stamp(on), Carrier::Steady) => match (on.channel, on.rises) {
                (None, _) => add("rise_less_fall_s", size, of_size),
                (Some(_), Some(true)) => {
                    add(&format!("{}.rise_less_fall_s", channel(on)), size, of_size)
                }
                (Some(_), Some(false)) => {
                    add(&format!("{}.rise_less_fall_s", channel(on)), -size, of_size)
                }
                (Some(_), None) => add(&format!("{}_less_a_s", channel(on)), size, of_size),
            },
            (Site::Disc(_), Carrier::Bump(angle, width)) => {
                add("error_rad", size, of_size);
                add("angle_rad", angle.rem_euclid(TAU), of_knob(0));
                add("width_rad", width, of_knob(1));
            }
            (Site::Disc(_), Carrier::Direction) => add("angle_rad", size, of_size),
            (Site::Level(_), Carrier::Settling(from_s, tau_s)) => {
                add("angle_rad", size, of_size);
                add("tau_s", tau_s, of_knob(1));
                add("from_s", from_s, of_knob(0));
            }
            (Site::Drive, Carrier::Time) => add("fraction_per_s", size, of_size),
            (Site::Drive, Carrier::Settling(_, tau_s)) => {
                add("fraction", size, of_size);
                add("tau_s", tau_s, of_knob(1));
            }
            (Site::Torque, Carrier::Window(from_s, until_s)) => {
                add("torque_n_m", size, of_size);
                if knob(0).is_some() {
                    add("from_s", from_s, of_knob(0));
                }
                if knob(1).is_some() {
                    add("until_s", until_s, of_knob(1));
                }
            }
            (Site::Torque, Carrier::Power(power)) => {
                let name = match power {
                    0.0 => "coulomb_n_m",
                    1.0 => "viscous_n_m_s",
                    _ => "drag_n_m_s2",
                };
                add(name, size, of_size);
            }
            (Site::Torque, Carrier::Stribeck(speed)) => {
                add("stribeck_n_m", size, of_size);
                add("stribeck_rad_s", speed, of_knob(0));
            }
            _ => add("size", size, of_size),
        }
        all
    }
}

/// A unit of torque where the twin declares no inertia: then only torque over inertia is known.
fn per_inertia(unit: &str, known_inertia: bool) -> String {
    if known_inertia || !unit.starts_with("N m") {
        unit.to_owned()
    } else {
        format!("{unit}/(kg m^2)")
    }
}

/// Numbers as a finding has them.
#[must_use]
pub fn parameters(
    mechanism: Mechanism,
    numbers: &[Number],
    known_inertia: bool,
) -> BTreeMap<String, Parameter> {
    let each = numbers.iter().map(|number| {
        let by = number.error.map(|error| NINETY_FIVE * error);
        let parameter = Parameter {
            value: number.value,
            unit: per_inertia(mechanism.card().unit(&number.name), known_inertia),
            ci95: by.map(|by| [number.value - by, number.value + by]),
        };
        (number.name.clone(), parameter)
    });
    each.collect()
}

/// Where a group of effects shows.
#[must_use]
pub fn place(board: &Board, effects: &[Effect]) -> Place {
    let mut place = Place::default();
    let classes = board
        .benches
        .first()
        .map_or(1, |bench| bench.record.classes);
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
                let name = if classes > 2 {
                    format!("{} {flank}", ["A", "B", "C"][usize::from(change.channel)])
                } else {
                    flank.to_owned()
                };
                if !place.edge_classes.contains(&name) {
                    place.edge_classes.push(name);
                }
            }
        }
        if let Some(channel) = on.channel {
            let name = ["A", "B", "C"][usize::from(channel.min(2))].to_owned();
            if !place.channels.contains(&name) {
                place.channels.push(name);
            }
        }
    }
    place
}

/// A group of effects in a sentence.
#[must_use]
pub fn text(effects: &[Effect]) -> String {
    let Some(first) = effects.first() else {
        return String::new();
    };
    let on = |on: On| {
        let channel = on.channel.map_or_else(
            || "all channels".to_owned(),
            |channel| format!("channel {}", ["A", "B", "C"][usize::from(channel.min(2))]),
        );
        match on.rises {
            None => channel,
            Some(true) => format!("rises of {channel}"),
            Some(false) => format!("falls of {channel}"),
        }
    };
    let site = match first.site {
        Site::Torque => "a torque".to_owned(),
        Site::Drive => "a change of the speed that the drive asks for".to_owned(),
        Site::Disc(which) => format!("an angle of the edges, {}", on(which)),
        Site::Level(which) => format!("a shift of the comparator's level, {}", on(which)),
        Site::Stamp(which) => format!("a delay of the stamps, {}", on(which)),
        Site::Declared(_) => "another value of what the twin declares".to_owned(),
    };
    let carrier = match first.carrier {
        Carrier::Steady => "throughout".to_owned(),
        Carrier::Order(order) => format!("at order {order:.4}"),
        Carrier::Tone(f_hz) => format!("at {f_hz:.4} Hz"),
        Carrier::Chirp(f_hz, rate) => format!("at {f_hz:.4} Hz and {rate:.4} Hz more each second"),
        Carrier::Bump(angle, width) => format!(
            "at {:.2} degrees of the disc, {:.2} wide",
            angle.rem_euclid(TAU).to_degrees(),
            width.to_degrees()
        ),
        Carrier::Window(from, until) if until.is_finite() && from.is_finite() => {
            format!("from {from:.4} to {until:.4} s")
        }
        Carrier::Window(from, _) if from.is_finite() => format!("from {from:.4} s on"),
        Carrier::Window(_, until) => format!("until {until:.4} s"),
        Carrier::Settling(from, tau) => format!(
            "that settles from {:.3} s on with {tau:.3} s",
            from.max(0.0)
        ),
        Carrier::Time => "that grows evenly with time".to_owned(),
        Carrier::Direction => "that turns with the direction".to_owned(),
        Carrier::Power(power) => {
            format!("against the motion, as the speed to the power {power:.2}")
        }
        Carrier::Stribeck(speed) => format!("against the motion, that falls over {speed:.2} rad/s"),
    };
    let only = first.only.map_or_else(String::new, |only| {
        format!(", in recording {} alone", u16::from(only) + 1)
    });
    format!("{site}, {carrier}{only}")
}
