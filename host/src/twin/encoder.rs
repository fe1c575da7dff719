//! The encoder's part of a twin: its kind and its own errors.

use std::path::PathBuf;

use quadcal::edge::Direction;
use serde::{Deserialize, Serialize};

use super::is_zero;
use super::whole::whole;

/// Kind and counts of an encoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Encoder {
    /// Two channels a quarter line apart. Edge k is, from 0 on: A rises, B rises, A falls, B falls.
    Quadrature {
        /// Grating lines a turn, 1 to 1,000,000.
        #[serde(deserialize_with = "whole")]
        lines: u32,
        /// Whether there is an index channel Z, high from half a step before edge 0 to half a step after it.
        #[serde(default)]
        index: bool,
    },
    /// Three Hall sensors a, b, c. Going forward their levels are 001, 011, 010, 110, 100, 101; edge 0 is the step from 001 to 011.
    Hall {
        /// Magnet pole pairs a turn, 1 to 10,000; six edges each.
        #[serde(deserialize_with = "whole")]
        pole_pairs: u32,
    },
    /// One channel that is high over a tooth, with both edges. The tooth at place i rises at edge 2i and falls at edge 2i + 1; place 0
    /// is the first after the reference.
    Wheel {
        /// Tooth places a turn, 1 to 1,000,000, those of missing teeth included.
        #[serde(deserialize_with = "whole")]
        teeth: u32,
        /// Teeth that are missing, where they are the last ones of the turn.
        #[serde(default, deserialize_with = "whole")]
        missing: u32,
        /// Gaps anywhere, in place of `missing`.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        gaps: Vec<Gap>,
    },
}

/// Neighbouring teeth that a wheel lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// Place of the first missing tooth, from 0.
    #[serde(deserialize_with = "whole")]
    pub at: u32,
    /// Teeth that are missing from there on, 1 or more; the turn's last place is the last that a gap may take.
    #[serde(deserialize_with = "whole")]
    pub missing: u32,
}

impl Gap {
    fn has(self, place: u32) -> bool {
        place >= self.at && place - self.at < self.missing
    }
}

impl Encoder {
    /// Edges of the grid in one turn (4M, 6 a pole pair, 2 a tooth place), missing teeth included.
    #[must_use]
    pub const fn grid_edges(&self) -> u32 {
        match *self {
            Self::Quadrature { lines, .. } => 4 * lines,
            Self::Hall { pole_pairs } => 6 * pole_pairs,
            Self::Wheel { teeth, .. } => 2 * teeth,
        }
    }

    /// Whether there is an index.
    #[must_use]
    pub const fn has_index(&self) -> bool {
        matches!(self, Self::Quadrature { index: true, .. })
    }

    /// Edges in a group that share a line, pole pair or tooth.
    #[must_use]
    pub const fn edges_per_line(&self) -> u32 {
        match self {
            Self::Quadrature { .. } => 4,
            Self::Hall { .. } => 6,
            Self::Wheel { .. } => 2,
        }
    }

    /// Edges that really happen in one turn: [`Self::grid_edges`] without those of missing teeth.
    #[must_use]
    pub fn real_edges(&self) -> u32 {
        let missing: u32 = self.all_gaps().map(|gap| 2 * gap.missing).sum();
        self.grid_edges() - missing
    }

    /// Whether an edge of the grid happens: those of missing teeth do not.
    #[must_use]
    pub fn is_real(&self, edge: u32) -> bool {
        self.edges_to_real(edge, Direction::Forward) == 0
    }

    /// Steps of the grid from an edge on to the next that happens; 0 where it happens itself. At least one tooth is there.
    #[must_use]
    pub fn edges_to_real(&self, edge: u32, direction: Direction) -> u32 {
        let grid = self.grid_edges();
        let (mut at, mut steps) = (edge, 0);
        while let Some(gap) = self.all_gaps().find(|gap| gap.has(at / 2)) {
            let (first, behind) = (2 * gap.at, 2 * (gap.at + gap.missing));
            let (on, next) = match direction {
                Direction::Forward => (behind - at, behind % grid),
                Direction::Reverse => (at - first + 1, (first + grid - 1) % grid),
            };
            (at, steps) = (next, steps + on);
        }
        steps
    }

    /// Teeth that are missing at the end of the turn, where that is all that is missing; none of an encoder that is no wheel.
    #[must_use]
    pub fn missing_at_end(&self) -> Option<u32> {
        let Self::Wheel { teeth, .. } = self else {
            return Some(0);
        };
        let mut gaps = self.all_gaps();
        match (gaps.next(), gaps.next()) {
            (None, _) => Some(0),
            (Some(gap), None) if gap.at + gap.missing == *teeth => Some(gap.missing),
            _ => None,
        }
    }

    fn all_gaps(&self) -> impl Iterator<Item = Gap> {
        let (last, gaps): (_, &[Gap]) = match self {
            Self::Wheel {
                teeth,
                missing,
                gaps,
            } => {
                let at = teeth.saturating_sub(*missing);
                let missing = *missing;
                ((missing > 0).then_some(Gap { at, missing }), gaps)
            }
            _ => (None, &[]),
        };
        last.into_iter().chain(gaps.iter().copied())
    }
}

/// The encoder's own errors e(k), in radians of the shaft: edge k happens at its grid angle minus e(k).
///
/// The parts add up (equation (19) with eps, xi_A, xi_B and p), or the whole of e is given as a list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// Seed of the line position error, 0 to 2^63 - 1; the twin's own where left out. Twins that share it share the disc, so with
    /// seeds of their own they are several recordings of one encoder.
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Option::is_none"
    )]
    pub seed: Option<u64>,
    /// Line position error eps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Position>,
    /// Width error xi_A: added on edges where A falls.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub width_a_rad: f64,
    /// Width error xi_B: added on edges where B falls.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub width_b_rad: f64,
    /// Width error of the third Hall sensor: added on edges where C falls.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub width_c_rad: f64,
    /// Quadrature error p: added on both edges of B. Quadrature encoders only.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub quadrature_rad: f64,
    /// Offset of the second Hall sensor: added on both edges of B.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shift_b_rad: f64,
    /// Offset of the third Hall sensor: added on both edges of C.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shift_c_rad: f64,
    /// Disc centre off the axis: amplitude sin(theta - phase).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eccentricity: Option<Harmonic>,
    /// Tilted or oval disc: amplitude sin(2 theta - phase).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<Harmonic>,
    /// The whole of e, one number for each edge of the grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub list_rad: Vec<f64>,
    /// The whole of e as a CSV file with the header `k,e_rad`, every k of the grid once, or as `quadcal calibrate --csv` writes it; the
    /// path is relative to the twin's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// How sure the slow waves of `csv` are: standard errors of the cosine and the sine of order 1, of order 2, and so on, beside the
    /// list's own `standard_error_rad`. Torque that nobody knows blurs the first orders most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wave_standard_errors_rad: Vec<f64>,
    /// The one speed at which `csv` was learned, where it was one: delays of edge classes, which nothing told from the disc there, are part
    /// of the list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned_r_min: Option<f64>,
}

/// Distribution of the line position error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Position {
    /// Uniform within plus and minus the amplitude.
    Uniform {
        /// Largest size, rad.
        amplitude_rad: f64,
        /// Whether each edge or each line has its own.
        #[serde(default)]
        per: Per,
    },
    /// Normal.
    Normal {
        /// RMS, rad.
        rms_rad: f64,
        /// Whether each edge or each line has its own.
        #[serde(default)]
        per: Per,
    },
}

/// What has its own line position error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Per {
    /// Every edge.
    #[default]
    Edge,
    /// Every line (pole pair, tooth): its edges share one.
    Line,
}

/// A sine over the turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Amplitude, rad.
    pub amplitude_rad: f64,
    /// Phase, rad.
    #[serde(default)]
    pub phase_rad: f64,
}
