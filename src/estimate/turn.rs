//! One turn as it comes in: intervals scaled to step fractions and written to the turn's cells.

use super::Rejection;
use super::low::LowOrders;
use crate::edge::Direction;
use crate::recip::Recip;
use crate::step::Step;
use crate::units::{STEP_FRACTION_BITS, Ticks};

/// Step fractions per tick as `multiplier * 2^-shift`, from the duration of one whole turn.
#[derive(Clone, Copy)]
pub(super) struct TurnRate {
    multiplier: u32,
    shift: u32,
}

impl TurnRate {
    /// The rate at which a turn of `duration` ticks has `edges` steps; `None` for a turn shorter than one tick an edge
    /// or longer than 2^44 ticks.
    pub(super) fn of(duration: u64, edges: u32) -> Option<Self> {
        if duration < u64::from(edges) || duration >> 44 != 0 {
            return None;
        }
        let edge_bits = u32::BITS - (edges - 1).leading_zeros();
        // As many fraction bits as keep the multiplier in 31 bits and a turn and a half of phase in 64.
        let precise =
            (31 + duration.checked_ilog2()?).saturating_sub(edge_bits + STEP_FRACTION_BITS);
        let shift = precise.min(62 - STEP_FRACTION_BITS - edge_bits);
        let multiplier =
            Recip::of_u64(duration).times(u64::from(edges) << (STEP_FRACTION_BITS + shift));
        Some(Self {
            multiplier: u32::try_from(multiplier).ok()?,
            shift,
        })
    }

    /// Step fractions in `interval` ticks, Q32. Digits above 64 bits are lost.
    fn times(self, interval: u32) -> u64 {
        let product = u64::from(interval) * u64::from(self.multiplier);
        if self.shift <= 32 {
            product << (32 - self.shift)
        } else {
            product >> (self.shift - 32)
        }
    }

    /// Whole step fractions in a turn's `duration`.
    #[allow(clippy::cast_possible_truncation)]
    fn whole(self, duration: u64) -> u32 {
        (duration.wrapping_mul(u64::from(self.multiplier)) >> self.shift) as u32
    }

    /// Step fractions a tick, Q32; `None` where 32 digits are too few: intervals beyond 2^16 ticks.
    pub(super) fn per_tick_q32(self) -> Option<u64> {
        let places = 32_u32.checked_sub(self.shift)?;
        Some(u64::from(self.multiplier) << places)
    }
}

/// The turn that is coming in.
pub(super) struct Turn {
    pub direction: Direction,
    pub rate: Option<TurnRate>,
    start: Ticks,
    pub edge: u32,
    /// Step fractions since the start, Q32.
    pub phase_q32: u64,
    pub jitter: Jitter,
    pub sample: Sampling,
    irregular: bool,
}

/// How the deviations of this turn differ from those of the turn before, from edge to edge: second differences, which a
/// smooth motion does not make.
#[derive(Clone, Copy)]
pub(super) struct Jitter {
    last: i32,
    pub squares: u64,
}

impl Jitter {
    pub const NONE: Self = Self {
        last: 0,
        squares: 0,
    };

    /// Takes the deviations of one interval in both turns.
    #[inline]
    pub fn take(&mut self, new: i16, old: i16) {
        let change = i32::from(new) - i32::from(old);
        let bend = i64::from(change - self.last);
        self.last = change;
        self.squares = self.squares.wrapping_add((bend * bend).cast_unsigned());
    }
}

/// Counts edges up to the next sample for the [`LowOrders`].
#[derive(Clone, Copy)]
pub(super) struct Sampling {
    /// Edges of a block.
    pub size: u32,
    /// Edges until the next sample.
    pub left: u32,
    /// Step fractions from the start to the next sample on a perfect grid.
    pub grid: u32,
}

impl Sampling {
    fn start(size: u32) -> Self {
        Self {
            size,
            left: size,
            grid: size << STEP_FRACTION_BITS,
        }
    }

    /// Goes on by one edge; true where a block ends.
    #[inline]
    pub fn advance(&mut self) -> bool {
        self.left -= 1;
        self.left == 0
    }

    /// Samples at a block's end, `reached` step fractions from the start.
    #[inline(never)]
    pub fn sample(&mut self, reached: u32, low: &mut LowOrders) {
        low.take(reached.wrapping_sub(self.grid).cast_signed());
        self.left = self.size;
        self.grid = self.grid.wrapping_add(self.size << STEP_FRACTION_BITS);
    }
}

impl Turn {
    /// Starts at the crossing of edge 0. `dither` is a fraction of one step fraction (Q32) that differs from turn to
    /// turn, so that rounding averages out even when turns repeat to the tick.
    pub(super) fn start(step: &Step, rate: Option<TurnRate>, dither: u32, block: u32) -> Self {
        Self {
            direction: step.direction,
            rate,
            start: step.ticks,
            edge: step.edge,
            phase_q32: u64::from(dither),
            jitter: Jitter::NONE,
            sample: Sampling::start(block),
            irregular: false,
        }
    }

    pub(super) fn duration(&self, now: Ticks) -> u64 {
        now.wrapping_sub(self.start)
    }

    /// Length of the whole turn in step fractions at the rate of the turn before.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn whole(&self) -> u32 {
        (self.phase_q32 >> 32) as u32
    }

    /// Whether the intervals do not add up to the turn: decoders give none where time runs backward.
    fn ran_backward(&self, now: Ticks) -> bool {
        self.rate.is_some_and(|rate| {
            // One for the dither and one for digits cut off.
            let excess = self.whole().wrapping_sub(rate.whole(self.duration(now)));
            excess.wrapping_add(2) > 4
        })
    }

    /// Adds one crossing; `Ok(true)` when it ends the turn.
    pub(super) fn extend(
        &mut self,
        step: &Step,
        edges: u32,
        cells: &mut [i16],
        low: &mut LowOrders,
    ) -> Result<bool, Rejection> {
        let advance = u32::from(step.advance);
        let forward = self.direction == Direction::Forward;
        let mut slot = self.edge;
        let expected = wrapped(self.edge, advance, edges, forward);
        if step.direction != self.direction || step.edge != expected || advance == 0 {
            return Err(Rejection::Broken);
        }
        self.edge = expected;
        if let Some(rate) = self.rate {
            let interval = step.interval;
            if interval == u32::MAX {
                return Err(Rejection::Irregular);
            }
            let before = self.whole();
            self.phase_q32 = self.phase_q32.wrapping_add(rate.times(interval));
            let moved = self.whole().wrapping_sub(before);
            let deviation = moved
                .wrapping_sub(advance << STEP_FRACTION_BITS)
                .cast_signed();
            let entry = i16::try_from(deviation).unwrap_or_else(|_| {
                self.irregular = true;
                0
            });
            // The interval between edges k-1 and k has slot k in either direction.
            for passed in 1..=advance {
                if forward {
                    slot = wrapped(slot, 1, edges, true);
                }
                let last = passed == advance;
                if let Some(cell) = cells.get_mut(slot as usize) {
                    let new = if last { entry } else { 0 };
                    self.jitter.take(new, *cell);
                    *cell = new;
                }
                if self.sample.advance() {
                    let on_grid = before.wrapping_add(passed << STEP_FRACTION_BITS);
                    let reached = if last { self.whole() } else { on_grid };
                    self.sample.sample(reached, low);
                }
                if !forward {
                    slot = wrapped(slot, 1, edges, false);
                }
            }
        }
        if expected != 0 {
            // The first interval has none before it to differ from.
            if wrapped(expected, advance, edges, !forward) == 0 {
                self.jitter.squares = 0;
            }
            return Ok(false);
        }
        if self.irregular || self.ran_backward(step.ticks) {
            Err(Rejection::Irregular)
        } else {
            Ok(true)
        }
    }
}

/// `edge` moved by `by` steps, modulo `edges`.
#[inline]
pub(super) fn wrapped(edge: u32, by: u32, edges: u32, forward: bool) -> u32 {
    if forward {
        let moved = edge + by;
        if moved >= edges { moved - edges } else { moved }
    } else if edge >= by {
        edge - by
    } else {
        edge + edges - by
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_turns_its_own_duration_into_one_turn() {
        for edges in [3_u32, 12, 90, 240, 4096, 10_000, 65_536] {
            for duration in [
                65_536_u64,
                100_000,
                336_000_000,
                3_360_000_001,
                1 << 40,
                (1 << 44) - 1,
            ] {
                let rate = TurnRate::of(duration, edges).unwrap();
                let grid = f64::from(edges) * 32768.0;
                let length =
                    ((u128::from(duration) * u128::from(rate.multiplier)) >> rate.shift) as f64;
                assert!(
                    (length / grid - 1.0).abs() < 3e-5,
                    "{edges} {duration} {length} {grid}"
                );
                assert!((u128::from(duration) * u128::from(rate.multiplier)) >> 63 == 0);
            }
        }
    }

    #[test]
    fn slots_wrap_in_both_directions() {
        assert_eq!(wrapped(9, 1, 10, true), 0);
        assert_eq!(wrapped(0, 1, 10, false), 9);
        assert_eq!(wrapped(1, 3, 10, false), 8);
    }
}
