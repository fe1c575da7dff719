//! What comes of an edge.

use crate::corrector::CorrectedEdge;
use crate::interval::{Passed, Speed};

/// One edge: angle, way and time, and the speed on demand.
///
/// See [`Encoder`](super::Encoder) for an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Corrected {
    /// Angle (2^-32 turn), time (ticks) and facts.
    pub edge: CorrectedEdge,
    pub(super) passed: Passed,
}

impl Corrected {
    /// Mean speed since the edge before, equations (2) and (3), 2^-60 turn a tick, forward positive; 0 at the first edge, at a reversal and
    /// after 2^32 ticks or more. Below the exact quotient by at most 2^-29 of it. Worked out here, without a division.
    #[inline]
    #[must_use]
    pub fn speed(&self) -> Speed {
        self.passed.speed()
    }
}
