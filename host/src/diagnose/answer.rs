//! What the engine says: the diagnosis, the mismatch map before and after, and each finding's cell.

use std::collections::BTreeMap;

use serde::Serialize;

use super::effect::Effect;
use super::numbers::Knob;
use crate::diagnose::diagnosis::Diagnosis;

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
    /// Share of the reducible squares that each finding explains, in the findings' order; none where it is counted or is noise.
    pub shares: Vec<Option<f64>>,
    /// RMS of the errors of the disc's edges, rad, where the twins do not give the disc and it was learned.
    pub learned_disc_rms_rad: Option<f64>,
    /// Errors of the disc's edges, rad, where it was learned.
    #[serde(skip)]
    pub pattern: Option<Vec<f64>>,
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

/// An effect with its sizes.
#[derive(Clone, Debug, Serialize)]
pub struct Sized {
    /// It.
    pub effect: Effect,
    /// Its sizes: one, or of cosine and sine.
    pub sizes: Vec<f64>,
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
