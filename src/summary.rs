//! A calibration in the words of a log: microradians and decibels, for people.
//!
//! Single precision and `micromath`'s approximations (its square root is up to 6 % off) do here; nothing measures with them.

use core::fmt;

use micromath::F32Ext;

use crate::estimate::{EdgeBuffers, Solution};
use crate::units::RAD_PER_TURN32;

/// What a calibration found, rounded for people.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Summary {
    /// Error RMS that the table takes away, microradians.
    pub before_urad: f32,
    /// Error RMS to expect after correction, class means and lines together, microradians.
    pub after_urad: f32,
    /// Turns learned from.
    pub turns: u32,
}

impl Summary {
    /// Of a solved calibration.
    #[must_use]
    pub fn of<B: EdgeBuffers>(solution: &Solution<B>) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
        let urad = |turn32: u32| turn32 as f32 * (RAD_PER_TURN32 * 1e6) as f32;
        let (line, class) = (
            urad(solution.standard_error()),
            urad(solution.class_standard_error()),
        );
        Self {
            before_urad: urad(solution.table_rms()),
            after_urad: (line * line + class * class).sqrt(),
            turns: solution.turns(),
        }
    }

    /// How much smaller the error is to be expected, dB; none for a table that says nothing.
    #[must_use]
    pub fn gain_db(&self) -> Option<f32> {
        let known = self.before_urad > 0.0 && self.after_urad > 0.0;
        known.then(|| 20.0 * (self.before_urad / self.after_urad).log10())
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.1} urad before, {:.1} urad expected after {} turns",
            self.before_urad, self.after_urad, self.turns
        )?;
        self.gain_db()
            .map_or(Ok(()), |gain| write!(f, " ({gain:.0} dB)"))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_summary_reads_as_a_line_of_a_log() {
        let summary = Summary {
            before_urad: 92.3,
            after_urad: 2.93,
            turns: 11,
        };
        assert_eq!(
            summary.to_string(),
            "92.3 urad before, 2.9 urad expected after 11 turns (30 dB)"
        );
        let nothing = Summary {
            before_urad: 0.0,
            ..summary
        };
        assert_eq!(
            nothing.to_string(),
            "0.0 urad before, 2.9 urad expected after 11 turns"
        );
    }
}
