//! The usual step while learning: the turn coming in and the fold of the turn before go through the same cells side by
//! side, one edge at a time. What the turn needs an edge is kept together here and handed back when anything else happens.

use super::Parts;
use super::fold::Fold;
use super::low::LowOrders;
use super::turn::{Jitter, Sampling, Turn, wrapped};
use crate::edge::Direction;
use crate::step::{Flags, Step};
use crate::units::STEP_FRACTION_BITS;

/// Turn and fold in step, or neither.
pub(super) struct Lockstep {
    /// Edge to come, [`NO_EDGE`] out of step.
    next: u32,
    /// From edge to edge: 1, or -1 in reverse.
    stride: u32,
    phase_q32: u64,
    /// Step fractions a tick, whole and in 2^-32.
    per_tick: u32,
    per_tick_fraction: u32,
    jitter: Jitter,
    sample: Sampling,
}

/// No edge's number.
const NO_EDGE: u32 = u32::MAX;

impl Lockstep {
    /// Out of step.
    pub const NONE: Self = Self {
        next: NO_EDGE,
        stride: 1,
        phase_q32: 0,
        per_tick: 0,
        per_tick_fraction: 0,
        jitter: Jitter::NONE,
        sample: Sampling {
            size: 1,
            left: 1,
            grid: 0,
        },
    };

    /// In step, if the fold is just where the turn is and the turn is past its first edge.
    pub fn enter(turn: &Turn, fold: &Fold, edges: u32) -> Self {
        let forward = turn.direction == Direction::Forward;
        let (slot, remaining) = place(turn.edge, edges, forward);
        let in_step =
            fold.direction == turn.direction && fold.slot == slot && fold.remaining == remaining;
        match turn.rate.and_then(|rate| rate.per_tick_q32()) {
            Some(per_tick_q32) if in_step && turn.edge != 0 => {
                let stride = if forward { 1 } else { u32::MAX };
                Self {
                    next: turn.edge.wrapping_add(stride),
                    stride,
                    phase_q32: turn.phase_q32,
                    per_tick: whole(per_tick_q32),
                    per_tick_fraction: fraction(per_tick_q32),
                    jitter: turn.jitter,
                    sample: turn.sample,
                }
            }
            _ => Self::NONE,
        }
    }

    /// Hands back what [`Lockstep::enter`] took, and is out of step.
    pub fn leave(&mut self, turn: &mut Turn, fold: &mut Fold, edges: u32) {
        if self.next == NO_EDGE {
            return;
        }
        turn.edge = self.next.wrapping_sub(self.stride);
        turn.phase_q32 = self.phase_q32;
        turn.jitter = self.jitter;
        turn.sample = self.sample;
        let forward = turn.direction == Direction::Forward;
        (fold.slot, fold.remaining) = place(turn.edge, edges, forward);
        fold.block_left = self.sample.left;
        self.next = NO_EDGE;
    }

    /// Takes a step that is the next edge, not the turn's last and nothing special; else does nothing and says false.
    #[inline]
    pub fn take(
        &mut self,
        step: &Step,
        fold: &mut Fold,
        low: &mut LowOrders,
        parts: &mut Parts<'_>,
    ) -> bool {
        // A decoder that comes to the next edge came by one edge.
        let interval = step.interval;
        if step.edge != self.next
            || step.edge == 0
            || step.flags.without(Flags::REFERENCED) != Flags::NONE
            || interval == u32::MAX
        {
            return false;
        }
        let below = u64::from(interval) * u64::from(self.per_tick_fraction);
        let above = u64::from(interval.wrapping_mul(self.per_tick)) << 32;
        let phase_q32 = self.phase_q32.wrapping_add(below).wrapping_add(above);
        let moved = whole(phase_q32).wrapping_sub(whole(self.phase_q32));
        let deviation = moved.wrapping_sub(1 << STEP_FRACTION_BITS).cast_signed();
        // The interval between edges k-1 and k has slot k in either direction.
        let slot = step.edge.wrapping_add(self.stride >> 31) as usize;
        let (Ok(new), Some(cell), Some(sum)) = (
            i16::try_from(deviation),
            parts.cells.get_mut(slot),
            parts.sum.get_mut(slot),
        ) else {
            return false;
        };
        let old = *cell;
        *cell = new;
        self.jitter.take(new, old);
        self.phase_q32 = phase_q32;
        self.next = step.edge.wrapping_add(self.stride);
        #[allow(clippy::cast_possible_truncation)]
        fold.entry(slot as u32, old, sum);
        if self.sample.advance() {
            fold.end_block(parts.coarse);
            self.sample.sample(whole(phase_q32), low);
        }
        true
    }
}

/// Slot and rest of a fold beside a turn whose last edge was `edge`.
fn place(edge: u32, edges: u32, forward: bool) -> (u32, u32) {
    if forward {
        (wrapped(edge, 1, edges, true), edges - edge)
    } else {
        (edge, if edge == 0 { edges } else { edge })
    }
}

#[allow(clippy::cast_possible_truncation)]
#[inline]
const fn whole(q32: u64) -> u32 {
    (q32 >> 32) as u32
}

#[allow(clippy::cast_possible_truncation)]
const fn fraction(q32: u64) -> u32 {
    q32 as u32
}

#[cfg(test)]
mod tests {
    use super::super::{Anchor, EdgeBuffers, Estimator, Progress, Rejection, StaticBuffers};
    use super::*;
    use crate::shape::EncoderShape;
    use crate::step::Outcome;
    use proptest::prelude::*;

    const EDGES: i64 = 24;

    type Small = Estimator<StaticBuffers<6, 4>>;

    fn estimator() -> Small {
        let shape = EncoderShape::new(24, 4).unwrap();
        Estimator::new(shape, Anchor::Index, StaticBuffers::new()).unwrap()
    }

    /// Where everything stands, out of step.
    fn state(estimator: &mut Small) -> std::vec::Vec<i32> {
        estimator.leave_lockstep();
        let parts = estimator.buffers.parts();
        let cells = parts.cells.iter().map(|&cell| i32::from(cell));
        let sums = parts.sum.iter().chain(&*parts.coarse);
        cells.chain(sums.copied()).collect()
    }

    proptest! {
        #[test]
        fn in_step_or_out_of_it_the_same_is_learned(
            turns in 3usize..9, reverse: bool, interval in 20u32..200_000, faults in prop::collection::vec(0usize..200, 0..3),
            jitter in prop::collection::vec(0u32..100, 240)
        ) {
            let (mut quick, mut careful) = (estimator(), estimator());
            let (mut position, mut ticks, mut in_step) = (-2, 0, 0);
            for i in 0..turns * EDGES as usize {
                position += if reverse { -1 } else { 1 };
                let interval = interval + interval * jitter[i % jitter.len()] / 1000;
                ticks += u64::from(interval);
                let edge = position + i64::from(reverse);
                let fault = if faults.contains(&i) { Flags::TURN_SUSPECT } else { Flags::NONE };
                let outcome = Outcome::Step(Step {
                    ticks,
                    edge: edge.rem_euclid(EDGES) as u32,
                    position: position.rem_euclid(EDGES) as u32,
                    interval,
                    resync: 0,
                    advance: 1,
                    flags: Flags::REFERENCED.with(fault),
                    direction: if reverse { Direction::Reverse } else { Direction::Forward },
                });
                careful.leave_lockstep();
                in_step += usize::from(quick.lockstep.next != NO_EDGE);
                prop_assert_eq!(quick.push(&outcome), careful.push(&outcome), "edge {}", i);
            }
            prop_assert_eq!(state(&mut quick), state(&mut careful));
            prop_assert_eq!(quick.totals(), careful.totals());
            let slow = interval > 1 << 16;
            prop_assert!(slow || !faults.is_empty() || in_step >= (turns - 3) * (EDGES as usize - 2), "{}", in_step);
        }
    }

    #[test]
    fn time_that_runs_backward_rejects_the_turn() {
        let mut estimator = estimator();
        let mut ends = std::vec::Vec::new();
        for k in 0..=4 * EDGES as u64 {
            // Between edges 60 and 61 the clock falls back by as much as the shaft took.
            let late = if k > 60 { 2000 } else { 0 };
            let edge = (k % EDGES as u64) as u32;
            let progress = estimator.push(&Outcome::Step(Step {
                ticks: 10_000 + 1000 * k - late,
                edge,
                position: edge,
                interval: if k == 61 { 0 } else { 1000 },
                resync: 0,
                advance: 1,
                flags: Flags::REFERENCED,
                direction: Direction::Forward,
            }));
            if progress != Progress::Running {
                ends.push((k, progress));
            }
        }
        let backward = Progress::TurnRejected(Rejection::Irregular);
        assert_eq!(ends[..2], [(48, Progress::TurnTaken(1)), (72, backward)]);
    }
}
