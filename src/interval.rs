//! Speed from edge times (T-method), equations (2) and (3).
//!
//! At x4 every edge is held against the one before (pi/2M in the paper's terms), at x2 against the edge before that, which is
//! of the same channel, so that the quadrature error drops out. Known edge errors correct the angle: the shaft moved by the
//! grid step less the difference of the two edges' errors. Known delays of the capture correct the time: an interval is too long by
//! the difference of the two edges' delays.
//!
//! # Units and error
//! [`Speed`] is i64 in 2^-60 turn a tick. At 84 MHz 15 r/min is 3.43e9 LSB and 6000 r/min 1.37e12, a ten-millionth of
//! the range. The quotient is below the exact one by at most 2^-29 of it ([`Recip::ERROR`]) plus 1 LSB; the grid step is short by
//! less than 1 LSB. One tick of the capture is 2.98e-5 of an interval at 15 r/min and N = 10000: the arithmetic adds
//! nothing.
//!
//! An edge only notes how far the shaft moved in how long; the reciprocal is worked out when a speed is asked for.
//!
//! # Stopping
//! Between edges the shaft can't have moved further than one grid step, so the speed's size is at most a step over
//! the time since the last edge; after the timeout it is 0.

use crate::edge::Direction;
use crate::recip::Recip;
use crate::step::{Flags, Step};
use crate::units::{TICK_FRACTION_BITS, TickDelta8, Ticks, TurnDelta32};

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

    /// Mean speed over `angle` (2^-60 turn) in a time of 2^-8 tick; less than a tick counts as one.
    #[inline]
    #[must_use]
    pub const fn over_q8(angle: i64, time_q8: u64) -> Self {
        let least = 1 << TICK_FRACTION_BITS;
        let time_q8 = if time_q8 < least { least } else { time_q8 };
        // At least a tick, so the reciprocal has these digits to give.
        let Recip { mantissa, shift } = Recip::of_u64(time_q8);
        let shift = shift - TICK_FRACTION_BITS;
        Self(Recip { mantissa, shift }.times_signed(angle))
    }

    /// Revolutions a minute at a tick rate of `clock_hz`. For reports only.
    #[must_use]
    pub fn rpm(self, clock_hz: f64) -> f64 {
        self.0 as f64 / (1u64 << SPEED_FRACTION_BITS) as f64 * clock_hz * 60.0
    }
}

/// By how much the error of an edge is more than that of the edge before, e(k) - e(k-1) of equation (2). A type of its own, because
/// the angle moved since the edge before is a [`TurnDelta32`] too, and in its place leaves next to no speed.
///
/// From [`Corrector::push_for_speed`](crate::corrector::Corrector::push_for_speed), or from two errors of a table.
///
/// ```
/// use quadcal::interval::ErrorChange;
/// use quadcal::units::TurnDelta32;
///
/// let change = ErrorChange::from_to(TurnDelta32(100), TurnDelta32(-20));
/// assert_eq!(change.angle(), TurnDelta32(-120));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorChange(TurnDelta32);

impl ErrorChange {
    /// Without a table, or where it is not known.
    pub const NONE: Self = Self(TurnDelta32(0));

    /// From the error of the edge before to that of this edge, as [`ErrorTable::error`](crate::table::ErrorTable::error) gives them.
    #[inline]
    #[must_use]
    pub const fn from_to(before: TurnDelta32, after: TurnDelta32) -> Self {
        Self(TurnDelta32(after.0.wrapping_sub(before.0)))
    }

    /// The difference, 2^-32 turn.
    #[inline]
    #[must_use]
    pub const fn angle(self) -> TurnDelta32 {
        self.0
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
pub(crate) struct Passed {
    /// Angle moved, 2^-60 turn, 0 where it is unknown or the direction changed.
    moved: i64,
    /// Duration as captured, `u32::MAX` if unknown.
    ticks: u32,
    /// How much longer that is than the shaft took.
    stretch: TickDelta8,
    /// Single edge step without a reversal.
    plain: bool,
}

const UNKNOWN: Passed = Passed {
    moved: 0,
    ticks: u32::MAX,
    stretch: TickDelta8::ZERO,
    plain: false,
};

impl Passed {
    /// Mean speed over it; 0 where it is not known.
    #[inline]
    pub(crate) fn speed(&self) -> Speed {
        if self.moved == 0 {
            Speed::ZERO
        } else {
            mean(self.moved, self.ticks, self.stretch)
        }
    }
}

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

    /// Takes an accepted step.
    ///
    /// `change` is e(this edge) - e(previous edge).
    #[inline]
    pub fn push(&mut self, step: &Step, change: ErrorChange) {
        self.push_delayed(step, change, TickDelta8::ZERO);
    }

    /// As [`Self::push`]. `stretch` is delay(this edge) - delay(previous edge) of the capture, as in
    /// [`crate::corrector::CorrectedEdge::stretch`].
    #[inline]
    pub fn push_delayed(&mut self, step: &Step, change: ErrorChange, stretch: TickDelta8) {
        let plain =
            step.advance == 1 && step.interval != u32::MAX && !step.flags.contains(Flags::REVERSED);
        let passed = if plain {
            self.plainly(step.direction, step.interval, change, stretch)
        } else {
            Passed {
                moved: self.moved_oddly(step, change),
                ticks: step.interval,
                stretch,
                plain,
            }
        };
        self.last = step.ticks;
        self.direction = step.direction;
        self.older = self.newest;
        self.newest = passed;
    }

    /// What a plain step passed: one edge further in the same direction.
    #[inline]
    pub(crate) fn plainly(
        &self,
        direction: Direction,
        ticks: u32,
        change: ErrorChange,
        stretch: TickDelta8,
    ) -> Passed {
        let moved = self.moved_by(1, direction);
        Passed {
            moved: moved.wrapping_sub(widen(change.0)),
            ticks,
            stretch,
            plain: true,
        }
    }

    /// The newest interval and when it ended.
    pub(crate) const fn newest(&self) -> (Passed, Ticks) {
        (self.newest, self.last)
    }

    /// Way of a step that is not a plain one. A reversal crosses the same edge twice, so the speed over it is 0.
    #[cold]
    #[inline(never)]
    fn moved_oddly(&self, step: &Step, change: ErrorChange) -> i64 {
        let reversed = step.flags.contains(Flags::REVERSED);
        if step.interval == u32::MAX || (reversed && step.advance == 1) {
            return 0;
        }
        let steps = i64::from(step.advance) - i64::from(reversed);
        self.moved_by(steps, step.direction)
            .wrapping_sub(widen(change.0))
    }

    #[inline]
    fn moved_by(&self, steps: i64, direction: Direction) -> i64 {
        let moved = self.config.step.wrapping_mul(steps);
        match direction {
            Direction::Forward => moved,
            Direction::Reverse => moved.wrapping_neg(),
        }
    }

    /// Speed at x4, the mean over the last interval; none at the first edge or over an interval that is too long.
    #[inline]
    #[must_use]
    pub fn x4(&self) -> Option<Speed> {
        (self.newest.ticks != u32::MAX).then(|| self.newest.speed())
    }

    /// Speed at x2, the mean over the last two intervals; none across a reversal or an illegal change.
    ///
    /// `change` is e(last edge) - e(the edge two before). The delays of the two edges differ as given to
    /// [`Self::push_delayed`].
    #[inline]
    #[must_use]
    pub fn x2(&self, change: ErrorChange) -> Option<Speed> {
        let both = self.newest.ticks.saturating_add(self.older.ticks);
        if !self.newest.plain || !self.older.plain || both == u32::MAX {
            return None;
        }
        let two = self.moved_by(2, self.direction);
        let stretch = self.newest.stretch.0.saturating_add(self.older.stretch.0);
        let moved = two.wrapping_sub(widen(change.0));
        Some(mean(moved, both, TickDelta8(stretch)))
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
        self.speed_after(&self.newest, self.last, now)
    }

    /// [`Self::speed_at`] after an interval that ended at `end`.
    #[inline]
    pub(crate) fn speed_after(&self, passed: &Passed, end: Ticks, now: Ticks) -> Speed {
        let elapsed = now.saturating_sub(end);
        if elapsed >= self.config.timeout {
            return Speed::ZERO;
        }
        let last = passed.speed();
        if elapsed <= Ticks::from(passed.ticks) {
            return last;
        }
        let bound = Recip::of_u64(elapsed).times(self.config.step.unsigned_abs());
        let size = last.0.unsigned_abs().min(bound).cast_signed();
        Speed(if last.0 < 0 { -size } else { size })
    }
}

/// Mean speed over `moved` (2^-60 turn) in `ticks` less `stretch`.
#[inline]
const fn mean(moved: i64, ticks: u32, stretch: TickDelta8) -> Speed {
    if stretch.0 == 0 {
        return Speed::over(moved, ticks);
    }
    let time = ((ticks as i64) << TICK_FRACTION_BITS) - stretch.0 as i64;
    Speed::over_q8(moved, if time < 0 { 0 } else { time.cast_unsigned() })
}

/// 2^-32 turn to 2^-60 turn.
#[inline]
const fn widen(angle: TurnDelta32) -> i64 {
    (angle.0 as i64) << (SPEED_FRACTION_BITS - 32)
}

#[cfg(test)]
mod tests;
