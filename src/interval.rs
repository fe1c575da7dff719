//! Speed from edge times (T-method), equations (2) and (3).
//!
//! At x4 every edge is held against the one before (pi/2M in the paper's terms), at x2 against the edge before that, which is
//! of the same channel, so that the quadrature error drops out. Known edge errors correct the angle: the shaft moved by the
//! grid step less the difference of the two edges' errors.
//!
//! # Units and error
//! [`Speed`] is i64 in 2^-60 turn a tick. At 84 MHz 15 r/min is 3.43e9 LSB and 6000 r/min 1.37e12, a ten-millionth of
//! the range. The quotient is below the exact one by at most 2^-29 of it ([`Recip::ERROR`]) plus 1 LSB; the grid step is short by
//! less than 1 LSB. One tick of the capture is 2.98e-5 of an interval at 15 r/min and N = 10000: the arithmetic adds
//! nothing.
//!
//! One edge at x4 takes 99 instructions, 45 of them the reciprocal (Cortex-M4, opt-level 3, counted in QEMU netduinoplus2
//! with icount).
//!
//! # Stopping
//! Between edges the shaft can't have moved further than one grid step, so the speed's size is at most a step over
//! the time since the last edge; after the timeout it is 0.

use crate::edge::Direction;
use crate::recip::Recip;
use crate::step::{Flags, Step};
use crate::units::{Ticks, TurnDelta32};

/// Binary digits of a speed below one turn a tick.
pub const SPEED_FRACTION_BITS: u32 = 60;

/// Instantaneous angular speed in 2^-60 turn a tick, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Speed(pub i64);

impl Speed {
    /// Standing still.
    pub const ZERO: Self = Self(0);

    /// Mean speed over `angle` (2^-60 turn) in `ticks`; 0 ticks count as 1.
    #[inline]
    #[must_use]
    pub const fn over(angle: i64, ticks: u32) -> Self {
        Self(Recip::of_u32(ticks).times_signed(angle))
    }

    /// Revolutions a minute at a tick rate of `clock_hz`. For reports only.
    #[must_use]
    pub fn rpm(self, clock_hz: f64) -> f64 {
        self.0 as f64 / (1u64 << SPEED_FRACTION_BITS) as f64 * clock_hz * 60.0
    }
}

/// Geometry and timeout; fixed for a sensor's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IntervalConfig {
    /// Grid step between neighbouring edges in 2^-60 turn.
    step: i64,
    timeout: Ticks,
}

impl IntervalConfig {
    /// For `slots` edges a turn (0 counts as 1) and a shaft that stands still after `timeout` ticks without an edge.
    #[must_use]
    pub const fn new(slots: u32, timeout: Ticks) -> Self {
        let slots = if slots == 0 { 1 } else { slots };
        Self {
            step: (1 << SPEED_FRACTION_BITS) / slots as i64,
            timeout,
        }
    }
}

/// One accepted interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Passed {
    /// Duration, `u32::MAX` if unknown.
    ticks: u32,
    /// Single edge step without a reversal.
    plain: bool,
    speed: Speed,
}

const UNKNOWN: Passed = Passed {
    ticks: u32::MAX,
    plain: false,
    speed: Speed::ZERO,
};

/// T-method state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interval {
    config: IntervalConfig,
    last: Ticks,
    direction: Direction,
    newest: Passed,
    /// The one before, to come back to when a step is withdrawn.
    older: Passed,
}

impl Interval {
    /// No edge seen.
    #[must_use]
    pub const fn new(config: IntervalConfig) -> Self {
        Self {
            config,
            last: 0,
            direction: Direction::Forward,
            newest: UNKNOWN,
            older: UNKNOWN,
        }
    }

    /// Takes an accepted step and returns its speed at x4, the mean over the last interval; none at the first edge or over an
    /// interval that is too long. A reversal crosses the same edge twice, so the speed over it is 0.
    ///
    /// `correction` is e(this edge) - e(previous edge), 0 without a table.
    #[inline]
    pub fn push(&mut self, step: &Step, correction: TurnDelta32) -> Option<Speed> {
        let forward = matches!(step.direction, Direction::Forward);
        let reversed = step.flags.contains(Flags::REVERSED);
        let grid = self.config.step;
        let plain = step.advance == 1 && !reversed;
        let moved = if plain {
            grid
        } else {
            let steps = i64::from(step.advance) - i64::from(reversed);
            grid.wrapping_mul(steps)
        };
        let moved = if forward { moved } else { -moved };
        let known = step.interval != u32::MAX;
        let speed = if known && !(reversed && step.advance == 1) {
            Speed::over(moved.wrapping_sub(widen(correction)), step.interval)
        } else {
            Speed::ZERO
        };
        self.last = step.ticks;
        self.direction = step.direction;
        self.older = self.newest;
        self.newest = Passed {
            ticks: step.interval,
            plain,
            speed,
        };
        known.then_some(speed)
    }

    /// Speed at x2, the mean over the last two intervals; none across a reversal or an illegal change.
    ///
    /// `correction` is e(last edge) - e(the edge two before), 0 without a table.
    #[inline]
    #[must_use]
    pub fn x2(&self, correction: TurnDelta32) -> Option<Speed> {
        let both = self.newest.ticks.saturating_add(self.older.ticks);
        if !self.newest.plain || !self.older.plain || both == u32::MAX {
            return None;
        }
        let two = match self.direction {
            Direction::Forward => 2 * self.config.step,
            Direction::Reverse => -2 * self.config.step,
        };
        Some(Speed::over(two.wrapping_sub(widen(correction)), both))
    }

    /// Takes the last step back (after a [`crate::step::Glitch`]). One step can be taken back, not several in a row; the
    /// interval before the one that then is the newest is unknown.
    pub fn withdraw(&mut self) {
        if self.newest.ticks != u32::MAX {
            self.last = self.last.wrapping_sub(Ticks::from(self.newest.ticks));
        }
        self.newest = self.older;
        self.older = UNKNOWN;
    }

    /// Speed at the time `now`: the last one, but no more than one step since the last edge allows, and 0 after the timeout.
    #[inline]
    #[must_use]
    pub fn speed_at(&self, now: Ticks) -> Speed {
        let elapsed = now.saturating_sub(self.last);
        if elapsed >= self.config.timeout {
            return Speed::ZERO;
        }
        let last = self.newest.speed;
        if elapsed <= Ticks::from(self.newest.ticks) {
            return last;
        }
        let bound = Recip::of_u64(elapsed)
            .times(self.config.step.unsigned_abs())
            .cast_signed();
        Speed(last.0.clamp(-bound, bound))
    }
}

/// 2^-32 turn to 2^-60 turn.
#[inline]
const fn widen(angle: TurnDelta32) -> i64 {
    (angle.0 as i64) << (SPEED_FRACTION_BITS - 32)
}

#[cfg(test)]
mod tests;
