//! The recent edges' times, and what a shaft that made them could do next.
//!
//! A decoder sees positions only modulo a few edges, so several edges lost at once look like a reversal, like nothing or
//! like one long interval. Time tells these apart from true motion: over two spans of four edges, a shaft that is about
//! to reverse has slowed down. With constant deceleration the last span before a reversal lasts 1.62 to 2.41 times the one
//! before; in steady motion the ratio is 1, and errors of the edges of 30 % of a step take it to 1.35 at most. The limit
//! is 1.5. Spans of four edges hold one edge of each class, so width and quadrature errors drop out.

use crate::edge::Direction;
use crate::units::Ticks;

/// Intervals from here on count as standing still, and history starts anew: 2^28 ticks, 3.2 s at 84 MHz.
pub(crate) const STANDING: u32 = 1 << 28;

const DEPTH: u32 = 16;
const SPAN: u32 = 4;

/// Times of the last edges, direction, and how long it has lasted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Motion {
    /// Time of the last accepted edge.
    pub last: Ticks,
    /// Low words of edge times, a ring; two within [`STANDING`] of each other differ correctly.
    times: [u32; DEPTH as usize],
    head: u32,
    /// Valid entries, at most `DEPTH`.
    filled: u32,
    /// Edges in the present direction, at most `DEPTH`.
    run: u32,
    /// `run` before the last reversal.
    prior_run: u32,
    pub direction: Direction,
}

impl Motion {
    /// Nothing known.
    pub const fn new() -> Self {
        Self {
            last: 0,
            times: [0; DEPTH as usize],
            head: 0,
            filled: 0,
            run: 0,
            prior_run: 0,
            direction: Direction::Forward,
        }
    }

    /// Time since the last edge, at most `u32::MAX`; 0 if time runs backward.
    #[inline]
    pub fn interval(&self, ticks: Ticks) -> u32 {
        let elapsed = ticks.saturating_sub(self.last);
        u32::try_from(elapsed).unwrap_or(u32::MAX)
    }

    #[inline]
    fn time(&self, back: u32) -> u32 {
        let slot = self.head.wrapping_sub(back) % DEPTH;
        self.times.get(slot as usize).copied().unwrap_or(0)
    }

    /// Duration of the four edge steps that end `back` edges ago.
    #[inline]
    fn span(&self, back: u32) -> u32 {
        self.time(back)
            .wrapping_sub(self.time(back.wrapping_add(SPAN)))
    }

    /// Ticks from the edge `earlier` edges ago to the one `later` edges ago.
    pub fn between(&self, later: u32, earlier: u32) -> u32 {
        self.time(later).wrapping_sub(self.time(earlier))
    }

    /// Notes an edge in the present direction, `interval` after the last.
    #[inline]
    pub fn push(&mut self, ticks: Ticks, interval: u32) {
        if interval >= STANDING {
            self.filled = 0;
            self.run = 0;
        }
        self.head = self.head.wrapping_add(1) % DEPTH;
        if let Some(slot) = self.times.get_mut(self.head as usize) {
            *slot = ticks as u32;
        }
        self.filled = (self.filled + 1).min(DEPTH);
        self.run = (self.run + 1).min(DEPTH);
        self.last = ticks;
    }

    /// Notes edges that did not come, where steady motion has them, `interval` apart.
    pub fn push_lost(&mut self, edges: u16, interval: u32) {
        for _ in 0..edges {
            self.push(self.last.saturating_add(Ticks::from(interval)), interval);
        }
    }

    /// [`Motion::push`] where history [`Motion::is_full`] and the interval is below STANDING. Returns the next
    /// [`Motion::quick_limit`].
    #[inline]
    pub fn push_steady(&mut self, ticks: Ticks) -> u32 {
        self.head = self.head.wrapping_add(1) % DEPTH;
        if let Some(slot) = self.times.get_mut(self.head as usize) {
            *slot = ticks as u32;
        }
        self.last = ticks;
        self.quick_limit()
    }

    /// Whether as many edges are known, all in one direction, as can be.
    pub fn is_full(&self) -> bool {
        self.filled == DEPTH && self.run == DEPTH
    }

    /// An interval below this one, two typical ones, is not [`Motion::is_long`], history being full.
    #[inline]
    pub fn quick_limit(&self) -> u32 {
        // Time that ran backward gives a negative span: no interval is below 0.
        let half_span = self.span(0).cast_signed() >> 1;
        let standing = (STANDING - 1).cast_signed();
        half_span.clamp(0, standing).cast_unsigned()
    }

    /// Turns round; the next pushed edge is the first in the new direction.
    pub fn reverse(&mut self) {
        self.direction = self.direction.opposite();
        self.prior_run = self.run;
        self.run = 0;
    }

    /// Whether the last eight steps went the same way without a fault.
    pub fn is_settled(&self) -> bool {
        self.run > 2 * SPAN
    }

    /// Lets steady motion begin anew.
    pub fn unsettle(&mut self) {
        self.run = 0;
    }

    /// The direction to believe in where an edge does not tell: one reversed edge alone does not count.
    pub fn settled_direction(&self) -> Direction {
        if self.run == 1 && self.prior_run > 1 {
            self.direction.opposite()
        } else {
            self.direction
        }
    }

    /// Quick look, true if `interval` could be at least three typical ones: the careful test is [`Motion::is_spike`].
    #[inline]
    pub fn is_long(&self, interval: u32) -> bool {
        // Three quarters of the last span, so three mean intervals; no overflow below STANDING.
        interval >= STANDING || interval * 4 >= self.span(0).saturating_mul(3)
    }

    /// Steady for eight edges up to now: not slowing down to a stop.
    pub fn is_steady(&self) -> bool {
        self.is_settled() && u64::from(self.span(0)) * 2 < u64::from(self.span(SPAN)) * 3
    }

    /// Whether `interval` breaks steady motion with three or more typical intervals and yet is too short for a stop: four
    /// lost edges look like this. Sixteen and more are taken as a stop.
    pub fn is_spike(&self, interval: u32) -> bool {
        let typical4 = u64::from(self.span(0));
        let interval4 = u64::from(interval) * 4;
        self.is_steady() && interval4 >= typical4 * 3 && interval4 < typical4 * 16
    }

    /// Whether a reversal `interval` after the last edge comes without slowing down: two lost edges look like this.
    pub fn is_abrupt(&self, interval: u32) -> bool {
        self.is_steady() && u64::from(interval) * 4 < u64::from(self.span(0)) * 16
    }

    /// Whether a sample without change, `interval` after the last edge, can't hide lost edges: steady, and sooner than two
    /// typical intervals.
    pub fn is_harmless_repeat(&self, interval: u32) -> bool {
        self.is_steady() && u64::from(interval) * 2 < u64::from(self.span(0))
    }

    /// Whether steady motion should have brought an edge by now, two typical intervals after the last, and the shaft does not
    /// stand still.
    pub fn is_late(&self, interval: u32) -> bool {
        let typical4 = u64::from(self.span(0));
        let interval4 = u64::from(interval) * 4;
        self.is_steady() && interval4 >= typical4 * 2 && interval4 < typical4 * 16
    }

    /// Longest interval that still continues steady motion: three typical ones.
    pub fn steady_limit(&self) -> u32 {
        (self.span(0) / 4).saturating_mul(3)
    }

    /// Typical interval before the last edge, 0 if not known.
    pub fn typical_before_last(&self) -> u32 {
        if self.filled > SPAN + 1 {
            self.span(1) / 4
        } else {
            0
        }
    }

    /// Takes the last edge back. False, and nothing done, if it is the only one known.
    pub fn withdraw(&mut self, was_reversal: bool) -> bool {
        if self.filled < 2 {
            return false;
        }
        let interval = self.time(0).wrapping_sub(self.time(1));
        self.last = self.last.wrapping_sub(Ticks::from(interval));
        self.head = self.head.wrapping_sub(1) % DEPTH;
        self.filled -= 1;
        if was_reversal {
            self.direction = self.direction.opposite();
            self.run = self.prior_run;
        } else {
            self.run = self.run.saturating_sub(1);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(times: impl IntoIterator<Item = u64>) -> Motion {
        let mut motion = Motion::default();
        for ticks in times {
            let interval = motion.interval(ticks);
            motion.push(ticks, interval);
        }
        motion
    }

    /// Times before a stop at `end` with constant deceleration, the last edge `rest` steps before the turning point.
    fn stopping(rest: f64) -> Motion {
        after((0..20).rev().map(|edge| {
            let ahead = f64::from(edge) + rest;
            (1e6 - 1e5 * ahead.sqrt()) as u64
        }))
    }

    #[test]
    fn a_reversal_after_constant_deceleration_is_never_abrupt() {
        for tenth in 0..10 {
            let rest = f64::from(tenth) / 10.0;
            let motion = stopping(rest);
            let interval = (2e5 * rest.sqrt()) as u32;
            assert!(!motion.is_abrupt(interval), "{rest}");
            assert!(!motion.is_spike((1e5 * (1.0 + rest).sqrt()) as u32));
        }
    }

    #[test]
    fn a_reversal_out_of_steady_motion_is_abrupt_unless_it_stood_still() {
        let motion = after((0..20).map(|k| k * 1000));
        assert!(motion.is_abrupt(3000));
        assert!(!motion.is_abrupt(16_000));
        assert!(motion.is_spike(5000) && !motion.is_spike(2900) && !motion.is_spike(16_000));
    }

    #[test]
    fn withdrawing_brings_back_the_time_and_the_run() {
        let before = after((0..20).map(|k| k * 1000));
        let mut motion = before;
        motion.reverse();
        motion.push(19_100, 100);
        assert_eq!(motion.settled_direction(), Direction::Forward);
        assert_eq!(motion.typical_before_last(), 1000);
        assert!(motion.withdraw(true));
        assert_eq!(motion.last, before.last);
        assert_eq!(
            (motion.run, motion.direction),
            (before.run, before.direction)
        );
        assert!(motion.is_steady());
    }

    #[test]
    fn history_starts_anew_after_standing_still() {
        let mut motion = after((0..20).map(|k| k * 1000));
        let late = 19_000 + u64::from(STANDING);
        motion.push(late, motion.interval(late));
        assert!(!motion.is_steady());
        assert!(!motion.withdraw(false));
    }
}
