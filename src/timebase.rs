//! Extends 16- and 32-bit timer captures to 64-bit ticks, right at the overflow.
//!
//! # The race
//! The hardware latches the counter at an edge; the interrupt that reads the latch runs later. The counter may wrap in
//! between, and the interrupt that counts wraps may run before the capture's or after it. With P the period, four
//! orders are possible around a wrap:
//!
//! | capture | wrap interrupt | seen by the capture's interrupt | the capture belongs to |
//! |---|---|---|---|
//! | before the wrap | not yet served | flag set, raw near P | the counted period |
//! | after the wrap | not yet served | flag set, raw near 0 | the next period |
//! | before the wrap | already served | flag clear, raw near P | **the period before** |
//! | after the wrap | already served | flag clear, raw near 0 | the counted period |
//!
//! The flag and the upper bit of the capture tell the first two apart. The third looks exactly like a capture made late
//! in the counted period, so flag and raw value alone cannot settle it. [`Timebase::capture`] therefore also takes the
//! counter's present value: the flag settles *now* (which has no latency of its own), and the capture is as old as the
//! counter says. Where one handler serves both and always looks at captures first, the third row cannot happen, and
//! [`Timebase::capture_first`] does without the second read.
//!
//! # Contract
//! - Wraps are served, each once, less than half a period after they happen.
//! - The age of a capture is below one period ([`Timebase::capture`]) or half a period ([`Timebase::capture_first`]).
//! - The counter is read *before* the flag. A wrap in between then shows as a flag with a value near P, which is right;
//!   in the other order it would show as no flag with a value near 0, one period too early.

use crate::units::Ticks;

/// Extends captures of a timer of `BITS` bits (1 to 32) that counts up and wraps at 2^`BITS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timebase<const BITS: u32> {
    /// Start of the counted period, ticks.
    period_start: Ticks,
}

/// Time base of a 16-bit timer.
pub type Timebase16 = Timebase<16>;

/// Time base of a 32-bit timer.
pub type Timebase32 = Timebase<32>;

impl<const BITS: u32> Timebase<BITS> {
    const PERIOD: Ticks = {
        assert!(BITS >= 1 && BITS <= 32, "a timer has 1 to 32 bits");
        1 << BITS
    };
    const MASK: u32 = (Self::PERIOD - 1) as u32;
    const HALF: u32 = (Self::PERIOD / 2) as u32;

    /// A time base in the timer's first period.
    #[must_use]
    pub const fn new() -> Self {
        Self { period_start: 0 }
    }

    /// Counts one wrap; call from the overflow interrupt, together with clearing its flag.
    #[inline]
    pub const fn overflow(&mut self) {
        self.period_start = self.period_start.wrapping_add(Self::PERIOD);
    }

    /// Time of the counter value `counter`, read just before the overflow flag `overflow_pending`.
    #[inline]
    #[must_use]
    pub const fn now(&self, counter: u32, overflow_pending: bool) -> Ticks {
        let counter = counter & Self::MASK;
        let start = if overflow_pending && counter < Self::HALF {
            self.period_start.wrapping_add(Self::PERIOD)
        } else {
            self.period_start
        };
        start.wrapping_add(counter as Ticks)
    }

    /// Time of the capture `raw`, given the counter read after the capture and the overflow flag read after the
    /// counter. Right in whatever order captures and wraps are served.
    #[inline]
    #[must_use]
    pub const fn capture(&self, raw: u32, counter: u32, overflow_pending: bool) -> Ticks {
        let age = counter.wrapping_sub(raw) & Self::MASK;
        self.now(counter, overflow_pending)
            .wrapping_sub(age as Ticks)
    }

    /// Time of the capture `raw` in a handler that always serves captures before the wrap of the same interrupt.
    #[inline]
    #[must_use]
    pub const fn capture_first(&self, raw: u32, overflow_pending: bool) -> Ticks {
        self.now(raw, overflow_pending)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const P: u64 = 1 << 16;

    #[test]
    fn the_four_orders_around_a_wrap_are_told_apart() {
        let mut base = Timebase16::new();
        assert_eq!(base.capture(0xFFFF, 0x0003, true), 0xFFFF);
        assert_eq!(base.capture(0x0000, 0x0003, true), P);
        base.overflow();
        assert_eq!(base.capture(0xFFFF, 0x0003, false), 0xFFFF);
        assert_eq!(base.capture(0x0000, 0x0003, false), P);
        assert_eq!(base.capture(0xFFFF, 0xFFFF, false), 2 * P - 1);
    }

    #[test]
    fn a_wrap_between_the_reads_of_counter_and_flag_does_no_harm() {
        let base = Timebase16::new();
        assert_eq!(base.capture(0xFFF0, 0xFFFF, true), 0xFFF0);
        assert_eq!(base.capture_first(0x7FFF, true), P + 0x7FFF);
        assert_eq!(base.capture_first(0x8000, true), 0x8000);
    }

    #[test]
    fn thirty_two_bits_wrap_at_their_own_period() {
        let mut base = Timebase32::new();
        assert_eq!(base.capture(u32::MAX, 1, true), u64::from(u32::MAX));
        assert_eq!(base.capture(0, 1, true), 1 << 32);
        base.overflow();
        assert_eq!(base.capture(5, 9, false), (1 << 32) + 5);
        assert_eq!(base.capture_first(u32::MAX, false), (1 << 33) - 1);
    }

    /// A capture: time, and latency of its interrupt in units of 1/1024 of half a period.
    type Event = (u64, u64);

    fn events() -> impl Strategy<Value = Vec<Event>> {
        let gap = prop_oneof![4 => 1u64..2000, 2 => 1u64..(1 << 15), 1 => 1u64..(1 << 18)];
        prop::collection::vec((gap, 0u64..1024), 1..300)
    }

    /// Runs the events against a 64-bit model and yields (true time, extended time) pairs. Wrap number `n` is served
    /// `wrap_latency(n)` ticks late.
    fn served<const BITS: u32>(events: &[Event], seed: u64, shared: bool) -> Vec<(u64, u64)> {
        let period = 1u64 << BITS;
        let half = period / 2;
        let scale = period / P;
        let wrap_latency = |n: u64| (n.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ seed) % half;
        let mut time = 0;
        let mut captures: Vec<(u64, u64)> = events
            .iter()
            .map(|&(gap, latency)| {
                time += gap * scale + latency;
                (time + latency * (half / 1024), time)
            })
            .collect();
        captures.sort_unstable();
        let mut base = Timebase::<BITS>::new();
        let mut wraps = 0;
        let mut pairs = Vec::new();
        for (at, time) in captures {
            // A shared handler is entered for whichever is due, and looks at captures first.
            loop {
                let due = (wraps + 1) * period + wrap_latency(wraps + 1);
                if due < at || (due == at && !shared) {
                    base.overflow();
                    wraps += 1;
                } else {
                    break;
                }
            }
            let pending = at >= (wraps + 1) * period;
            let raw = (time % period) as u32;
            let counter = (at % period) as u32;
            pairs.push((time, base.capture(raw, counter, pending)));
        }
        pairs
    }

    proptest! {
        #[test]
        fn captures_agree_with_a_64_bit_timer_in_any_service_order(events in events(), seed: u64, shared: bool) {
            for (time, extended) in served::<16>(&events, seed, shared) {
                prop_assert_eq!(time, extended);
            }
            for (time, extended) in served::<32>(&events, seed, shared) {
                prop_assert_eq!(time, extended);
            }
        }

        #[test]
        fn one_handler_that_serves_captures_first_needs_no_counter(events in events(), delay in 0u64..(1 << 15)) {
            let mut base = Timebase16::new();
            let mut time = 0u64;
            let mut wraps = 0u64;
            for (gap, extra) in events {
                time += gap;
                let capture = time;
                time += extra.min(delay);
                // Wraps older than the capture are served at the latest by the handler's previous run.
                while capture.saturating_sub((wraps + 1) * P) >= delay && capture >= (wraps + 1) * P {
                    base.overflow();
                    wraps += 1;
                }
                let pending = time >= (wraps + 1) * P;
                prop_assert_eq!(base.capture_first((capture % P) as u32, pending), capture);
                if pending {
                    base.overflow();
                    wraps += 1;
                }
            }
        }
    }
}
