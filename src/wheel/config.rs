//! What a wheel is, and what it can't be.

use crate::counter::Counter;
use crate::step::{MAX_SLOTS, SensorError};

/// What the wheel is; fixed for a decoder's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelConfig {
    /// Tooth pitches in a turn, missing ones included (60 for a 60-2 wheel).
    pub teeth: u32,
    /// Missing teeth, 0 for none; one gap.
    pub missing: u16,
    /// Whether both edges of a tooth count; otherwise every sample whose level A is high is a pulse.
    pub both_edges: bool,
    /// A pitch shorter than the one before times 2^-gate is a glitch; 2 to 31.
    pub glitch_gate: u32,
}

impl WheelConfig {
    /// A wheel seen as pulses, all teeth there.
    #[must_use]
    pub const fn new(teeth: u32) -> Self {
        Self {
            teeth,
            missing: 0,
            both_edges: false,
            glitch_gate: 3,
        }
    }

    /// The count of slots of this wheel, at slot 0.
    ///
    /// # Errors
    /// [`SensorError`] for a wheel that can't be.
    pub(super) const fn counter(&self) -> Result<Counter, SensorError> {
        if self.glitch_gate < 2 || self.glitch_gate > 31 {
            return Err(SensorError::Gate);
        }
        if self.teeth > MAX_SLOTS / 2 {
            return Err(SensorError::Slots);
        }
        let missing = self.missing as u32;
        if missing > 0 && (self.teeth < missing * 2 || self.teeth < missing + 4) {
            return Err(SensorError::Missing);
        }
        let slots = if self.both_edges {
            self.teeth * 2
        } else {
            self.teeth
        };
        Counter::new(slots)
    }
}
