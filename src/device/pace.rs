//! Mean speed over a part of a turn: single intervals of a badly made encoder say little.

use crate::edge::Direction;
use crate::shape::EncoderShape;
use crate::step::{Flags, Step};
use crate::units::Ticks;
use crate::wide::over;

/// Parts of a turn.
const PARTS: u32 = 16;

/// Milliseconds in a minute, times a thousandth of a revolution.
const PER_MINUTE: u128 = 60_000;

/// Times whole parts of a turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    edges: u32,
    /// Edges of a part: whole lines.
    part: i32,
    /// Edges to go to the end of this part.
    left: i32,
    start: Ticks,
    direction: Direction,
    /// Edges and ticks of the last part, none right after a start.
    mean: (u32, u64),
}

impl Pace {
    pub fn new(shape: EncoderShape) -> Self {
        let lines = (shape.lines() / PARTS).max(1);
        let part = (lines * shape.classes()).cast_signed();
        Self {
            edges: shape.edges(),
            part,
            left: part,
            start: 0,
            direction: Direction::Forward,
            mean: (0, 0),
        }
    }

    /// Of the last step.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// On the edge path.
    #[inline]
    pub fn push(&mut self, step: &Step) {
        let starts = step.flags.intersects(Flags::FIRST.with(Flags::REVERSED))
            || step.direction != self.direction;
        self.left -= i32::from(step.advance);
        if starts || self.left <= 0 {
            self.begin_part(step, starts);
        }
    }

    #[cold]
    #[inline(never)]
    fn begin_part(&mut self, step: &Step, starts: bool) {
        self.mean = if starts {
            (0, 0)
        } else {
            (self.passed(), step.ticks.saturating_sub(self.start))
        };
        self.direction = step.direction;
        (self.start, self.left) = (step.ticks, self.part);
    }

    const fn passed(&self) -> u32 {
        (self.part - self.left).cast_unsigned()
    }

    /// Thousandths of a revolution a minute, the last edge having been at `last`; 0 after `still` ticks without an edge, and at least 1
    /// before. Divides.
    pub fn speed(&self, last: Ticks, now: Ticks, clock_hz: u64, still: Ticks) -> u32 {
        // Before the first whole part, what there is.
        let (edges, ticks) = match self.mean {
            (0, _) => (self.passed(), last.saturating_sub(self.start)),
            mean => mean,
        };
        if edges == 0 || now.saturating_sub(last) > still {
            return 0;
        }
        let way = u128::from(edges) * u128::from(clock_hz) * PER_MINUTE;
        let speed = over(way, u128::from(self.edges) * u128::from(ticks.max(1)));
        u32::try_from(speed).unwrap_or(u32::MAX).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(ticks: Ticks, flags: Flags, direction: Direction) -> Step {
        Step {
            ticks,
            edge: 0,
            position: 0,
            interval: 1,
            resync: 0,
            advance: 1,
            flags,
            direction,
        }
    }

    #[test]
    fn a_crooked_encoder_has_an_even_pace_and_stands_still_after_a_while() {
        // 60 lines at 600 r/min, clock 1 MHz: 240 edges in 100,000 ticks. Edges are off by a third of a step within each line.
        let mut pace = Pace::new(EncoderShape::new(240, 4).unwrap());
        let speed = |pace: &Pace, last, now| pace.speed(last, now, 1_000_000, 500_000);
        assert_eq!(speed(&pace, 0, 0), 0);
        let off = [0, 139, -139, 70];
        let mut now = 0;
        for k in 0..300_u64 {
            now = (1000 + k * 1000 / 24 * 10).saturating_add_signed(off[k as usize % 4]);
            let first = if k == 0 { Flags::FIRST } else { Flags::NONE };
            pace.push(&step(now, first, Direction::Forward));
            let found = speed(&pace, now, now);
            assert!(k < 24 || (590_000..610_000).contains(&found), "{k} {found}");
        }
        assert!(speed(&pace, now, now + 500_000) > 0);
        assert_eq!(speed(&pace, now, now + 500_001), 0);
        pace.push(&step(now, Flags::REVERSED, Direction::Reverse));
        assert_eq!(speed(&pace, now, now), 0);
    }
}
