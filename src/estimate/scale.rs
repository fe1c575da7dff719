//! From summed step fractions to angle.

use super::close::saturated;
use crate::units::STEP_FRACTION_BITS;

/// From summed step fractions to 2^-32 turn: 2^32 over the summed length of all turns.
#[derive(Clone, Copy)]
pub(super) struct AngleScale {
    multiplier: i64,
    shift: u32,
}

impl AngleScale {
    /// `turns` is the length of all turns together in step fractions, at least one step.
    pub(super) fn new(turns: i64) -> Self {
        let turns = turns.max(1 << STEP_FRACTION_BITS);
        let size = turns.ilog2();
        // 2^29..=2^30, so that the product with 32 bits fits 63.
        let multiplier = (1_i128 << (size + 30)) / i128::from(turns);
        #[allow(clippy::cast_possible_truncation)]
        Self {
            multiplier: multiplier as i64,
            shift: size - 2,
        }
    }

    pub(super) fn angle(self, value: i32) -> i32 {
        saturated((i64::from(value) * self.multiplier + (1 << self.shift >> 1)) >> self.shift)
    }

    /// Root of a mean square given in 2^-16 of the squared sum unit, as an angle.
    pub(super) fn root_mean_square(self, power: u64) -> u32 {
        let root_q8 = i32::try_from(power.isqrt()).unwrap_or(i32::MAX);
        self.angle(root_q8).unsigned_abs() >> 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_a_turn_becomes_its_share_of_a_turn() {
        for (turns, edges) in [(2_i64, 12_i64), (11, 10_000), (1195, 12), (30_000, 65_536)] {
            let scale = AngleScale::new((turns * edges) << STEP_FRACTION_BITS);
            let step = (turns as i32) << STEP_FRACTION_BITS;
            let exact = 4_294_967_296.0 / edges as f64;
            assert!(
                (f64::from(scale.angle(step)) / exact - 1.0).abs() < 1e-8 + 0.5 / exact,
                "{turns} {edges}"
            );
        }
    }
}
