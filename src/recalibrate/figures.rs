//! The new table against the one in use, on turns that neither was learned from.

use serde::{Deserialize, Serialize};

/// How far the edges of fresh turns are off with a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scatter {
    /// RMS of the way from edge to edge against the way that its time says, 2^-32 turn: what makes the speed rough.
    pub interval: u32,
    /// RMS of the angle against smooth motion over the turn, 2^-32 turn; what the shaft itself swings is in it.
    pub angle: u32,
}

/// What fresh turns say of both tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Figures {
    /// Fresh turns used.
    pub turns: u32,
    /// Turns that could not be used.
    pub rejected: u32,
    /// With the table in use, or without any if there is none.
    pub old: Scatter,
    /// With the new one.
    pub new: Scatter,
    /// Whether the new one is better for certain: intervals or angle scatter less, and neither more, by more than chance.
    pub better: bool,
}

impl Figures {
    /// Whether edges are off more with the new table, by more than a thirty-second, from edge to edge or over the turn: a warning, while
    /// [`Self::better`] is a proof.
    #[must_use]
    pub const fn is_worse(&self) -> bool {
        const fn more(new: u32, old: u32) -> bool {
            new > old.saturating_add(old / 32)
        }
        let (old, new) = (&self.old, &self.new);
        !self.better && (more(new.interval, old.interval) || more(new.angle, old.angle))
    }
}
