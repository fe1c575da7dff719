//! The effects of a finding in plain words, with their sizes.

use std::f64::consts::TAU;

use crate::diagnose::diagnosis::{Parameter, Sized};
use crate::diagnose::effect::{Carrier, Effect, Growth, Site};
use crate::effect::words::{growth, number, site, words};
use crate::reports::diagnose::words::with_interval;

/// Effects of one finding that are written out; more are counted.
const WRITTEN: usize = 4;

/// All effects of a finding in a line; empty where there are none.
#[must_use]
pub fn cell(effects: &[Sized]) -> String {
    if let Some(harmonics) = harmonics(effects) {
        return harmonics;
    }
    let each = effects.iter().take(WRITTEN);
    let mut all: Vec<String> = each.map(|sized| words(&sized.effect)).collect();
    if let more @ 1.. = effects.len().saturating_sub(WRITTEN) {
        all.push(format!("{more} more"));
    }
    all.join("; ")
}

/// An order with its harmonics at one site: `torque at orders 3, 6, 9, constant`; none where effects are anything else.
fn harmonics(effects: &[Sized]) -> Option<String> {
    let [first, _, ..] = effects else { return None };
    let alike = |sized: &Sized| {
        Effect {
            carrier: first.effect.carrier,
            ..sized.effect
        } == first.effect
    };
    let orders = effects.iter().map(|sized| match sized.effect.carrier {
        Carrier::Order(order) if alike(sized) => Some(number(order, "")),
        _ => None,
    });
    let orders: Option<Vec<String>> = orders.collect();
    let orders = orders?.join(", ");
    let (site, growth) = (site(&first.effect.site), growth(&first.effect));
    Some(format!("{site} at orders {orders}{growth}"))
}

/// The size of an effect: its amplitude where it has a phase.
#[must_use]
pub fn amplitude(sized: &Sized) -> f64 {
    match sized.sizes[..] {
        [size] => size,
        _ => sized
            .sizes
            .iter()
            .map(|size| size * size)
            .sum::<f64>()
            .sqrt(),
    }
}

/// The unit of what enters at a site; of a torque over the inertia where no twin declares one.
#[must_use]
pub const fn site_unit(site: &Site, inertia_known: bool) -> &'static str {
    match site {
        Site::Torque if inertia_known => "N m",
        Site::Torque => "N m/(kg m^2)",
        Site::Drive | Site::Declared(_) => "1",
        Site::Disc(_) | Site::Level(_) => "rad",
        Site::Stamp(_) => "s",
    }
}

/// The unit of an effect's size: that of its site, over what its carrier and growth bring.
#[must_use]
pub fn unit(effect: &Effect, inertia_known: bool) -> String {
    let site = site_unit(&effect.site, inertia_known);
    let mut power = 0.0;
    if let Carrier::Power(by) = effect.carrier {
        power += by;
    }
    if let Growth::Speed(by) = effect.growth {
        power += by;
    }
    let time = match effect.carrier {
        Carrier::Time if site == "1" => return speeds("1/s".to_owned(), power),
        Carrier::Time => "/s",
        _ => "",
    };
    speeds(format!("{site}{time}"), power)
}

fn speeds(unit: String, power: f64) -> String {
    match power {
        0.0 => unit,
        1.0 => format!("{unit} s/rad"),
        power => format!("{unit} (s/rad)^{}", number(power, "")),
    }
}

/// Names and units of the numbers that carrier and growth of an effect have, in their order.
fn knobs(effect: &Effect) -> Vec<(&'static str, &'static str)> {
    let mut all: Vec<(&str, &str)> = match effect.carrier {
        Carrier::Order(_) => vec![("order", "1")],
        Carrier::Tone(_) => vec![("frequency", "Hz")],
        Carrier::Chirp(..) => vec![("frequency at time 0", "Hz"), ("sweep", "Hz/s")],
        Carrier::Bump(..) => vec![("place", "rad"), ("width (sigma)", "rad")],
        Carrier::Window(..) => vec![("from", "s"), ("until", "s")],
        Carrier::Settling(..) => vec![("from", "s"), ("time constant", "s")],
        Carrier::Stribeck(_) => vec![("Stribeck speed", "rad/s")],
        Carrier::Steady | Carrier::Time | Carrier::Direction | Carrier::Power(_) => Vec::new(),
    };
    match effect.growth {
        Growth::Constant | Growth::Own | Growth::Past(_) => {}
        Growth::Even(_) => all.push(("growth", "1/s")),
        Growth::Speed(_) => all.push(("power of the speed", "1")),
        Growth::Modulated(..) => {
            all.extend([
                ("modulation", "Hz"),
                ("its depth", "1"),
                ("its phase", "rad"),
            ]);
        }
    }
    all
}

/// Size of each effect with the numbers that were fitted, for findings that have no numbers of their own.
#[must_use]
pub fn sizes(effects: &[Sized], inertia_known: bool) -> Vec<String> {
    let size = |sized: &Sized| {
        let unit = unit(&sized.effect, inertia_known);
        let what = match sized.effect.sizes() {
            2 => "amplitude",
            _ => "size",
        };
        let mut within = sized.ci95.iter().copied();
        let ci95 = within.next().flatten();
        let size = amplitude(sized);
        // A prefix before a unit that is divided or raised would be read as part of it.
        let sized_in = |unit: &str, size: f64, ci95: Option<[f64; 2]>| match (
            unit.contains('/') || unit.contains('^'),
            ci95,
        ) {
            (true, None) => format!("{} {unit}", number(size, "")),
            (true, ci95) => format!("{} {unit}", with_interval(&parameter(size, "1", ci95))),
            (false, ci95) => with_interval(&parameter(size, unit, ci95)),
        };
        let number = match sized.at_speed {
            Some(there) => {
                let constant = Effect {
                    growth: Growth::Constant,
                    ..sized.effect
                };
                let unit = self::unit(&constant, inertia_known);
                let r_min = number(there.rad_s * 60.0 / TAU, "");
                let there = sized_in(&unit, there.size, Some(there.ci95));
                format!("{there} at {r_min} r/min")
            }
            None => sized_in(&unit, size, ci95),
        };
        let knobs = sized.effect.knobs().into_iter();
        let knobs = knobs.zip(self::knobs(&sized.effect)).zip(within);
        let knobs = knobs.filter_map(|((knob, (name, unit)), ci95)| {
            // A place is one of the first turn.
            let turns = match name {
                "place" => TAU * (knob / TAU).floor(),
                _ => 0.0,
            };
            // What was held has no interval, and stands where the effect is named.
            let ci95 = ci95.filter(|[low, high]| low < high)?;
            let ci95 = ci95.map(|end| end - turns);
            let number = with_interval(&parameter(knob - turns, unit, Some(ci95)));
            Some(format!(", {name} {number}"))
        });
        format!("{what} {number}{}", knobs.collect::<String>())
    };
    effects.iter().take(WRITTEN).map(size).collect()
}

fn parameter(value: f64, unit: &str, ci95: Option<[f64; 2]>) -> Parameter {
    Parameter {
        unit: unit.to_owned(),
        ci95,
        ..Parameter::exact(value)
    }
}

#[cfg(test)]
mod tests;
