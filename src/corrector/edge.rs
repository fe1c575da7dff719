//! What the corrector makes of an edge, and how the shaft goes on from there.

use crate::recip::Recip;
use crate::step::Flags;
use crate::units::{TICK_FRACTION_BITS, TickDelta8, Ticks, Turn32, TurnDelta32};

/// Longest time looked ahead, ticks: far more than any interval, and in 2^-8 tick it fits 64 bits.
const AHEAD_MAX: Ticks = 1 << 48;

/// One edge, corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectedEdge {
    /// Time of the edge as captured.
    pub ticks: Ticks,
    /// Shaft angle. Before the index its origin is where counting began.
    pub angle: Turn32,
    /// Corrected angle moved since the previous edge, negative in reverse, 0 where the direction changed.
    pub moved: TurnDelta32,
    /// Time since the previous edge as captured, ticks; 0 at the first edge.
    pub interval: u32,
    /// How late the capture was: the shaft was at `angle` this much before `ticks`.
    pub late: TickDelta8,
    /// How much longer the interval is than the time that the shaft took; 0 at the first edge.
    pub stretch: TickDelta8,
    /// Facts about the step: [`Flags::TURN_SUSPECT`] says that the angle may be off by whole edges.
    pub flags: Flags,
}

impl CorrectedEdge {
    /// Time that the shaft took from the previous edge to this, 2^-8 tick; 0 at the first edge, and at least 1 after it.
    #[inline]
    #[must_use]
    pub fn interval_q8(&self) -> u64 {
        match self.interval {
            0 => 0,
            ticks => {
                let time = (i64::from(ticks) << TICK_FRACTION_BITS) - i64::from(self.stretch.0);
                time.max(1).cast_unsigned()
            }
        }
    }

    /// Way from here until `now` at the speed of the last interval, 2^-32 turn, positive in the direction of motion. Right after an
    /// edge that is captured earlier than the mean the shaft is still short of it.
    #[inline]
    pub(super) fn way_until(&self, now: Ticks) -> i64 {
        let elapsed = now.saturating_sub(self.ticks).min(AHEAD_MAX);
        self.way((elapsed << TICK_FRACTION_BITS).cast_signed() + i64::from(self.late.0))
    }

    /// Way in a time at the speed of the last interval, 2^-32 turn, with the sign of the time.
    #[inline]
    pub(super) fn way_in(&self, time: TickDelta8) -> i64 {
        match time.0 {
            0 => 0,
            time => self.way(i64::from(time)),
        }
    }

    /// Way in a time of 2^-8 tick, with its sign.
    #[inline]
    fn way(&self, time_q8: i64) -> i64 {
        let (time, interval) = (time_q8.unsigned_abs(), self.interval_q8());
        // Both are made to fit 32 bits: what is cut off is worth less than the angle's unit.
        let excess = 32_u32.saturating_sub((time | interval).leading_zeros());
        #[allow(clippy::cast_possible_truncation)]
        let [time, interval] = [time, interval].map(|t| (t >> excess) as u32);
        let product = u64::from(self.moved.0.unsigned_abs()) * u64::from(time);
        let way = Recip::of_u32(interval).times(product);
        let way = i64::try_from(way).unwrap_or(i64::MAX);
        if time_q8 < 0 { -way } else { way }
    }
}
