//! The effects of a finding in plain words, with their sizes.

use crate::diagnose::diagnosis::Sized;
use crate::diagnose::effect::{Carrier, Effect, Growth, Site};
use crate::effect::words::{growth, number, site, words};
use crate::reports::diagnose::words::value;

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

/// Site, cell and size of each effect, for findings that have no numbers of their own.
#[must_use]
pub fn sizes(effects: &[Sized], inertia_known: bool) -> Vec<String> {
    let size = |sized: &Sized| {
        let unit = unit(&sized.effect, inertia_known);
        let what = match sized.effect.sizes() {
            2 => "amplitude",
            _ => "size",
        };
        // A prefix before a unit that is divided or raised would be read as part of it.
        let number = match unit.contains('/') || unit.contains('^') {
            true => format!("{} {unit}", number(amplitude(sized), "")),
            false => value(amplitude(sized), &unit),
        };
        format!("{what} {number}")
    };
    effects.iter().take(WRITTEN).map(size).collect()
}

#[cfg(test)]
mod tests;
