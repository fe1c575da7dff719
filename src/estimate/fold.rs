//! Folding a whole turn into the sums, one entry an edge while the next turn comes in.
//!
//! A turn's edges were kept as step fractions of time, at the rate of the turn before. Here they become angle: three
//! crossings of edge 0, the ends of this turn and of the one before, are free of encoder error, and a shaft of constant
//! acceleration through them has at tau = 0..1 of the turn's time the angle tau - bend tau (1 - tau). What is left of each
//! interval beside the grid's step is the encoder's, and the torque's.

use super::Parts;
use super::speeds::Shifts;
use super::turn::wrapped;
use crate::edge::Direction;
use crate::recip::Recip;
use crate::units::STEP_FRACTION_BITS;

/// The motion through the ends of two turns.
#[derive(Clone, Copy)]
pub(super) struct Motion {
    /// Step fractions of the whole turn.
    pub length: u32,
    /// Bend, Q32: with rho the duration of the turn before over this one's, (rho - 1) / (rho (rho + 1)).
    pub bend_q32: i32,
}

impl Motion {
    /// The bend of a turn of `duration` after one of `before`; the two are within a factor of two.
    pub(super) fn bend_q32(before: u64, duration: u64) -> i32 {
        // (before - duration) / before x duration / (before + duration)
        let change = i128::from(before) - i128::from(duration);
        let share =
            |recip: Recip, value: u128| (value * u128::from(recip.mantissa)) >> (recip.shift - 32);
        let change_q32 = share(Recip::of_u64(before), change.unsigned_abs());
        let part_q32 = share(Recip::of_u64(before + duration), duration.into());
        let size = i32::try_from((change_q32 * part_q32) >> 32).unwrap_or(i32::MAX);
        if change < 0 { -size } else { size }
    }
}

/// What the shape of the encoder says of every fold.
#[derive(Clone, Copy)]
pub(super) struct FoldShape {
    pub edges: u32,
    /// Edges of a block, and blocks of a turn.
    pub block: u32,
    pub blocks: u32,
    pub classes: u32,
    /// 2^32 / classes, rounded up.
    class_inverse: u32,
    /// Sums are in units of 2^(`unit_shift` - 32) turn, so that a step has 15 bits.
    pub unit_shift: u32,
    /// Shift from half an angle to that unit, and half the unit there.
    half_shift: u32,
    half: u32,
    /// One step of the grid in that unit, rounded down.
    pub step: u32,
}

impl FoldShape {
    pub(super) fn new(edges: u32, classes: u32, block: u32) -> Self {
        // Edges are never none, but the compiler can't know, and would leave a panic here.
        let step = (1_u64 << 32) / u64::from(edges.max(1));
        // Two at least, with 65,536 edges.
        let unit_shift = (64 - step.leading_zeros()).saturating_sub(15).max(2);
        #[allow(clippy::cast_possible_truncation)]
        Self {
            edges,
            block,
            blocks: edges / block.max(1),
            classes,
            class_inverse: (u32::MAX / classes.max(1)).wrapping_add(1),
            unit_shift,
            half_shift: (unit_shift - 1) & 31,
            half: 1 << (unit_shift - 2),
            step: (step >> unit_shift) as u32,
        }
    }
}

/// How a turn counts in the sums.
#[derive(Clone, Copy, Default)]
pub(super) struct TurnScale {
    pub sum: Shifts,
    /// Counts with a minus in the contrasts.
    pub minus: bool,
}

/// What is left to fold of the turn taken last.
pub(super) struct Fold {
    pub shape: FoldShape,
    pub remaining: u32,
    pub slot: u32,
    pub direction: Direction,
    scale: TurnScale,
    phase: u32,
    /// Shift that normalises the phase of the whole turn, and 2^64 over that less 2^32.
    normal: u32,
    rest: u32,
    bend_q32: i32,
    place: u32,
    /// Edges until the present block ends.
    pub block_left: u32,
    block_place: u32,
    block: u32,
    /// Deviations of this turn summed by class.
    pub classes: [i32; crate::shape::CLASSES_MAX],
}

impl Fold {
    pub(super) fn idle(shape: FoldShape) -> Self {
        Self {
            shape,
            remaining: 0,
            slot: 0,
            direction: Direction::Forward,
            scale: TurnScale::default(),
            phase: 0,
            normal: 0,
            rest: 0,
            bend_q32: 0,
            place: 0,
            block_left: shape.block,
            block_place: 0,
            block: 0,
            classes: [0; crate::shape::CLASSES_MAX],
        }
    }

    /// Gets ready for a turn that went in `direction`.
    pub(super) fn start(&mut self, direction: Direction, motion: Motion, scale: TurnScale) {
        let forward = direction == Direction::Forward;
        let normal = motion.length.leading_zeros();
        let shape = self.shape;
        *self = Self {
            remaining: shape.edges,
            slot: u32::from(forward),
            direction,
            scale,
            normal,
            rest: Recip::of_u32(motion.length << normal).mantissa << 1,
            bend_q32: motion.bend_q32,
            block: if forward {
                0
            } else {
                shape.blocks.wrapping_sub(1)
            },
            ..Self::idle(shape)
        };
    }

    /// How far the sum is shifted down while this turn goes in.
    pub(super) fn sum_down(&self) -> u32 {
        self.scale.sum.sum_down
    }

    pub(super) fn is_idle(&self) -> bool {
        self.remaining == 0
    }

    /// Whether a turn in `direction` that starts now writes every cell after it was folded.
    pub(super) fn follows(&self, direction: Direction) -> bool {
        self.direction == direction && self.slot == u32::from(direction == Direction::Forward)
    }

    /// Folds the entry of `slot`, the next one; where the fold is, its caller counts.
    #[inline]
    pub(super) fn entry(&mut self, slot: u32, cell: i16, sum: &mut i32) {
        let step = (1_i32 << STEP_FRACTION_BITS) + i32::from(cell);
        self.phase = self.phase.wrapping_add_signed(step);
        let scaled = self.phase << (self.normal & 31);
        let time = scaled.wrapping_add(high(scaled, self.rest));
        let arc = high(time, time.wrapping_neg()).cast_signed();
        #[allow(clippy::cast_possible_truncation)]
        let bent = ((i64::from(arc) * i64::from(self.bend_q32)) >> 32) as i32;
        // Rounded; by way of half the angle, so that the turn's end does not wrap around.
        let place =
            ((time.wrapping_add_signed(-bent) >> 1) + self.shape.half) >> self.shape.half_shift;
        let deviation = place
            .wrapping_sub(self.place)
            .wrapping_sub(self.shape.step)
            .cast_signed();
        self.place = place;
        let shifts = self.scale.sum;
        let counted = (deviation << (shifts.turn_up & 31)) >> (shifts.turn_down & 31);
        *sum = (*sum >> (shifts.sum_down & 31)).wrapping_add(counted);
        // Slots are below 2^16, so the product's upper word is the quotient.
        let line = high(slot, self.shape.class_inverse);
        let class = slot.wrapping_sub(line.wrapping_mul(self.shape.classes));
        if let Some(class) = self.classes.get_mut(class as usize) {
            *class = class.wrapping_add(deviation);
        }
    }

    /// Adds the block that ends here to the coarse sums.
    #[inline(never)]
    pub(super) fn end_block(&mut self, coarse: &mut [i32]) {
        let grid = self.shape.block.wrapping_mul(self.shape.step);
        let moved = self
            .place
            .wrapping_sub(self.block_place)
            .wrapping_sub(grid)
            .cast_signed();
        let shifts = self.scale.sum;
        let signed = if self.scale.minus { -moved } else { moved };
        let counted = (signed << (shifts.turn_up & 31)) >> (shifts.turn_down & 31);
        let index = self.block as usize;
        let [even, even_contrast, contrast] = thirds(coarse);
        if let (Some(even), Some(even_contrast), Some(contrast)) = (
            even.get_mut(index),
            even_contrast.get_mut(index),
            contrast.get_mut(index),
        ) {
            *even = even.saturating_add(moved);
            *even_contrast = even_contrast.saturating_add(signed);
            *contrast = (*contrast >> (shifts.sum_down & 31)).saturating_add(counted);
        }
        self.block_place = self.place;
        self.block_left = self.shape.block;
        self.block = if self.direction == Direction::Forward {
            self.block.wrapping_add(1)
        } else {
            self.block.wrapping_sub(1)
        };
    }

    /// Folds one entry.
    pub(super) fn step(&mut self, parts: &mut Parts<'_>) {
        if self.remaining == 0 {
            return;
        }
        self.remaining -= 1;
        let slot = self.slot;
        let forward = self.direction == Direction::Forward;
        self.slot = wrapped(self.slot, 1, self.shape.edges, forward);
        self.block_left -= 1;
        let place = slot as usize;
        if let (Some(&cell), Some(sum)) = (parts.cells.get(place), parts.sum.get_mut(place)) {
            self.entry(slot, cell, sum);
        }
        if self.block_left == 0 {
            self.end_block(parts.coarse);
        }
    }

    /// Folds up to `most` of what is left.
    pub(super) fn steps(&mut self, parts: &mut Parts<'_>, most: u32) {
        for _ in 0..most.min(self.remaining) {
            self.step(parts);
        }
    }

    /// Folds all that is left.
    pub(super) fn finish(&mut self, parts: &mut Parts<'_>) {
        while self.remaining != 0 {
            self.step(parts);
        }
    }
}

/// The three coarse sums: all turns alike, alike but with the contrast's signs, and with the sum's weights and signs.
pub(super) fn thirds(coarse: &mut [i32]) -> [&mut [i32]; 3] {
    let (even, rest) = coarse.split_at_mut(coarse.len() / 3);
    let (even_contrast, contrast) = rest.split_at_mut(rest.len() / 2);
    [even, even_contrast, contrast]
}

/// Upper word of a product.
#[inline]
#[allow(clippy::cast_possible_truncation)]
fn high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}
