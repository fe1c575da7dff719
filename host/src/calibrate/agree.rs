//! Whether two recordings are of one encoder, seen by one timer.

use quadcal::estimate::Anchor;
use thiserror::Error;

use crate::sensor::{SensorKind, SensorPlan};

/// Why two recordings can't be learned from together. The files' names are the caller's to say, this one's first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Disagreement {
    /// Two kinds of sensor.
    #[error("this one is of {this}, the other of {other}; give recordings of one encoder")]
    Sensor {
        /// The sensor of this recording.
        this: &'static str,
        /// That of the other.
        other: &'static str,
    },
    /// Two numbers of lines.
    #[error(
        "this one shows {this} {name} a turn, the other {other}; give recordings of one encoder"
    )]
    Lines {
        /// Lines of this recording.
        this: u32,
        /// Those of the other.
        other: u32,
        /// What is counted as lines.
        name: &'static str,
    },
    /// The index marks another edge.
    #[error(
        "the index stands at another state of A and B in this one than in the other, so their edges can't be matched; record both \
         with the same wiring"
    )]
    Index,
    /// Two clocks.
    #[error(
        "this one has a clock of {this} Hz, the other of {other} Hz; record both with the same timer"
    )]
    Clock {
        /// Ticks a second of this recording.
        this: u64,
        /// Those of the other.
        other: u64,
    },
    /// No index: nothing ties an edge of one recording to one of the other.
    #[error(
        "without an index or a gap nothing ties the edges of two recordings to each other; give one recording that holds both speeds"
    )]
    NotAnchored,
    /// One recording, twice.
    #[error("both are the same recording, whose turns would count twice; give each recording once")]
    Same,
}

/// Checks that recordings of two sensors, with clocks of so many ticks a second, can be learned from together.
///
/// # Errors
/// [`Disagreement`], of `this` against the `other`.
pub fn agree(
    (this, this_hz): (SensorPlan, u64),
    (other, other_hz): (SensorPlan, u64),
) -> Result<(), Disagreement> {
    let (kind, other_kind) = (bare(this.kind), bare(other.kind));
    if kind != other_kind {
        return Err(Disagreement::Sensor {
            this: name(this.kind),
            other: name(other.kind),
        });
    }
    if this.lines != other.lines {
        return Err(Disagreement::Lines {
            this: this.lines,
            other: other.lines,
            name: this.kind.line_name(),
        });
    }
    if this_hz != other_hz {
        return Err(Disagreement::Clock {
            this: this_hz,
            other: other_hz,
        });
    }
    if this.anchor() == Anchor::FirstEdge || other.anchor() == Anchor::FirstEdge {
        return Err(Disagreement::NotAnchored);
    }
    if this.kind != other.kind {
        return Err(Disagreement::Index);
    }
    Ok(())
}

/// The kind without where its index stands.
fn bare(kind: SensorKind) -> SensorKind {
    match kind {
        SensorKind::Quadrature { .. } => SensorKind::Quadrature { index_state: None },
        kind => kind,
    }
}

const fn name(kind: SensorKind) -> &'static str {
    match kind {
        SensorKind::Quadrature { .. } => "a quadrature encoder",
        SensorKind::Hall => "three Hall sensors",
        SensorKind::Wheel {
            both_edges: true, ..
        } => "a toothed wheel with both edges of a tooth",
        SensorKind::Wheel { .. } => "one pulse a tooth",
    }
}

#[cfg(test)]
mod tests {
    use quadcal::edge::Levels;

    use super::*;

    const CLOCK_HZ: u64 = 84_000_000;

    fn quadrature(index_state: Option<u8>) -> (SensorPlan, u64) {
        let kind = SensorKind::Quadrature {
            index_state: index_state.map(Levels),
        };
        (SensorPlan { kind, lines: 50 }, CLOCK_HZ)
    }

    fn wheel(missing: u16, both_edges: bool) -> (SensorPlan, u64) {
        let kind = SensorKind::Wheel {
            both_edges,
            missing,
        };
        (SensorPlan { kind, lines: 60 }, CLOCK_HZ)
    }

    #[test]
    fn only_recordings_tied_by_an_index_or_a_gap_agree() {
        assert_eq!(agree(quadrature(Some(1)), quadrature(Some(1))), Ok(()));
        assert_eq!(agree(wheel(2, true), wheel(2, true)), Ok(()));
        for (this, other) in [
            (quadrature(None), quadrature(None)),
            (quadrature(Some(1)), quadrature(None)),
            (wheel(0, true), wheel(0, true)),
        ] {
            assert_eq!(agree(this, other), Err(Disagreement::NotAnchored));
        }
    }

    #[test]
    fn an_index_at_another_state_moves_every_edge() {
        let other = agree(quadrature(Some(1)), quadrature(Some(3)));
        assert_eq!(other, Err(Disagreement::Index));
    }

    #[test]
    fn wheels_read_by_one_edge_and_by_both_are_two_sensors() {
        let other = agree(wheel(2, true), wheel(2, false));
        assert!(matches!(other, Err(Disagreement::Sensor { .. })));
    }
}
