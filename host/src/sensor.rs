//! The core's decoder for whatever sensor a recording is of, chosen at run time.

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::estimate::Anchor;
use quadcal::shape::{EncoderShape, ShapeError};
use quadcal::step::{Faults, Outcome, SensorError};
use thiserror::Error;

/// A sensor as it is declared or was found in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorPlan {
    /// Kind of sensor.
    pub kind: SensorKind,
    /// Lines, pole pairs or teeth a turn (missing teeth counted).
    pub lines: u32,
}

/// Kinds of sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// A and B, and the index, if there is one.
    Quadrature {
        /// State of A and B in which a high Z marks line 0; none where there is no index.
        index_state: Option<Levels>,
    },
}

/// A plan that the core can't work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PlanError {
    /// Out of the core's range.
    #[error("{0} lines are out of range: a turn may have 3 to 65536 edges")]
    Lines(u32),
}

impl SensorPlan {
    /// Edges and classes a turn.
    ///
    /// # Errors
    /// [`PlanError::Lines`] when the core has no room for that many edges.
    pub fn shape(self) -> Result<EncoderShape, PlanError> {
        let classes = match self.kind {
            SensorKind::Quadrature { .. } => 4,
        };
        let out_of_range = |_: ShapeError| PlanError::Lines(self.lines);
        let edges = self
            .lines
            .checked_mul(classes)
            .ok_or(PlanError::Lines(self.lines))?;
        EncoderShape::new(edges, classes).map_err(out_of_range)
    }

    /// Where edge 0 is.
    #[must_use]
    pub fn anchor(self) -> Anchor {
        match self.kind {
            SensorKind::Quadrature {
                index_state: Some(_),
            } => Anchor::Index,
            SensorKind::Quadrature { index_state: None } => Anchor::FirstEdge,
        }
    }

    /// The decoder.
    ///
    /// # Errors
    /// [`PlanError::Lines`] when the number of lines is out of range.
    pub fn decoder(self) -> Result<Decoder, PlanError> {
        let out_of_range = |_: SensorError| PlanError::Lines(self.lines);
        match self.kind {
            SensorKind::Quadrature { index_state } => {
                let mut config = DecoderConfig::new(self.lines);
                config.index_state = index_state.unwrap_or(config.index_state);
                QuadratureDecoder::new(config)
                    .map(Decoder::Quadrature)
                    .map_err(out_of_range)
            }
        }
    }
}

/// A decoder of any kind.
#[allow(clippy::large_enum_variant)]
pub enum Decoder {
    /// Quadrature.
    Quadrature(QuadratureDecoder),
}

impl Decoder {
    /// Takes one sample.
    #[inline]
    pub fn push(&mut self, sample: Sample) -> Outcome {
        match self {
            Self::Quadrature(decoder) => decoder.push(sample),
        }
    }

    /// Faults counted so far.
    #[must_use]
    pub fn faults(&self) -> Faults {
        match self {
            Self::Quadrature(decoder) => *decoder.faults(),
        }
    }
}
