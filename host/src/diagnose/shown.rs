//! What a report draws: the residual before and after, where a finding shows, and the spectra.

use crate::mechanism::Mechanism;

/// A drawn line: x and y.
pub type Line = Vec<(f64, f64)>;

/// Curves of a diagnosis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// One for each finding, in their order.
    pub findings: Vec<FindingPlot>,
    /// One for each recording.
    pub recordings: Vec<RecordingPlot>,
}

/// The residual in the coordinate in which a finding shows.
#[derive(Clone, Debug, PartialEq)]
pub struct FindingPlot {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// What x is: "angle of the disc, degrees", "time, s", "cycles a turn".
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// Without the finding.
    pub before: Line,
    /// With it.
    pub after: Line,
    /// What the finding itself makes; empty where it is a noise.
    pub model: Line,
}

/// One recording's residual.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingPlot {
    /// Along time, s: how far edges come from where they were expected, urad, twin as given.
    pub before: Line,
    /// The same with the findings.
    pub after: Line,
    /// Power against cycles a turn before, 1 is noise.
    pub spectrum_before: Line,
    /// The same with the findings.
    pub spectrum_after: Line,
    /// Power that noise alone reaches once in twenty recordings.
    pub threshold: f64,
}
