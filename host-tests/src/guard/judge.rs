//! Answers held against what was changed, or put on top.

use std::f64::consts::PI;

use quadcal_host::diagnose::diagnosis::{Diagnosis, Finding};
use quadcal_host::mechanism::Mechanism;
use toml::Table;

use super::change::{Change, How};
use super::tree::{self, Step};

/// Confidence above which a name counts as said for sure.
pub const SURE: f64 = 0.99;
/// 95 % interval of a sum of two, in place of none: what is exact has to be right to this share.
const EXACT: f64 = 1e-6;
/// Sizes of what has a phase.
pub const AMPLITUDES: [&str; 4] = ["torque_n_m", "runout_rad", "angle_rad", "amplitude_rad"];

/// Whether two names are of the same physics: no recording tells them apart.
#[must_use]
pub fn same(one: Mechanism, other: Mechanism) -> bool {
    use Mechanism::{Backlash, Bearing, GearMesh, Hysteresis};
    one == other
        || matches!(
            (one, other),
            (GearMesh, Bearing)
                | (Bearing, GearMesh)
                | (Hysteresis, Backlash)
                | (Backlash, Hysteresis)
        )
}

/// Whether a name is that of a part of a mechanism: a pattern of lines has class means and low orders of its own.
fn part(mechanism: Mechanism, name: Mechanism) -> bool {
    use Mechanism::{DiscTilt, Eccentricity, LineError, QuadratureError, WidthError};
    let parts = [WidthError, QuadratureError, Eccentricity, DiscTilt];
    mechanism == LineError && parts.contains(&name)
}

/// Names said for sure that are of another mechanism, and do not leave this one open.
#[must_use]
pub fn false_names(said: &Diagnosis, mechanism: Mechanism) -> Vec<Mechanism> {
    let findings = said.findings.iter().filter(|found| {
        found.mechanism != Mechanism::Unknown
            && found.confidence > SURE
            && !same(found.mechanism, mechanism)
            && !part(mechanism, found.mechanism)
            && !found.look_alikes.contains(&mechanism)
    });
    findings.map(|found| found.mechanism).collect()
}

/// Whether a mechanism is named, or left open among look-alikes.
#[must_use]
pub fn named(said: &Diagnosis, mechanism: Mechanism) -> bool {
    let mut findings = said.findings.iter();
    findings.any(|found| same(found.mechanism, mechanism) || found.look_alikes.contains(&mechanism))
}

/// Whether an answer says what was changed: names what was taken out; of a number, gives the true one, as a correction or anew.
#[must_use]
pub fn says(said: &Diagnosis, whole: &Table, change: &Change) -> bool {
    if change.how == How::Removed {
        return named(said, change.mechanism);
    }
    let mut findings = said.findings.iter();
    findings.any(|found| same(found.mechanism, change.mechanism) && holds(found, whole, change))
}

/// Whether a finding's interval holds the true number. One that the finding has no word for counts by the name.
fn holds(found: &Finding, whole: &Table, change: &Change) -> bool {
    let Some((Step::Key(key), section)) = change.path.split_last() else {
        return false;
    };
    let number = |twin: &Table| tree::get(twin, &change.path).and_then(tree::as_number);
    let (Some(truth), Some(declared)) = (number(whole), number(&change.twin)) else {
        return false;
    };
    if let Some(by_vector) = holds_vector(found, whole, change, key, section) {
        return by_vector || interval_holds(found, key, truth);
    }
    match found.parameters.get(key) {
        Some(_) => {
            interval_holds(found, key, truth) || interval_holds(found, key, truth - declared)
        }
        None => true,
    }
}

fn interval_holds(found: &Finding, key: &str, value: f64) -> bool {
    let Some(parameter) = found.parameters.get(key) else {
        return false;
    };
    let [low, high] = parameter.ci95.unwrap_or_else(|| {
        let slack = EXACT * parameter.value.abs();
        [parameter.value - slack, parameter.value + slack]
    });
    (low..=high).contains(&value)
}

/// A wave that is found beside a declared one: their sum has to be the true wave. None where the key is not one of a wave's.
fn holds_vector(
    found: &Finding,
    whole: &Table,
    change: &Change,
    key: &str,
    section: &[Step],
) -> Option<bool> {
    if key != "phase_rad" && !AMPLITUDES.contains(&key) {
        return None;
    }
    let amplitude = found
        .parameters
        .keys()
        .find(|key| AMPLITUDES.contains(&key.as_str()))?;
    let (size, phase) = (
        found.parameters.get(amplitude)?,
        found.parameters.get("phase_rad")?,
    );
    let half = |ci95: Option<[f64; 2]>| ci95.map_or(0.0, |[low, high]| 0.5 * (high - low));
    let wave = |twin: &Table| -> Option<[f64; 2]> {
        let of = |key: &str| {
            let mut path = section.to_vec();
            path.push(Step::Key(key.to_owned()));
            tree::get(twin, &path).and_then(tree::as_number)
        };
        Some(vector(of(amplitude)?, of("phase_rad").unwrap_or(0.0)))
    };
    let (truth, declared) = (wave(whole)?, wave(&change.twin)?);
    let found = vector(size.value, phase.value);
    let allowed = half(size.ci95).hypot(size.value * half(phase.ci95).min(PI));
    let off = [0, 1].map(|at| declared[at] + found[at] - truth[at]);
    Some(off[0].hypot(off[1]) <= allowed.max(EXACT * size.value.abs()))
}

fn vector(size: f64, phase_rad: f64) -> [f64; 2] {
    [size * phase_rad.cos(), size * phase_rad.sin()]
}

/// What was said, in a line: verdict, names with their confidence.
#[must_use]
pub fn line(said: &Diagnosis) -> String {
    let findings = said
        .findings
        .iter()
        .map(|found| format!("{} {:.1} %", found.mechanism.id(), 100.0 * found.confidence));
    let names: Vec<String> = findings.collect();
    let verdict = crate::trial::score::verdict_name(said.verdict);
    if names.is_empty() {
        verdict.to_owned()
    } else {
        format!("{verdict}: {}", names.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use quadcal_host::diagnose::diagnosis::{Evidence, Parameter, Place};

    use super::*;

    fn found(parameters: &[(&str, f64, f64)]) -> Finding {
        let parameters = parameters.iter().map(|&(name, value, half)| {
            let parameter = Parameter {
                value,
                unit: "1".to_owned(),
                ci95: Some([value - half, value + half]),
            };
            (name.to_owned(), parameter)
        });
        Finding {
            mechanism: Mechanism::GearMesh,
            text: String::new(),
            confidence: 1.0,
            parameters: parameters.collect::<BTreeMap<_, _>>(),
            place: Place::default(),
            evidence: Evidence {
                delta_bic: 30.0,
                p_value: 1e-6,
                held_out_rms_ratio: None,
                lines_beside: None,
                runner_up: None,
            },
            look_alikes: Vec::new(),
            next_recording: None,
        }
    }

    fn change(key: &str, value: f64) -> (Table, Change) {
        let whole = tree::parse("[[gear_mesh]]\norder = 7.3\ntorque_n_m = 2e-3\nphase_rad = 0.5\n")
            .unwrap();
        let path = vec![
            Step::Key("gear_mesh".to_owned()),
            Step::At(0),
            Step::Key(key.to_owned()),
        ];
        let mut twin = whole.clone();
        tree::replace(&mut twin, &path, value.into());
        let change = Change {
            path,
            how: How::Doubled,
            mechanism: Mechanism::GearMesh,
            twin,
        };
        (whole, change)
    }

    #[test]
    fn a_wave_said_as_a_correction_or_anew_is_right_and_a_wrong_one_is_not() {
        let (whole, change) = change("torque_n_m", 4e-3);
        let says = |size, phase| {
            let found = found(&[("torque_n_m", size, 1e-4), ("phase_rad", phase, 0.05)]);
            holds(&found, &whole, &change)
        };
        assert!(says(2e-3, 0.5), "anew");
        assert!(says(2.05e-3, 0.5 + PI), "2e-3 less than declared");
        assert!(!says(1e-3, 0.5 + PI) && !says(4e-3, 0.5));
    }

    #[test]
    fn an_order_counts_by_its_interval_and_a_word_that_is_missing_by_the_name() {
        let (whole, change) = change("order", 14.6);
        let says = |order| holds(&found(&[("order", order, 0.01)]), &whole, &change);
        assert!(says(7.305) && !says(14.6));
        assert!(holds(&found(&[]), &whole, &change));
    }
}
