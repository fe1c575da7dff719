//! Ranges and conflicts of effects.

use std::f64::consts::PI;

use super::{ANGLE_ADVICE, Checker, TIME_MAX, TORQUE_MAX};
use crate::twin::{DeclaredEffect, EffectSite, Follows, Twin};

/// Largest rate, power or depth of an effect's growth.
const GROWTH_MAX: f64 = 1e6;
/// Widest bump of a torque, rad: its ends meet half a turn away, at less than 1e-8 of its peak.
const PUSH_WIDTH_MAX: f64 = 0.5;
/// Largest power of the speed.
const POWER_MAX: f64 = 8.0;

/// Keys that what an effect follows needs, and those that it may have.
const fn keys(follows: Follows) -> (&'static [&'static str], &'static [&'static str]) {
    match follows {
        Follows::Nothing | Follows::Time | Follows::Direction => (&[], &[]),
        Follows::Order => (&["order"], &["phase_rad"]),
        Follows::Frequency => (&["f_hz"], &["rate_hz_s", "phase_rad"]),
        Follows::Place => (&["angle_rad", "width_rad"], &[]),
        Follows::Window => (&[], &["from_s", "until_s"]),
        Follows::Settling => (&["tau_s"], &["from_s"]),
        Follows::Speed => (&["power"], &[]),
        Follows::Stribeck => (&["stribeck_rad_s"], &[]),
    }
}

/// Keys of all growths; each has its own.
const GROWTHS: [&[&str]; 3] = [
    &["growth_per_s"],
    &["speed_power"],
    &["modulation_hz", "modulation_depth", "modulation_phase_rad"],
];

impl Twin {
    pub(super) fn check_effects(&self, c: &mut Checker<'_>) {
        for (i, one) in self.effect.iter().enumerate() {
            let key = |name: &str| format!("effect[{i}].{name}");
            check_keys(c, one, &key);
            check_size(c, one, &key);
            check_ranges(c, one, &key);
            c.channel(&key("channel"), one.channel, &self.encoder);
            let has_edges = matches!(
                one.site,
                EffectSite::Disc | EffectSite::Level | EffectSite::Stamp
            );
            c.require(
                one.channel.is_none() || has_edges,
                &key("channel"),
                one.channel,
                "only where site is \"disc\", \"level\" or \"stamp\"",
                "take it out",
            );
            c.require(
                one.edge.is_none() || has_edges && one.site != EffectSite::Level,
                &key("edge"),
                one.edge,
                "only where site is \"disc\" or \"stamp\"",
                "take it out",
            );
        }
    }
}

/// That an effect has what it follows needs, and nothing else.
fn check_keys(c: &mut Checker<'_>, one: &DeclaredEffect, key: &dyn Fn(&str) -> String) {
    let (needed, allowed) = keys(one.follows);
    let growth: Vec<&str> = GROWTHS
        .iter()
        .filter(|keys| {
            let given = one.numbers();
            let has = |key: &str| given.iter().any(|(k, v)| *k == key && v.is_some());
            keys.iter().any(|key| has(key))
        })
        .map(|keys| keys[0])
        .collect();
    c.require(
        growth.len() <= 1,
        &key(growth.last().copied().unwrap_or("follows")),
        growth.join(" and "),
        "one way to grow",
        "keep growth_per_s, speed_power or the keys of the modulation, and take out the others",
    );
    for (name, value) in one.numbers() {
        let grows = GROWTHS.iter().any(|keys| keys.contains(&name));
        let may = grows || needed.contains(&name) || allowed.contains(&name);
        c.require(
            may || value.is_none(),
            &key(name),
            value.unwrap_or(0.0),
            &format!("no such key where follows is {:?}", name_of(one.follows)),
            "take it out, or change what the effect follows",
        );
        c.require(
            !needed.contains(&name) || value.is_some(),
            &key(name),
            format_args!("missing"),
            &format!("a number where follows is {:?}", name_of(one.follows)),
            "add the key",
        );
    }
    let modulated = one.modulation_depth.is_some() || one.modulation_phase_rad.is_some();
    c.require(
        !modulated || one.modulation_hz.is_some(),
        &key("modulation_hz"),
        format_args!("missing"),
        "a frequency where there is a modulation",
        "add the key",
    );
}

/// That it has the size of its site, and no other.
fn check_size(c: &mut Checker<'_>, one: &DeclaredEffect, key: &dyn Fn(&str) -> String) {
    let own = one.site.size_key();
    for (name, value) in [
        ("torque_n_m", one.torque_n_m),
        ("fraction", one.fraction),
        ("shift_rad", one.shift_rad),
        ("delay_s", one.delay_s),
    ] {
        c.require(
            (name == own) == value.is_some(),
            &key(name),
            value.map_or_else(|| "missing".to_owned(), |value| format!("{value:?}")),
            &format!("one size, {own}, at this site"),
            "give the size in the unit of its site",
        );
    }
    let (most, advice) = match one.site {
        EffectSite::Torque => (TORQUE_MAX, "give a torque"),
        EffectSite::Drive => (1.0, "give a share of the drive's speed"),
        EffectSite::Disc | EffectSite::Level => (PI, ANGLE_ADVICE),
        EffectSite::Stamp => (1.0, "give a delay in seconds"),
    };
    let waves = matches!(one.follows, Follows::Order | Follows::Frequency);
    let least = if waves { 0.0 } else { -most };
    let advice = if waves && one.size() < 0.0 {
        "turn the sign by the phase"
    } else {
        advice
    };
    c.between(&key(own), one.size(), least, most, advice);
}

fn check_ranges(c: &mut Checker<'_>, one: &DeclaredEffect, key: &dyn Fn(&str) -> String) {
    let pushes = matches!(one.site, EffectSite::Torque | EffectSite::Drive);
    for (name, value) in one.numbers() {
        let Some(value) = value else {
            continue;
        };
        let key = key(name);
        match name {
            "order" => c.positive(&key, value, 1e5, "give cycles a turn"),
            "f_hz" | "modulation_hz" => c.positive(&key, value, 1e6, "give a frequency"),
            "rate_hz_s" => c.between(&key, value, -1e6, 1e6, "give Hz a second"),
            "angle_rad" => c.between(&key, value, -1e3, 1e3, ANGLE_ADVICE),
            "width_rad" => {
                let most = if pushes { PUSH_WIDTH_MAX } else { PI };
                c.positive(&key, value, most, "give the bump's sigma");
            }
            "tau_s" => c.positive(&key, value, TIME_MAX, "give its time constant"),
            "from_s" | "until_s" => c.between(&key, value, -TIME_MAX, TIME_MAX, "give a time"),
            "power" => c.between(&key, value, 0.0, POWER_MAX, "give a power of the speed"),
            "speed_power" => c.between(
                &key,
                value,
                // What moves the shaft has to stay finite where it stands.
                if pushes { 0.0 } else { -POWER_MAX },
                POWER_MAX,
                "give a power of the speed",
            ),
            "stribeck_rad_s" => c.positive(&key, value, 1e6, "give a speed"),
            "growth_per_s" | "modulation_depth" => {
                c.between(&key, value, -GROWTH_MAX, GROWTH_MAX, "give a smaller one");
            }
            _ => c.phase(&key, value),
        }
    }
    if let (Some(from), Some(until)) = (one.from_s, one.until_s) {
        c.require(
            until > from,
            &key("until_s"),
            until,
            "after from_s",
            "leave it out for an effect that stays",
        );
    }
}

fn name_of(follows: Follows) -> String {
    format!("{follows:?}").to_lowercase()
}
