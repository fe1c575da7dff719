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
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CLOCK: f64 = 84e6;

    fn step(ticks: Ticks, interval: u32) -> Step {
        Step {
            ticks,
            edge: 0,
            position: 0,
            interval,
            resync: 0,
            advance: 1,
            flags: Flags::NONE,
            direction: Direction::Forward,
        }
    }

    fn interval(slots: u32) -> Interval {
        Interval::new(IntervalConfig::new(slots, 84_000_000))
    }

    #[test]
    fn speeds_from_15_to_6000_rpm_come_out_within_the_bound() {
        for rpm in [15.0, 120.0, 1000.0, 6000.0] {
            let ticks = (CLOCK * 60.0 / rpm / 10_000.0f64).round() as u32;
            let exact = CLOCK * 60.0 / 10_000.0 / f64::from(ticks);
            let mut interval = interval(10_000);
            interval.push(&step(1_000_000, ticks), TurnDelta32(0));
            let next = step(1_000_000 + u64::from(ticks), ticks);
            let x4 = interval.push(&next, TurnDelta32(0));
            for speed in [x4, interval.x2(TurnDelta32(0))] {
                let error = speed.unwrap().rpm(CLOCK) / exact - 1.0;
                assert!(error.abs() < 1.01 * Recip::ERROR, "{rpm}: {error:e}");
            }
        }
    }

    #[test]
    fn known_edge_errors_leave_the_speed_as_it_is() {
        // Grid step 2^22 in Turn32; the middle edge comes early by an eighth of a step.
        let mut interval = interval(1024);
        let early = TurnDelta32(1 << 19);
        interval.push(&step(0, u32::MAX), TurnDelta32(0));
        let short = interval.push(&step(7000, 7000), early);
        assert_eq!(interval.x2(early), None);
        let long = interval.push(&step(16_000, 9000), TurnDelta32(-early.0));
        let exact = (1i64 << 50) / 8000;
        for speed in [short, long, interval.x2(TurnDelta32(0))] {
            let speed = speed.unwrap().0;
            assert!((speed - exact).abs() <= exact >> 28, "{speed} {exact}");
        }
    }

    #[test]
    fn a_stopped_shaft_slows_down_as_one_over_time_and_then_stands() {
        let mut interval = interval(1000);
        interval.push(&step(1000, u32::MAX), TurnDelta32(0));
        let speed = interval.push(&step(2000, 1000), TurnDelta32(0)).unwrap();
        assert_eq!(interval.speed_at(2900), speed);
        let later = interval.speed_at(2000 + 4000);
        assert!((later.0 * 4 - speed.0).abs() <= speed.0 >> 27);
        assert_eq!(interval.speed_at(2000 + 84_000_000), Speed::ZERO);
    }

    #[test]
    fn a_reversal_has_no_mean_speed_and_reverse_motion_a_negative_one() {
        let mut interval = interval(1000);
        interval.push(&step(1000, 1000), TurnDelta32(0));
        let back = Step {
            flags: Flags::REVERSED,
            direction: Direction::Reverse,
            ..step(3000, 2000)
        };
        assert_eq!(interval.push(&back, TurnDelta32(0)), Some(Speed::ZERO));
        assert_eq!(interval.x2(TurnDelta32(0)), None);
        let on = Step {
            direction: Direction::Reverse,
            ..step(4000, 1000)
        };
        assert!(interval.push(&on, TurnDelta32(0)).unwrap() < Speed::ZERO);
        assert_eq!(interval.x2(TurnDelta32(0)), None);
    }

    #[test]
    fn a_withdrawn_step_leaves_the_speed_before_it() {
        let mut interval = interval(1000);
        interval.push(&step(1000, 1000), TurnDelta32(0));
        interval.push(&step(2000, 1000), TurnDelta32(0));
        let before = interval.speed_at(2500);
        interval.push(&step(2100, 100), TurnDelta32(0));
        interval.withdraw();
        assert_eq!(interval.speed_at(2500), before);
        let next = interval.push(&step(3000, 1000), TurnDelta32(0));
        assert_eq!(next, Some(before));
    }

    proptest! {
        #[test]
        fn no_step_and_no_time_makes_it_panic(
            steps in prop::collection::vec((any::<u64>(), any::<u32>(), any::<u16>(), any::<u16>(), any::<i32>()), 1..50), slots: u32
        ) {
            let mut interval = Interval::new(IntervalConfig::new(slots, 1 << 40));
            for (ticks, duration, advance, flags, error) in steps {
                let direction = if error < 0 { Direction::Reverse } else { Direction::Forward };
                let step = Step { advance, flags: Flags(flags), direction, ..step(ticks, duration) };
                let error = TurnDelta32(error);
                interval.push(&step, error);
                let _ = interval.x2(error);
                let later = ticks.wrapping_add(u64::from(duration));
                let _ = interval.speed_at(later);
                interval.withdraw();
            }
        }
    }
}
