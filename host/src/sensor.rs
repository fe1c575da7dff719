//! The core's decoder for whatever sensor a recording is of, chosen at run time.

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::estimate::Anchor;
use quadcal::hall::HallDecoder;
use quadcal::shape::EncoderShape;
use quadcal::step::{Faults, Outcome, SensorError};
use quadcal::wheel::{WheelConfig, WheelDecoder};
use thiserror::Error;

use crate::recording::Channels;

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
    /// Three Hall sensors.
    Hall,
    /// One channel.
    Wheel {
        /// Whether both edges of a tooth count.
        both_edges: bool,
        /// Missing teeth at the reference gap, 0 for none.
        missing: u16,
    },
}

/// A plan that the core can't work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PlanError {
    /// Out of the core's range.
    #[error("{0} lines a turn are out of range: 3 to 65536 edges can be kept apart")]
    Lines(u32),
    /// More teeth missing than a wheel can miss.
    #[error(
        "a wheel of {teeth} teeth can't miss {missing} of them: at least half, and four, must be there"
    )]
    Missing {
        /// Teeth, missing ones counted.
        teeth: u32,
        /// Missing teeth.
        missing: u16,
    },
}

impl SensorKind {
    /// Edge classes: kinds of edges with an error of their own.
    #[must_use]
    pub fn classes(self) -> u32 {
        match self {
            Self::Quadrature { .. } => 4,
            Self::Hall => 6,
            Self::Wheel { both_edges, .. } => 1 + u32::from(both_edges),
        }
    }

    /// The kind that a recording's channels show.
    #[must_use]
    pub fn of(channels: Channels, index_state: Option<Levels>, missing: u16) -> Self {
        match channels {
            Channels::Quadrature { .. } => Self::Quadrature { index_state },
            Channels::Hall => Self::Hall,
            Channels::Wheel => Self::Wheel {
                both_edges: true,
                missing,
            },
            Channels::Pulses => Self::Wheel {
                both_edges: false,
                missing,
            },
        }
    }

    /// Names of the edge classes, in order.
    #[must_use]
    pub fn class_names(self) -> &'static [&'static str] {
        match self {
            Self::Quadrature { .. } => &["A rise", "B rise", "A fall", "B fall"],
            Self::Hall => &["A fall", "B rise", "C fall", "A rise", "B fall", "C rise"],
            Self::Wheel {
                both_edges: true, ..
            } => &["rise", "fall"],
            Self::Wheel {
                both_edges: false, ..
            } => &["pulse"],
        }
    }

    /// What is counted as lines.
    #[must_use]
    pub fn line_name(self) -> &'static str {
        match self {
            Self::Quadrature { .. } => "lines",
            Self::Hall => "pole pairs",
            Self::Wheel { .. } => "teeth",
        }
    }
}

impl SensorPlan {
    /// Edges and classes a turn.
    ///
    /// # Errors
    /// [`PlanError::Lines`] when the core has no room for that many edges.
    pub fn shape(self) -> Result<EncoderShape, PlanError> {
        let classes = self.kind.classes();
        let edges = self
            .lines
            .checked_mul(classes)
            .ok_or(PlanError::Lines(self.lines))?;
        EncoderShape::new(edges, classes).map_err(|_| PlanError::Lines(self.lines))
    }

    /// Edges of the grid that a wheel's gap leaves out; 0 for other sensors.
    #[must_use]
    pub fn gap_edges(self) -> u32 {
        match self.kind {
            SensorKind::Wheel {
                both_edges,
                missing,
            } => u32::from(missing) * (1 + u32::from(both_edges)),
            _ => 0,
        }
    }

    /// Where edge 0 is.
    #[must_use]
    pub fn anchor(self) -> Anchor {
        match self.kind {
            SensorKind::Quadrature {
                index_state: Some(_),
            } => Anchor::Index,
            SensorKind::Wheel { missing, .. } if missing > 0 => Anchor::Index,
            _ => Anchor::FirstEdge,
        }
    }

    /// The decoder.
    ///
    /// # Errors
    /// [`PlanError`] when a number is out of range.
    pub fn decoder(self) -> Result<Decoder, PlanError> {
        let result = match self.kind {
            SensorKind::Quadrature { index_state } => {
                let mut config = DecoderConfig::new(self.lines);
                config.index_state = index_state.unwrap_or(config.index_state);
                QuadratureDecoder::new(config).map(Decoder::Quadrature)
            }
            SensorKind::Hall => HallDecoder::new(self.lines).map(Decoder::Hall),
            SensorKind::Wheel {
                both_edges,
                missing,
            } => {
                let config = WheelConfig {
                    missing,
                    both_edges,
                    ..WheelConfig::new(self.lines)
                };
                WheelDecoder::new(config).map(Decoder::Wheel)
            }
        };
        result.map_err(|error| match (error, self.kind) {
            (SensorError::Missing, SensorKind::Wheel { missing, .. }) => PlanError::Missing {
                teeth: self.lines,
                missing,
            },
            _ => PlanError::Lines(self.lines),
        })
    }
}

/// A decoder of any kind.
#[derive(Clone)]
pub enum Decoder {
    /// Quadrature.
    Quadrature(QuadratureDecoder),
    /// Three Hall sensors.
    Hall(HallDecoder),
    /// One channel.
    Wheel(WheelDecoder),
}

impl Decoder {
    /// Takes one sample.
    #[inline]
    pub fn push(&mut self, sample: Sample) -> Outcome {
        match self {
            Self::Quadrature(decoder) => decoder.push(sample),
            Self::Hall(decoder) => decoder.push(sample),
            Self::Wheel(decoder) => decoder.push(sample),
        }
    }

    /// Faults counted so far.
    #[must_use]
    pub fn faults(&self) -> Faults {
        match self {
            Self::Quadrature(decoder) => *decoder.faults(),
            Self::Hall(decoder) => *decoder.faults(),
            Self::Wheel(decoder) => *decoder.faults(),
        }
    }
}
