//! Which turns of a recording were thrown out, and why.

use quadcal::estimate::Rejection;

/// A turn that was not learned from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RejectedTurn {
    /// Its number in the recording: 1 is the first whole turn, from the first index on (from the first edge without an index).
    pub number: u64,
    /// When it began, ticks of the recording.
    pub start: u64,
    /// How long it took, ticks; none where the recording ends within it.
    pub duration: Option<u64>,
    /// Why.
    pub reason: Rejection,
}

/// The turns of one recording that were not learned from, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RejectedTurns {
    listed: Vec<RejectedTurn>,
    more: u64,
}

impl RejectedTurns {
    /// Turns listed at most; of more, only the number is kept.
    pub const LISTED_MAX: usize = 1000;

    /// The first of them.
    #[must_use]
    pub fn listed(&self) -> &[RejectedTurn] {
        &self.listed
    }

    /// How many came after those listed.
    #[must_use]
    pub fn more(&self) -> u64 {
        self.more
    }

    pub(super) fn push(&mut self, turn: RejectedTurn) {
        if self.listed.len() < Self::LISTED_MAX {
            self.listed.push(turn);
        } else {
            self.more += 1;
        }
    }

    /// The turn rejected last, if it is on the list.
    pub(super) fn last_mut(&mut self) -> Option<&mut RejectedTurn> {
        self.listed.last_mut().filter(|_| self.more == 0)
    }
}
