//! Every scale constant: angles as fractions of a turn, time as timer ticks, and the estimator's step fraction.

/// Absolute shaft angle modulo one turn, one turn = 2^32 (1 LSB = 1.463e-9 rad).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Turn32(pub u32);

/// Signed angle difference or error in units of 2^-32 turn, range plus or minus half a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TurnDelta32(pub i32);

/// Time in timer ticks since start, extended to 64 bits; the tick rate is the recording's or timer's `clock_hz`.
pub type Ticks = u64;

/// Radians in one LSB of [`Turn32`]: 2 pi / 2^32. For reports only; the core never computes in radians.
pub const RAD_PER_TURN32: f64 = core::f64::consts::TAU / 4_294_967_296.0;

/// Binary digits of the estimator's step fraction: one edge step of the grid is `1 << STEP_FRACTION_BITS`.
pub const STEP_FRACTION_BITS: u32 = 15;

impl Turn32 {
    /// This angle moved by `delta`, modulo one turn.
    #[inline]
    #[must_use]
    pub const fn plus(self, delta: TurnDelta32) -> Self {
        Self(self.0.wrapping_add_signed(delta.0))
    }

    /// Signed shortest way from `other` to this angle.
    #[inline]
    #[must_use]
    pub const fn minus(self, other: Self) -> TurnDelta32 {
        TurnDelta32(self.0.wrapping_sub(other.0).cast_signed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_takes_the_shortest_way_across_zero() {
        assert_eq!(Turn32(3).minus(Turn32(u32::MAX)), TurnDelta32(4));
        assert_eq!(Turn32(u32::MAX).plus(TurnDelta32(4)), Turn32(3));
    }
}
