//! What the supply voltage decides.

use super::interface::control;

/// Supply voltage of the chip, which decides how many bits are written at once and how long an erasure takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Supply {
    /// 1.8 to 2.1 V: 8 bits.
    From1V8,
    /// 2.1 to 2.7 V: 16 bits.
    From2V1,
    /// 2.7 to 3.6 V: 32 bits.
    From2V7,
}

impl Supply {
    /// `PSIZE`, in place in the control register; an erasure needs it too.
    pub(super) const fn parallelism(self) -> u32 {
        (self as u32) << control::PSIZE_AT
    }

    /// Longest that a sector's erasure may take, milliseconds (data sheet DS8626, "Flash memory programming").
    pub(super) const fn erase_ms(self, sector: u32) -> u32 {
        let [x8, x16, x32] = match sector {
            0..4 => [800, 600, 500],
            4 => [2400, 1400, 1100],
            _ => [4000, 2600, 2000],
        };
        match self {
            Self::From1V8 => x8,
            Self::From2V1 => x16,
            Self::From2V7 => x32,
        }
    }
}
