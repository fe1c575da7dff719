//! An encoder in front of a timer: an even shaft, edges a little out of place.

use quadcal::edge::{Levels, Sample};

/// Grating lines.
pub const LINES: u32 = 2500;

/// Edges a turn.
pub const SLOTS: u32 = 4 * LINES;

/// Edges made at a time; a turn is a whole number of blocks.
pub const BLOCK: usize = 125;

/// Levels after edge 0, 1, 2, 3.
const STATES: [u8; 4] = [1, 3, 2, 0];

/// Ticks from edge to edge on the grid: 600 r/min at 84 MHz.
const STEP: u64 = 840;

/// Sample to fill memory with before there is one.
pub const NO_SAMPLE: Sample = Sample {
    ticks: 0,
    levels: Levels(0),
};

/// Makes the samples of an encoder that turns forward.
pub struct Rig {
    slot: u32,
    grid: u64,
    random: u32,
}

impl Rig {
    /// Before the first edge.
    pub const fn new() -> Self {
        Self {
            slot: SLOTS / 2,
            grid: 1 << 33,
            random: 1,
        }
    }

    /// The next block of edges.
    pub fn fill(&mut self, samples: &mut [Sample]) {
        for sample in samples {
            self.slot = if self.slot + 1 == SLOTS {
                0
            } else {
                self.slot + 1
            };
            self.grid += STEP;
            self.random = self
                .random
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            let z = if self.slot == 0 { Levels::Z } else { 0 };
            *sample = Sample {
                ticks: self.grid + u64::from(((self.random >> 16) * 100) >> 16),
                levels: Levels(STATES[(self.slot % 4) as usize] | z),
            };
        }
    }

    /// Turns round after every ten edges instead.
    pub fn swing(&mut self, samples: &mut [Sample]) {
        for sample in samples {
            self.grid += STEP;
            self.slot = (self.slot + 1) % 20;
            let place = self.slot.min(20 - self.slot);
            *sample = Sample {
                ticks: self.grid,
                levels: Levels(STATES[(place % 4) as usize]),
            };
        }
    }
}
