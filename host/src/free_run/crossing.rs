//! The edges of a recording as the loop saw them, and where each stands on the disc.

use quadcal::edge::Direction;
use quadcal::estimate::Anchor;
use quadcal::step::{Flags, Outcome};

use super::error::FreeRunError;
use crate::recording::{ReadError, Row};
use crate::sensor::SensorPlan;

/// A captured edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Its time.
    pub ticks: u64,
    /// Number of the edge on the grid.
    pub edge: u32,
    /// Steps of the grid since the edge before, as the loop counts them.
    pub steps: u16,
    /// Direction of motion.
    pub direction: Direction,
    /// Whether the edge's number and the interval before it can be trusted.
    pub sure: bool,
}

impl Crossing {
    /// Steps of the grid since the edge before, negative in reverse.
    #[must_use]
    pub fn way(&self) -> i64 {
        i64::from(self.direction.sign()) * i64::from(self.steps)
    }

    /// The edge in what a decoder made of a row, if there is one. Where an index is the anchor, numbers before it are not yet sure.
    #[must_use]
    pub fn of(outcome: &Outcome, anchor: Anchor) -> Option<Self> {
        let Outcome::Step(step) = outcome else {
            return None;
        };
        let doubtful = Flags::FIRST
            .with(Flags::REVERSED)
            .with(Flags::TURN_SUSPECT)
            .with(Flags::ILLEGAL);
        let anchored = anchor == Anchor::FirstEdge || step.flags.contains(Flags::REFERENCED);
        let illegal = step.flags.contains(Flags::ILLEGAL);
        Some(Self {
            ticks: step.ticks,
            edge: step.edge,
            // A capture that missed an edge has no way to know.
            steps: if illegal { 1 } else { step.advance },
            direction: step.direction,
            sure: anchored && !step.flags.intersects(doubtful),
        })
    }
}

/// The first `most` edges of a recording.
pub(super) fn first_turns(
    rows: impl Iterator<Item = Result<Row, ReadError>>,
    plan: SensorPlan,
    most: usize,
) -> Result<Vec<Crossing>, FreeRunError> {
    let mut decoder = plan.decoder()?;
    let mut crossings = Vec::new();
    for row in rows {
        if let Some(crossing) = Crossing::of(&decoder.push(row?), plan.anchor()) {
            crossings.push(crossing);
            if crossings.len() > most {
                break;
            }
        }
    }
    Ok(crossings)
}
