//! The numbers that a twin declares: where they are, the mechanism that each is of, and twins with other values of them.

use std::f64::consts::{PI, TAU};
use std::fmt;

use serde_json::Value;

use crate::mechanism::Mechanism;
use crate::twin::{Drive, KEYS, Twin};

/// Where a number of a twin is: a pointer into its tree (RFC 6901).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Path(String);

/// Sections of which some keys are numbers of one mechanism each: those that its card has.
const SHARED: [&str; 2] = ["errors", "shaft"];
/// Sections and keys that are no numbers of physics, or whose numbers show in the noise alone: how long is recorded, what counts, where
/// it starts, sizes of noise.
const LEFT_OUT: [&str; 18] = [
    "duration",
    "encoder",
    "timer",
    "faults",
    "index_slip",
    "errors.list_rad",
    "errors.learned_r_min",
    "errors.wave_standard_errors_rad",
    "shaft.initial_angle_rad",
    "noise.white",
    "noise.speed_wander.rms_fraction",
    "noise.speed_wander.hold_s",
    "torsional_resonance.load_",
    "capture_latency",
    "drive.constant",
    "drive.run_down.r_min",
    "drive.speed_loop.r_min",
    "drive.speed_loop.timeout_s",
];
/// Sizes of what swings.
const AMPLITUDES: [&str; 5] = [
    "torque_n_m",
    "speed_fraction",
    "runout_rad",
    "angle_rad",
    "amplitude_rad",
];
/// Keys that say that a section swings.
const SWINGS: [&str; 3] = ["order", "f_hz", "phase_rad"];
/// The phase of what swings.
const PHASE: &str = "phase_rad";

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, step) in self.0.split('/').skip(1).enumerate() {
            match step.parse::<usize>() {
                Ok(place) => write!(f, "[{place}]")?,
                Err(_) if at == 0 => write!(f, "{step}")?,
                Err(_) => write!(f, ".{step}")?,
            }
        }
        Ok(())
    }
}

impl Path {
    /// What is in it at a key or at a place in a list.
    fn with(&self, step: impl fmt::Display) -> Self {
        Self(format!("{}/{step}", self.0))
    }

    /// The path of keys, without places in lists.
    fn dotted(&self) -> String {
        let steps = self.0.split('/').skip(1);
        let keys = steps.filter(|step| step.parse::<usize>().is_err());
        keys.collect::<Vec<_>>().join(".")
    }

    /// The section that it is in, and its key there.
    fn split(&self) -> (Self, &str) {
        let (section, key) = self.0.rsplit_once('/').unwrap_or_default();
        (Self(section.to_owned()), key)
    }

    /// The number there.
    pub fn number(&self, tree: &Value) -> Option<f64> {
        tree.pointer(&self.0).and_then(Value::as_f64)
    }

    fn set(&self, tree: &mut Value, number: f64) {
        let (section, key) = self.split();
        if let Some(Value::Object(section)) = tree.pointer_mut(&section.0) {
            section.insert(key.to_owned(), Value::from(number));
        }
    }

    /// The mechanism that it is of, going by the section of each card; none where it is of the drive or the shaft itself.
    pub fn mechanism(&self) -> Mechanism {
        let dotted = self.dotted();
        let is_of = |mechanism: &Mechanism| {
            let card = mechanism.card();
            let own = dotted.strip_prefix(&card.twin);
            own.is_some_and(|key| key.starts_with('.'))
                && (!SHARED.contains(&card.twin.as_str())
                    || card.quantity(self.split().1).is_some())
        };
        let other = match dotted.starts_with("errors") {
            true => Mechanism::LineError,
            false => Mechanism::Unknown,
        };
        Mechanism::ALL.into_iter().find(is_of).unwrap_or(other)
    }

    /// What is one finding: numbers of one mechanism in one entry of a list, or in one section.
    pub fn entry(&self) -> String {
        let mechanism = self.mechanism();
        let place = self.0.split('/').nth(2);
        match place.and_then(|place| place.parse::<usize>().ok()) {
            Some(at) => format!("{mechanism}[{at}]"),
            _ if mechanism == Mechanism::Unknown => self.to_string(),
            _ => mechanism.to_string(),
        }
    }

    /// Its name within its mechanism's section: "torque_n_m", "a.rise_s".
    pub fn name(&self) -> String {
        let dotted = self.dotted();
        let of_delay = dotted.strip_prefix("edge_delay.");
        of_delay.unwrap_or(self.split().1).to_owned()
    }

    /// Its unit, as the list of a twin's keys has it.
    pub fn unit(&self) -> &'static str {
        let dotted = self.dotted();
        let of_line = |line: &'static str| {
            let (key, rest) = line.split_once(' ')?;
            let unit = rest.trim_start().split("  ").next()?;
            (key.replace("[]", "") == dotted && unit != "-").then_some(unit)
        };
        KEYS.lines().find_map(of_line).unwrap_or("1")
    }
}

/// A twin as a tree of keys and values.
pub fn tree(twin: &Twin) -> Option<Value> {
    serde_json::to_value(twin).ok()
}

/// A tree as a twin; files and name are those of another one.
fn twin_of(tree: Value, like: &Twin) -> Option<Twin> {
    let mut twin: Twin = serde_json::from_value(tree).ok()?;
    twin.name.clone_from(&like.name);
    twin.folder.clone_from(&like.folder);
    // Points of a file are not in the tree.
    match (&mut twin.drive, &like.drive) {
        (Drive::Profile(one), Drive::Profile(other)) if other.csv.is_some() => {
            one.clone_from(other)
        }
        (Drive::Torque(one), Drive::Torque(other)) if other.csv.is_some() => one.clone_from(other),
        _ => {}
    }
    Some(twin)
}

/// What of a twin is changed as one: a number, or size and phase of what swings, as cosine and sine.
#[derive(Clone, Debug, PartialEq)]
pub enum Knob {
    /// A number.
    Number(Path),
    /// A size and its phase.
    Wave(Path, Path),
}

impl Knob {
    /// Paths of its numbers.
    pub fn paths(&self) -> Vec<&Path> {
        match self {
            Self::Number(path) => vec![path],
            Self::Wave(size, phase) => vec![size, phase],
        }
    }

    /// The path that it is known by.
    pub const fn path(&self) -> &Path {
        match self {
            Self::Number(path) | Self::Wave(path, _) => path,
        }
    }

    /// Whether it is the size of a disc that the twin draws.
    pub fn draws_disc(&self) -> bool {
        self.path().dotted().starts_with("errors.position")
    }

    /// Whether it is of the edges of the disc that the twin gives, one by one or at a place: it says nothing of another disc.
    pub fn is_of_edges(&self) -> bool {
        self.draws_disc() || self.path().mechanism() == Mechanism::LocalDefect
    }

    /// Its values as they are fitted.
    pub fn values(&self, tree: &Value) -> Option<Vec<f64>> {
        match self {
            Self::Number(path) => Some(vec![path.number(tree)?]),
            Self::Wave(size, phase) => {
                let (size, phase) = (size.number(tree)?, phase.number(tree).unwrap_or(0.0));
                Some(vec![size * phase.cos(), size * phase.sin()])
            }
        }
    }

    /// The numbers of the twin for values as they are fitted.
    pub fn numbers(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Number(_) => values.to_vec(),
            Self::Wave(..) => vec![
                values[0].hypot(values[1]),
                values[1].atan2(values[0]).rem_euclid(TAU),
            ],
        }
    }

    /// Standard errors of those numbers, from the covariance of the values.
    pub fn errors(&self, values: &[f64], covariance: &[[f64; 2]; 2]) -> Vec<f64> {
        match self {
            Self::Number(_) => vec![covariance[0][0].max(0.0).sqrt()],
            Self::Wave(..) => wave_errors([values[0], values[1]], covariance).to_vec(),
        }
    }

    /// Puts values into a tree.
    fn put(&self, tree: &mut Value, values: &[f64]) {
        for (path, number) in self.paths().into_iter().zip(self.numbers(values)) {
            path.set(tree, number);
        }
    }
}

/// Standard errors of amplitude and phase, from the covariance of cosine and sine.
pub fn wave_errors([c, s]: [f64; 2], covariance: &[[f64; 2]; 2]) -> [f64; 2] {
    let [[cc, cs], [_, ss]] = *covariance;
    let square = (c * c + s * s).max(f64::MIN_POSITIVE);
    let along = (c * c * cc + 2.0 * c * s * cs + s * s * ss) / square;
    let across = (s * s * cc - 2.0 * c * s * cs + c * c * ss) / square;
    [
        along.max(0.0).sqrt(),
        (across.max(0.0) / square).sqrt().min(PI),
    ]
}

/// A twin with other values of some knobs; none where there is no such twin.
pub fn changed(twin: &Twin, values: &[(&Knob, &[f64])]) -> Option<Twin> {
    let mut tree = tree(twin)?;
    for (knob, values) in values {
        knob.put(&mut tree, values);
    }
    twin_of(tree, twin)
}

/// All knobs of a twin whose numbers it declares: none that is 0. A phase that is each recording's own says nothing.
pub fn knobs(twin: &Twin) -> Vec<Knob> {
    let Some(tree) = tree(twin) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    collect(&tree, &tree, &Path::default(), &mut all);
    let each = all.into_iter();
    each.map(|knob| match knob {
        Knob::Wave(size, _) if is_free(twin, &tree, &size) => Knob::Number(size),
        other => other,
    })
    .collect()
}

/// What of a twin swings with a phase that is each recording's own.
pub fn free_waves(twin: &Twin) -> Vec<Knob> {
    let Some(tree) = tree(twin) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    collect(&tree, &tree, &Path::default(), &mut all);
    all.retain(|knob| matches!(knob, Knob::Wave(size, _) if is_free(twin, &tree, size)));
    all
}

/// Whether the phase of a size is each recording's own: of an order that is not whole, or a frequency.
fn is_free(twin: &Twin, tree: &Value, size: &Path) -> bool {
    let number = |key: &str| size.split().0.with(key).number(tree);
    let turns = number("order").is_some_and(|order| order.fract() != 0.0);
    twin.free_phases && (turns || number("f_hz").is_some())
}

fn collect(tree: &Value, value: &Value, path: &Path, all: &mut Vec<Knob>) {
    let dotted = path.dotted();
    if LEFT_OUT.iter().any(|start| dotted.starts_with(start)) {
        return;
    }
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                collect(tree, value, &path.with(key), all);
            }
        }
        Value::Array(list) => {
            for (at, value) in list.iter().enumerate() {
                collect(tree, value, &path.with(at), all);
            }
        }
        Value::Number(number) if number.is_f64() && number.as_f64() != Some(0.0) => {
            let (section, key) = path.split();
            let number = |key: &str| section.with(key).number(tree);
            if AMPLITUDES.contains(&key) && SWINGS.iter().any(|key| number(key).is_some()) {
                all.push(Knob::Wave(path.clone(), section.with(PHASE)));
            } else if key != PHASE
                || AMPLITUDES
                    .iter()
                    .all(|key| number(key).unwrap_or(0.0) == 0.0)
            {
                all.push(Knob::Number(path.clone()));
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWIN: &str = "duration = { turns = 10 }\n[encoder.wheel]\nteeth = 60\n[shaft]\ninertia_kg_m2 = 1e-4\n\
        coulomb_n_m = 1e-3\n[drive.constant]\nr_min = 300\n[timer]\nclock_hz = 1000000\n\
        [[gear_mesh]]\norder = 7.3\ntorque_n_m = 1e-3\n[edge_delay]\na = { rise_s = 1e-6 }\n";

    #[test]
    fn a_twin_has_its_numbers_of_physics_and_none_that_only_count() {
        let twin = Twin::parse(TWIN, "t.toml").unwrap();
        let names: Vec<String> = knobs(&twin)
            .iter()
            .map(|knob| knob.path().to_string())
            .collect();
        for expected in [
            "gear_mesh[0].torque_n_m",
            "gear_mesh[0].order",
            "shaft.coulomb_n_m",
            "shaft.inertia_kg_m2",
            "edge_delay.a.rise_s",
        ] {
            assert!(names.contains(&expected.to_owned()), "{expected} {names:?}");
        }
        assert!(
            !names
                .iter()
                .any(|name| name.contains("duration") || name.contains("clock"))
        );
    }

    #[test]
    fn phases_at_whole_orders_and_of_the_disc_are_the_machines_others_may_be_each_recordings() {
        let more = "[[torque_tone]]\nf_hz = 50\ntorque_n_m = 1e-3\n[[ripple]]\norder = 5\ntorque_n_m = 1e-3\n\
            [errors.eccentricity]\namplitude_rad = 1e-4\nphase_rad = 1\n";
        let free = |start: &str| {
            let twin = Twin::parse(&format!("{start}{TWIN}{more}"), "t.toml").unwrap();
            let free = free_waves(&twin).into_iter();
            let mut free: Vec<String> = free.map(|knob| knob.path().to_string()).collect();
            // A phase that is free is no number of the twin.
            let waves = knobs(&twin).into_iter();
            let waves = waves.filter(|knob| matches!(knob, Knob::Wave(..))).count();
            assert_eq!(waves + free.len(), 4);
            free.sort();
            free
        };
        assert_eq!(free(""), [""; 0]);
        let expected = ["gear_mesh[0].torque_n_m", "torque_tone[0].torque_n_m"];
        assert_eq!(free("free_phases = true\n"), expected);
    }

    #[test]
    fn a_wave_through_zero_turns_its_phase() {
        let twin = Twin::parse(TWIN, "t.toml").unwrap();
        let wave = knobs(&twin)
            .into_iter()
            .find(|knob| matches!(knob, Knob::Wave(..)))
            .unwrap();
        let turned = changed(&twin, &[(&wave, &[-2e-3, 0.0])]).unwrap();
        assert!((turned.gear_mesh[0].torque_n_m.unwrap() - 2e-3).abs() < 1e-15);
        assert!((turned.gear_mesh[0].phase_rad - PI).abs() < 1e-12);
    }
}
