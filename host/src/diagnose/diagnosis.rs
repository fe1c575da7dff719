//! What a diagnosis says: the verdict, what was found, and how well it fits. The JSON of `quadcal diagnose` is this, field by field.

use std::collections::BTreeMap;

use super::edges::Stretch;
use super::effect::Effect;
use super::numbers::Knob;
use super::spread::Spread;
use serde::{Deserialize, Serialize};

use crate::mechanism::Mechanism;

/// A finished diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Version of this form: 2.
    pub version: u32,
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict in a sentence or two.
    pub summary: String,
    /// The recordings, in the order given.
    pub recordings: Vec<RecordingFacts>,
    /// How well simulation and recordings agree, all recordings together.
    pub fit: Fit,
    /// What was missing, the surest first.
    pub findings: Vec<Finding>,
    /// The recording to make next, where one would decide something.
    pub next_recording: Option<NextRecording>,
}

/// What comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The twin explains the recordings: what is left is noise.
    Complete,
    /// With the findings, what is left is noise.
    Explained,
    /// Findings have names, and something else is left.
    Partly,
    /// Some finding may be one mechanism or another; these recordings can't tell.
    Ambiguous,
    /// Something is there and it is none of the catalogue's mechanisms.
    Unknown,
}

/// One recording as the diagnosis read it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingFacts {
    /// Its file.
    pub file: String,
    /// Its twin's file.
    pub twin: String,
    /// Edges that were compared.
    pub edges: u64,
    /// Edges in the recording: of very many some are compared.
    pub edges_recorded: u64,
    /// Turns that they make.
    pub turns: f64,
    /// From first to last edge, s.
    pub seconds: f64,
    /// Least and greatest speed of the twin along the way, r/min; negative in reverse.
    pub speed_r_min: [f64; 2],
    /// Speed that the twin's drive keeps and the mean speed of the recording, r/min, where they differ so much that the twin may be of
    /// another recording; negative in reverse.
    pub other_speed_r_min: Option<[f64; 2]>,
    /// Whether angles are those of the disc by its index; else they count from the start.
    pub anchored: bool,
    /// Without an index the angle of the start, rad, as the twin gives it or the disc shows it; none where neither does, and angles count
    /// from the first edge.
    pub start_rad: Option<f64>,
    /// RMS error of a time stamp as found, s; none where nothing was compared that shows it.
    pub stamp_rms_s: Option<f64>,
    /// Times at which the count of edges was disturbed, s.
    pub disturbed_s: Vec<f64>,
    /// What was left out, and why, by time.
    pub left_out: Vec<Stretch>,
}

impl RecordingFacts {
    /// That the shaft turned at another speed than the twin's drive keeps, in words.
    #[must_use]
    pub fn other_speed(&self) -> Option<String> {
        let [declared, mean] = self.other_speed_r_min?;
        let back = if declared * mean < 0.0 {
            ", the other way (or A and B are swapped: --map)"
        } else {
            ""
        };
        Some(format!(
            "the drive of {} turns at {declared:.1} r/min, {} at {mean:.1} r/min{back}",
            self.twin, self.file
        ))
    }
}

/// Agreement: the RMS of innovations, how far each edge comes from where the twin, the edges before it and the noise of the shaft let it
/// expect. In all of it edges weigh as in the fit, so findings never make it larger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// RMS with the twin as it was given, rad.
    pub rms_before_rad: Option<f64>,
    /// RMS with the findings in the twin, rad.
    pub rms_after_rad: Option<f64>,
    /// RMS that the noise alone would have, rad.
    pub floor_rad: Option<f64>,
    /// Probability that what is left is noise, before the findings.
    pub whiteness_p_before: Option<f64>,
    /// The same with them.
    pub whiteness_p: Option<f64>,
    /// Share of the residual's variance that the edges before foretell, before the findings: what noise has none of.
    pub correlated_before: Option<f64>,
    /// The same with them.
    pub correlated: Option<f64>,
    /// Fitted on the turns before, judged on the last ones of each recording.
    pub held_out: HeldOut,
}

/// Agreement on turns that the parameters were not fitted on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// RMS with the twin as it was given, rad.
    pub rms_before_rad: Option<f64>,
    /// RMS with the findings in the twin, rad.
    pub rms_after_rad: Option<f64>,
    /// RMS that the noise alone would have, rad.
    pub floor_rad: Option<f64>,
    /// Share of what the findings could remove on these turns at best that they did remove; none without findings that can be judged.
    pub reducible_removed: Option<f64>,
}

/// Something that was missing in the twin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The mechanism: an id of the catalogue, or `unknown`.
    pub mechanism: Mechanism,
    /// Where it shows, in words: "torque at order 5, constant".
    pub text: String,
    /// Probability that it is this mechanism, among those that were weighed, 0 to 1.
    pub confidence: f64,
    /// Its parameters by the twin's name of them.
    pub parameters: BTreeMap<String, Parameter>,
    /// Where it shows.
    #[serde(rename = "where")]
    pub place: Place,
    /// What speaks for it.
    pub evidence: Evidence,
    /// Other mechanisms that these recordings allow as well.
    pub look_alikes: Vec<Mechanism>,
    /// The recording that would tell it from them, where there are some.
    pub next_recording: Option<NextRecording>,
}

impl Finding {
    /// A finding with so much in favour of it by Schwarz's criterion, against chance alone; nothing else is known of it.
    #[must_use]
    pub fn of(mechanism: Mechanism, text: String, worth: f64) -> Self {
        let by_chance = (-0.5 * worth).exp().min(1.0);
        Self {
            mechanism,
            text,
            confidence: 1.0 - by_chance,
            parameters: BTreeMap::new(),
            place: Place::default(),
            evidence: Evidence {
                delta_bic: worth,
                p_value: by_chance,
                held_out_rms_ratio: None,
                lines_beside: None,
                runner_up: None,
            },
            look_alikes: Vec::new(),
            next_recording: None,
        }
    }
}

/// A number with its interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Value.
    pub value: f64,
    /// Unit: `rad`, `s`, `N m`, `Hz`, `1`.
    pub unit: String,
    /// Interval that holds the true value in 95 of 100 cases; none where it is exact.
    pub ci95: Option<[f64; 2]>,
}

impl Parameter {
    /// A number that is exact.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self {
            value,
            unit: "1".to_owned(),
            ci95: None,
        }
    }

    /// A number between two ends.
    #[must_use]
    pub fn between(value: f64, unit: &str, ends: [f64; 2]) -> Self {
        Self {
            value,
            unit: unit.to_owned(),
            ci95: Some(ends),
        }
    }

    /// A number that may be off by so much either way.
    #[must_use]
    pub fn about(value: f64, unit: &str, by: f64) -> Self {
        Self::between(value, unit, [value - by, value + by])
    }
}

/// Where a finding shows; an empty list says nothing, not "none".
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Cycles a turn.
    pub orders: Vec<f64>,
    /// Orders that so few edges a turn do not tell from it.
    pub orders_alike: Vec<f64>,
    /// Hz.
    pub frequencies_hz: Vec<f64>,
    /// Degrees of the disc.
    pub angles_deg: Vec<f64>,
    /// Edges of the disc that a place of it moves, where these are few.
    #[serde(default)]
    pub edges: Vec<EdgeOff>,
    /// Instants, s from the recording's clock zero.
    pub times_s: Vec<f64>,
    /// Names of edge classes: "A rise".
    pub edge_classes: Vec<String>,
    /// Channels: "A".
    pub channels: Vec<String>,
    /// "forward", "reverse".
    pub directions: Vec<String>,
    /// Power of the speed that its angle goes with, where it was seen at more than one.
    pub speed_exponent: Option<f64>,
}

/// An edge of the disc that is off its place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeOff {
    /// Its number, as in `errors.csv`.
    pub edge: usize,
    /// By how much, rad.
    pub error_rad: f64,
    /// 95 % interval of that, rad.
    pub ci95: [f64; 2],
}

impl Place {
    /// Of errors of stamps: their angles go with the speed.
    #[must_use]
    pub fn of_stamps() -> Self {
        Self {
            speed_exponent: Some(1.0),
            ..Self::default()
        }
    }
}

/// What speaks for a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Schwarz's criterion without it less that with it: above 10 is strong.
    pub delta_bic: f64,
    /// Probability that noise alone shows as much anywhere in what was searched.
    pub p_value: f64,
    /// RMS on held-out turns with it over that without it.
    pub held_out_rms_ratio: Option<f64>,
    /// How many times as much as in white noise lines beside its order or frequency explain: a finding that is one has to stand out of them.
    pub lines_beside: Option<f64>,
    /// The next best mechanism, and Schwarz's criterion with it in place less that of the finding.
    pub runner_up: Option<RunnerUp>,
}

/// The next best explanation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunnerUp {
    /// Its mechanism.
    pub mechanism: Mechanism,
    /// How much worse it is by Schwarz's criterion.
    pub delta_bic: f64,
}

/// A recording that would decide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextRecording {
    /// What to do, in a sentence.
    pub text: String,
}

/// An answer; its JSON is that of a diagnosis with the map and the cells beside it.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// Verdict, findings, fit.
    #[serde(flatten)]
    pub diagnosis: Diagnosis,
    /// How much of the residual each site explains following each carrier, as the twin was given and with the findings.
    pub map: Map,
    /// The cells of each finding, in the findings' order, with their sizes; empty where it is counted or is noise.
    pub cells: Vec<Vec<Sized>>,
    /// Whether the twins declare an inertia; sizes of torques are over it where they do not, N m/(kg m^2).
    pub inertia_known: bool,
    /// Share of the reducible squares that each finding explains, in the findings' order; none where it is counted or is noise.
    pub shares: Vec<Option<f64>>,
    /// RMS of the errors of the disc's edges, rad, where the twins do not give the disc and it was learned.
    pub learned_disc_rms_rad: Option<f64>,
    /// The speed loop that drives the shaft, where the twins do not say how it is driven and the edges show one.
    pub learned_speed_loop: Option<LearnedLoop>,
    /// The mode of the machine that noise keeps ringing, where the twins do not say how it is driven and the edges show one.
    pub learned_ringing: Option<LearnedRinging>,
    /// Errors of the disc's edges, rad, where it was learned.
    #[serde(skip)]
    pub pattern: Option<LearnedDisc>,
    /// Of each finding, in the findings' order, the numbers of the twin that it corrects, as the twin declares them.
    pub declared: Vec<BTreeMap<String, f64>>,
    /// Numbers that the twins declare and that these recordings can't determine, in words: nothing is said of them.
    pub not_identifiable: Vec<String>,
    /// Of each recording, the numbers that its twin declares and the findings correct, with their values.
    #[serde(skip)]
    pub corrected: Vec<Vec<(Knob, Vec<f64>)>>,
    /// Innovations along time, for plots.
    #[serde(skip)]
    pub curves: Vec<Curve>,
}

/// Errors of a disc as they were learned.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedDisc {
    /// Error of each edge as recorded edges count them, rad.
    pub errors_rad: Vec<f64>,
    /// How sure they are.
    pub spread: Spread,
}

/// A mode that noise keeps ringing, as the edges show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LearnedRinging {
    /// Its frequency undamped, Hz.
    pub f_hz: f64,
    /// Its damping over critical damping.
    pub damping_ratio: f64,
}

/// A speed loop as the edges show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LearnedLoop {
    /// Its sampling rate, Hz.
    pub f_hz: f64,
    /// Proportional gain, N m s; over the inertia, 1/s, where the twins do not give that.
    pub kp_n_m_s: f64,
    /// Integral gain, N m; over the inertia, 1/s^2, where the twins do not give that.
    pub ki_n_m: f64,
}

/// An effect with its sizes.
#[derive(Clone, Debug, Serialize)]
pub struct Sized {
    /// It.
    pub effect: Effect,
    /// Its sizes: one, or of cosine and sine.
    pub sizes: Vec<f64>,
    /// 95 % intervals: of the size, or of the amplitude where there are two, then of each number of carrier and growth; none of what is not
    /// fitted.
    pub ci95: Vec<Option<[f64; 2]>>,
    /// Its size at the recordings' mean speed, where it goes with the speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_speed: Option<AtSpeed>,
}

/// The size, or amplitude, of what goes with the speed, at one speed.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AtSpeed {
    /// The speed, rad/s.
    pub rad_s: f64,
    /// The size there, in the unit of the site.
    pub size: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// The mismatch map: fall of the sum of squares a number, site by carrier; none where a cell can't be.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Map {
    /// Rows.
    pub sites: Vec<&'static str>,
    /// Columns.
    pub carriers: Vec<&'static str>,
    /// With the twin as given.
    pub before: Vec<Vec<Option<f64>>>,
    /// With the findings.
    pub after: Vec<Vec<Option<f64>>>,
}

/// RMS of the innovations of a recording, in windows along time.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The recording's file.
    pub file: String,
    /// Start of each window, s.
    pub time_s: Vec<f64>,
    /// With the twin as given, rad.
    pub before_rad: Vec<f64>,
    /// With the findings, rad.
    pub after_rad: Vec<f64>,
}
