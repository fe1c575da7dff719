//! Times of a VCD as ticks.

use super::NANOSECOND_HZ;

/// Units a second in the finest timescale there is, femtoseconds.
const FINEST: u32 = 15;

/// Turns times of a VCD into ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Timescale {
    /// Ticks a second.
    clock_hz: u64,
    /// A time in units of the file is multiplied by this ...
    multiplier: u64,
    /// ... and divided by this, to the nearest tick.
    divisor: u64,
}

impl Timescale {
    /// From a `$timescale` of `quantity` units, `units_hz` of which make a second. Ticks are these, but nanoseconds where these are
    /// finer and whole seconds where these are coarser. None where `quantity` is not 1, 10 or 100.
    pub fn new(quantity: u32, units_hz: u64) -> Option<Self> {
        if !matches!(quantity, 1 | 10 | 100) {
            return None;
        }
        let quantity = u64::from(quantity);
        let clock_hz = (units_hz / quantity).clamp(1, NANOSECOND_HZ);
        Some(Self::with_clock(quantity, units_hz, clock_hz))
    }

    fn with_clock(quantity: u64, units_hz: u64, clock_hz: u64) -> Self {
        let common = gcd(units_hz, quantity);
        let (up, down) = (quantity / common, units_hz / common);
        let common = gcd(down, clock_hz);
        Self {
            clock_hz,
            multiplier: (clock_hz / common).saturating_mul(up),
            divisor: down / common,
        }
    }

    /// The same times counted by another clock, from which the file was written; none where they are too coarse to give its ticks
    /// back.
    pub fn recounted(quantity: u32, units_hz: u64, clock_hz: u64) -> Option<Self> {
        let fine_enough = units_hz / u64::from(quantity.max(1)) >= clock_hz;
        (clock_hz > 0 && fine_enough).then(|| Self::with_clock(quantity.into(), units_hz, clock_hz))
    }

    /// Ticks a second.
    pub fn clock_hz(self) -> u64 {
        self.clock_hz
    }

    /// Nearest tick to a time of the file; none past the range of 64 bits.
    pub fn ticks(self, time: u64) -> Option<u64> {
        let scaled = u128::from(time) * u128::from(self.multiplier);
        let divisor = u128::from(self.divisor);
        u64::try_from((scaled + divisor / 2) / divisor).ok()
    }
}

/// Power of ten of the units a second in which ticks of `clock_hz` are written: the clock itself where it is such a power, else at
/// least a thousand units a tick, so that rounding neither shows in a viewer nor keeps the ticks from coming back. None where
/// femtoseconds are too coarse.
pub(super) fn writing_exponent(clock_hz: u64) -> Option<u32> {
    let exact = (0..=FINEST).find(|&n| 10u64.pow(n) == clock_hz);
    exact
        .or_else(|| (0..=FINEST).find(|&n| 10u64.pow(n) / 1000 >= clock_hz))
        .or_else(|| (0..=FINEST).find(|&n| 10u64.pow(n) / 2 >= clock_hz))
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PS: u64 = 1_000_000_000_000;

    #[test]
    fn ticks_are_the_timescale_but_no_finer_than_nanoseconds() {
        let cases = [
            (1, NANOSECOND_HZ, NANOSECOND_HZ, 7, 7),
            (10, NANOSECOND_HZ, 100_000_000, 7, 7),
            (100, 1_000_000, 10_000, 7, 7),
            (1, PS, NANOSECOND_HZ, 1499, 1),
            (1, PS, NANOSECOND_HZ, 1500, 2),
            (100, PS, NANOSECOND_HZ, 15, 2),
            (10, 1, 1, 7, 70),
        ];
        for (quantity, units_hz, clock_hz, time, ticks) in cases {
            let scale = Timescale::new(quantity, units_hz).unwrap();
            assert_eq!(scale.clock_hz(), clock_hz);
            assert_eq!(
                scale.ticks(time),
                Some(ticks),
                "{quantity} of {units_hz}: {time}"
            );
        }
        assert_eq!(Timescale::new(0, PS), None);
        assert_eq!(Timescale::new(25, PS), None);
    }

    #[test]
    fn times_past_64_bits_are_refused() {
        assert_eq!(Timescale::new(100, 1).unwrap().ticks(u64::MAX), None);
        assert_eq!(
            Timescale::new(1, NANOSECOND_HZ).unwrap().ticks(u64::MAX),
            Some(u64::MAX)
        );
    }

    #[test]
    fn a_clock_coarser_than_the_units_is_got_back_exactly() {
        let scale = Timescale::recounted(10, PS, 84_000_000).unwrap();
        for ticks in [0u64, 1, 83_999_999, 123_456_789_012] {
            let units = (u128::from(ticks) * 100_000_000_000 + 42_000_000) / 84_000_000;
            assert_eq!(scale.ticks(units as u64), Some(ticks));
        }
        assert_eq!(Timescale::recounted(1, 1_000_000, 84_000_000), None);
    }

    #[test]
    fn clocks_are_written_exactly_or_a_thousandfold() {
        assert_eq!(writing_exponent(1_000_000), Some(6));
        assert_eq!(writing_exponent(84_000_000), Some(11));
        assert_eq!(writing_exponent(30_000), Some(8));
        assert_eq!(writing_exponent(400_000_000_000_000), Some(15));
        assert_eq!(writing_exponent(u64::MAX), None);
    }
}
