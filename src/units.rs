//! Every scale constant: angles as fractions of a turn, time as timer ticks and their fractions, and the estimator's step fraction.

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

/// Signed time in 2^-8 of a timer tick, range plus or minus 2^23 ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TickDelta8(pub i32);

/// Binary digits of a [`TickDelta8`] below one tick.
pub const TICK_FRACTION_BITS: u32 = 8;

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

impl TickDelta8 {
    /// No time.
    pub const ZERO: Self = Self(0);

    /// This time less `other`, within the range.
    #[inline]
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }

    /// The same time in ticks of another clock, to the nearest 2^-8 tick. None where it does not fit, or from a clock of 0 Hz.
    /// Divides, so not for the edge path.
    #[must_use]
    pub fn at_clock(self, from_hz: u64, to_hz: u64) -> Option<Self> {
        if from_hz == to_hz || self.0 == 0 {
            return Some(self);
        }
        self.scaled(from_hz, to_hz)
    }

    /// Not inlined: the compiler would write its 128-bit arithmetic down once for every class.
    #[inline(never)]
    fn scaled(self, from_hz: u64, to_hz: u64) -> Option<Self> {
        let size = u128::from(self.0.unsigned_abs()) * u128::from(to_hz);
        let nearest = (size + u128::from(from_hz / 2)).checked_div(u128::from(from_hz))?;
        let size = i32::try_from(nearest).ok()?;
        Some(Self(if self.0 < 0 { -size } else { size }))
    }

    /// In seconds at a tick rate of `clock_hz`. For reports only.
    #[must_use]
    pub fn seconds(self, clock_hz: f64) -> f64 {
        f64::from(self.0) / f64::from(1u32 << TICK_FRACTION_BITS) / clock_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_the_same_time_at_every_clock() {
        // 100 ns: 8.4 ticks of 84 MHz, 0.003 ticks of 30 kHz.
        let delay = TickDelta8(2150);
        assert_eq!(
            delay.at_clock(84_000_000, 168_000_000),
            Some(TickDelta8(4300))
        );
        assert_eq!(
            TickDelta8(-2151).at_clock(84_000_000, 42_000_000),
            Some(TickDelta8(-1076))
        );
        assert_eq!(delay.at_clock(84_000_000, 30_000), Some(TickDelta8(1)));
        assert!((delay.seconds(84e6) - 99.98e-9).abs() < 1e-11);
        assert_eq!(delay.at_clock(1, u64::MAX), None);
        assert_eq!(delay.at_clock(0, 84_000_000), None);
        assert_eq!(
            TickDelta8::ZERO.at_clock(0, 84_000_000),
            Some(TickDelta8::ZERO)
        );
    }

    #[test]
    fn difference_takes_the_shortest_way_across_zero() {
        assert_eq!(Turn32(3).minus(Turn32(u32::MAX)), TurnDelta32(4));
        assert_eq!(Turn32(u32::MAX).plus(TurnDelta32(4)), Turn32(3));
    }
}
