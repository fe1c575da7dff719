//! Changes of a twin: each section of physics taken out, each of its numbers halved, doubled and turned in sign.

use std::f64::consts::PI;

use quadcal_host::mechanism::Mechanism;
use toml::{Table, Value};

use super::judge::AMPLITUDES;
use super::tree::{self, Step};

/// Sections and keys that declare a mechanism. Those of shaft, drive and noise that declare none are not changed.
const PHYSICS: [(&str, Mechanism); 30] = [
    ("errors.position", Mechanism::LineError),
    ("errors.width_a_rad", Mechanism::WidthError),
    ("errors.width_b_rad", Mechanism::WidthError),
    ("errors.width_c_rad", Mechanism::WidthError),
    ("errors.quadrature_rad", Mechanism::QuadratureError),
    ("errors.eccentricity", Mechanism::Eccentricity),
    ("errors.tilt", Mechanism::DiscTilt),
    ("local_defect", Mechanism::LocalDefect),
    ("shaft.viscous_n_m_s", Mechanism::Friction),
    ("shaft.coulomb_n_m", Mechanism::Friction),
    ("shaft.drag_n_m_s2", Mechanism::Friction),
    ("shaft.stribeck_n_m", Mechanism::Friction),
    ("drive.speed_loop.bandwidth_hz", Mechanism::ClosedLoop),
    ("drive.speed_loop.kp_n_m_s", Mechanism::ClosedLoop),
    ("drive.speed_loop.ki_n_m", Mechanism::ClosedLoop),
    ("ripple", Mechanism::TorqueRipple),
    ("gear_mesh", Mechanism::GearMesh),
    ("bearing", Mechanism::Bearing),
    ("torque_tone", Mechanism::TorqueTone),
    ("load_step", Mechanism::LoadStep),
    ("speed_drift", Mechanism::SpeedDrift),
    ("stick_slip", Mechanism::StickSlip),
    ("torsional_resonance", Mechanism::TorsionalResonance),
    ("edge_delay", Mechanism::EdgeDelay),
    ("channel_skew", Mechanism::ChannelSkew),
    ("threshold_ripple", Mechanism::ThresholdRipple),
    ("threshold_drift", Mechanism::ThresholdDrift),
    ("hysteresis", Mechanism::Hysteresis),
    ("backlash", Mechanism::Backlash),
    ("index_slip", Mechanism::IndexSlip),
];

/// Keys that declare a mechanism by themselves, beside a section of other things.
const MORE: [(&str, Mechanism); 2] = [
    ("capture_latency", Mechanism::CaptureLatency),
    ("timer.jitter_s", Mechanism::TimestampJitter),
];

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// Taken out.
    Removed,
    /// Half of it.
    Halved,
    /// Twice as much.
    Doubled,
    /// Less it.
    Turned,
}

impl How {
    /// In a word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Removed => "removed",
            Self::Halved => "halved",
            Self::Doubled => "doubled",
            Self::Turned => "turned",
        }
    }

    /// Factor on a number.
    const fn factor(self) -> f64 {
        match self {
            Self::Removed => 0.0,
            Self::Halved => 0.5,
            Self::Doubled => 2.0,
            Self::Turned => -1.0,
        }
    }
}

/// One change of a twin.
#[derive(Clone, Debug)]
pub struct Change {
    /// Where.
    pub path: Vec<Step>,
    /// What is done there.
    pub how: How,
    /// The mechanism that it is of.
    pub mechanism: Mechanism,
    /// The changed twin.
    pub twin: Table,
}

/// All changes of a twin that leave it a twin.
#[must_use]
pub fn changes(whole: &Table) -> Vec<Change> {
    let mut all = Vec::new();
    for (dotted, mechanism) in PHYSICS.into_iter().chain(MORE) {
        let path = tree::path(dotted);
        match tree::get(whole, &path) {
            Some(Value::Array(list)) => {
                for at in 0..list.len() {
                    let mut path = path.clone();
                    path.push(Step::At(at));
                    of_section(whole, &path, mechanism, &mut all);
                }
            }
            Some(_) => of_section(whole, &path, mechanism, &mut all),
            None => {}
        }
    }
    all.retain(|change| tree::twin(&change.twin).is_ok());
    all
}

fn of_section(whole: &Table, path: &[Step], mechanism: Mechanism, all: &mut Vec<Change>) {
    let mut add = |path: &[Step], how, twin| {
        all.push(Change {
            path: path.to_vec(),
            how,
            mechanism,
            twin,
        });
    };
    let mut without = whole.clone();
    tree::remove(&mut without, path);
    add(path, How::Removed, without);
    for number in numbers(whole, path) {
        let Some(value) = tree::get(whole, &number) else {
            continue;
        };
        for how in [How::Halved, How::Doubled, How::Turned] {
            let Some(value) = scaled(value, how.factor()) else {
                continue;
            };
            let mut twin = whole.clone();
            match wave(whole, &number) {
                Some(phase) if how == How::Turned => turn(&mut twin, &phase),
                _ => tree::replace(&mut twin, &number, value),
            }
            add(&number, how, twin);
        }
    }
}

/// Path of the phase of the wave whose amplitude is at a path; none where there is no such wave. A size is no less than 0 in a twin:
/// a wave is turned by its phase.
fn wave(whole: &Table, number: &[Step]) -> Option<Vec<Step>> {
    let (Step::Key(key), section) = number.split_last()? else {
        return None;
    };
    let swings = tree::get(whole, section).is_some_and(|section| {
        ["order", "f_hz", "phase_rad"]
            .iter()
            .any(|key| section.get(key).is_some())
    });
    let mut phase = section.to_vec();
    phase.push(Step::Key("phase_rad".to_owned()));
    (swings && AMPLITUDES.contains(&key.as_str())).then_some(phase)
}

/// Turns a phase by half a cycle.
fn turn(twin: &mut Table, phase: &[Step]) {
    let now = tree::get(twin, phase).and_then(tree::as_number);
    tree::insert(twin, phase, (now.unwrap_or(0.0) + PI).into());
}

/// Paths of all numbers at or below a path, other than seeds.
fn numbers(whole: &Table, path: &[Step]) -> Vec<Vec<Step>> {
    match tree::get(whole, path) {
        Some(Value::Table(section)) => {
            let keys = section.keys().filter(|key| *key != "seed");
            let below = keys.map(|key| {
                let mut path = path.to_vec();
                path.push(Step::Key(key.clone()));
                path
            });
            below.flat_map(|path| numbers(whole, &path)).collect()
        }
        Some(Value::Float(_) | Value::Integer(_)) => vec![path.to_vec()],
        _ => Vec::new(),
    }
}

/// A number times a factor, of the kind that it was; none where that is no change, or no such number. A whole number that
/// measures may become a broken one; a count stays whole.
fn scaled(value: &Value, factor: f64) -> Option<Value> {
    let number = tree::as_number(value)?;
    let scaled = number * factor;
    if number == 0.0 {
        return None;
    }
    Some(match value {
        Value::Integer(_) if scaled.fract() == 0.0 => Value::Integer(scaled as i64),
        _ => Value::Float(scaled),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_physics_is_changed_and_what_is_no_twin_is_left_out() {
        let whole = tree::parse(
            "duration = { turns = 10 }\n[encoder.wheel]\nteeth = 60\n[shaft]\ninertia_kg_m2 = 1e-4\n\
             [drive.constant]\nr_min = 300\n[timer]\nclock_hz = 1000000\n\
             [[gear_mesh]]\norder = 7.3\ntorque_n_m = 1e-3\n[errors]\nseed = 3\nwidth_a_rad = 1e-3\n",
        )
        .unwrap();
        let changes = changes(&whole);
        let named: Vec<String> = changes
            .iter()
            .map(|change| format!("{} {}", tree::shown(&change.path), change.how.word()))
            .collect();
        assert!(
            named.contains(&"gear_mesh[0] removed".to_owned()),
            "{named:?}"
        );
        let turned = named
            .iter()
            .position(|n| n == "gear_mesh[0].torque_n_m turned");
        let text = changes[turned.unwrap()].twin.to_string();
        assert!(text.contains("phase_rad = 3.14159"), "{text}");
        assert!(named.contains(&"errors.width_a_rad halved".to_owned()));
        // A negative order is no order; inertia and speed declare no mechanism.
        assert!(!named.contains(&"gear_mesh[0].order turned".to_owned()));
        assert!(
            !named
                .iter()
                .any(|name| name.contains("inertia") || name.contains("r_min"))
        );
        let torque = |at: usize| tree::get(&changes[at].twin, &changes[at].path);
        let doubled = named
            .iter()
            .position(|n| n == "gear_mesh[0].torque_n_m doubled");
        assert_eq!(
            torque(doubled.unwrap()).and_then(tree::as_number),
            Some(2e-3)
        );
    }
}
