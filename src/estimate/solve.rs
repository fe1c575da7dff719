//! From the sums of all turns to a table: close the turn, take the class means, weigh every order, scale to angle.

use super::close::{close_contrast, close_sum, take_class_means};
use super::modulation::undo_modulation;
use super::order::{LockedOrder, ORDERS_MAX, OrderPlan};
use super::power::{Powers, scale_contrast, split_orders};
use super::scale::AngleScale;
use super::solution::{Solution, SolveError};
use super::spectrum::{COEFFICIENT_BITS, Coefficient, Sequence, add_order};
use super::weigh::{WEIGHT_ONE, weigh};
use super::{EdgeBuffers, Estimator};
use crate::shape::CLASSES_MAX;
use crate::units::{STEP_FRACTION_BITS, TurnDelta32};

impl<B: EdgeBuffers> Estimator<B> {
    /// Solves for the table with the turns taken so far. Not on the edge path.
    ///
    /// # Errors
    /// [`SolveError::TooFewTurns`] with fewer than two turns.
    pub fn solve(mut self) -> Result<Solution<B>, SolveError> {
        self.leave_lockstep();
        self.settle_bend(None);
        self.fold.finish(&mut self.buffers, self.shape.edges());
        let totals = self.totals;
        if totals.turns < 2 {
            return Err(SolveError::TooFewTurns(totals.turns));
        }
        let plan = OrderPlan::new(self.shape.edges() as usize, self.shape.lines() as usize);
        close_sum(self.buffers.sum(), &totals);
        close_contrast(&mut self.buffers, &totals);
        let offsets = take_class_means(self.buffers.sum(), plan);
        take_class_means(self.buffers.work(), plan);

        let mut coefficients = [Coefficient::default(); ORDERS_MAX];
        let common = split_orders(self.buffers.work(), plan, &mut coefficients);
        let mut noise = Powers::ZERO;
        noise.fill(&coefficients, common);
        scale_contrast(&mut noise, &totals);
        for index in 0..plan.edges {
            let value = self.buffers.sum()[index];
            self.buffers.work().set(index, value);
        }
        let common = split_orders(self.buffers.work(), plan, &mut coefficients);

        let grid = (u64::from(totals.turns) * plan.edges as u64) << STEP_FRACTION_BITS;
        // Torque ripple's angle goes with 1 / speed^2: turns of which one took half as long again as another tell.
        let one_speed = totals.longest < totals.shortest + totals.shortest / 2;
        let weights = weigh(
            plan,
            &coefficients,
            common,
            &mut noise,
            one_speed.then_some(grid),
        );

        let scale = AngleScale::new(grid.cast_signed() + totals.excess);
        let locked = weights.standing.iter().map(|standing| LockedOrder {
            order: standing.order,
            amplitude: scale.root_mean_square(standing.power.saturating_mul(4)),
        });
        let locked = locked.collect();
        let bits = self.weigh_orders(plan, &coefficients, &weights.single, weights.common);
        let step = i64::from(totals.turns) << STEP_FRACTION_BITS;
        let classes = self.shape.classes() as usize;
        let (errors, motion) = self.buffers.split();
        undo_modulation(errors, offsets, classes, motion, bits, step);
        let mut class_offsets = [TurnDelta32(0); CLASSES_MAX];
        for (angle, offset) in class_offsets.iter_mut().zip(offsets) {
            *angle = TurnDelta32(scale.angle(offset));
        }
        let (shift, table_rms) = self.pack_angles(scale, class_offsets);
        let residual = scale.root_mean_square(weights.residual);
        #[cfg(feature = "defmt")]
        defmt::info!(
            "solved from {=u32} turns: table {=u32} RMS, standard error {=u32} (2^-32 turn), {=usize} orders left alone",
            totals.turns,
            table_rms,
            residual,
            weights.standing.len()
        );
        #[allow(clippy::cast_possible_truncation)]
        Ok(Solution {
            shape: self.shape,
            buffers: self.buffers,
            turns: totals.turns,
            class_offsets,
            // Never below one unit, to which the offsets are rounded.
            class_error: scale
                .root_mean_square(noise.common.saturating_mul(u64::from(self.shape.classes())))
                .max(1),
            shift,
            residual,
            table_rms,
            single: weights.single,
            single_count: plan.single,
            common: weights.common.min(WEIGHT_ONE - 1) as u16,
            locked,
        })
    }

    /// Takes from every order in `sum` what is not believed, w_common x - sum over n of (w_common - w_n) c_n, and leaves what
    /// was taken, with its sign turned, in `work`; returns its fraction bits.
    fn weigh_orders(
        &mut self,
        plan: OrderPlan,
        coefficients: &[Coefficient],
        single: &[u16],
        common: u32,
    ) -> u32 {
        let work = self.buffers.work();
        for index in 0..plan.edges {
            work.set(index, 0);
        }
        let doubt = |index: usize| i64::from(single[index]) - i64::from(common);
        let largest: u64 = (0..plan.single)
            .map(|n| {
                let size = coefficients[n].re.unsigned_abs() + coefficients[n].im.unsigned_abs();
                (size * doubt(n).unsigned_abs()) >> 15
            })
            .sum();
        // Fraction bits for the running removal: as many as the largest possible sum leaves free.
        let free = ((2 * largest) >> COEFFICIENT_BITS)
            .max(1)
            .leading_zeros()
            .saturating_sub(34);
        let bits = free.min(COEFFICIENT_BITS);
        for order in (1..=plan.single).filter(|&n| !plan.is_class_order(n)) {
            let c = coefficients[order - 1];
            let factor = |x: i64| (x * doubt(order - 1)) >> 15;
            let factor = Coefficient {
                re: factor(c.re),
                im: factor(c.im),
            };
            // Below a 64th of a sum unit an order leaves no trace in the table.
            if factor.power() >= 16 {
                add_order(work, order, factor, COEFFICIENT_BITS - bits);
            }
        }
        for index in 0..plan.edges {
            let removed = i64::from(Sequence::get(self.buffers.work(), index));
            let entry = i64::from(self.buffers.sum()[index]);
            let kept = ((entry * i64::from(common)) >> 15) + ((removed + (1 << bits >> 1)) >> bits);
            #[allow(clippy::cast_possible_truncation)]
            {
                self.buffers.sum()[index] = kept as i32;
            }
        }
        bits
    }

    /// Scales `sum` to angle and packs it as 16-bit entries at the start of `work`; returns their shift, and the RMS of
    /// the whole table.
    fn pack_angles(
        &mut self,
        scale: AngleScale,
        class_offsets: [TurnDelta32; CLASSES_MAX],
    ) -> (u32, u32) {
        let mut largest = 0;
        let mut squares = 0_u128;
        for line in self.buffers.sum().chunks_mut(self.shape.classes() as usize) {
            for (entry, offset) in line.iter_mut().zip(class_offsets) {
                *entry = scale.angle(*entry);
                largest = largest.max(entry.unsigned_abs());
                let error = u128::from((i64::from(*entry) + i64::from(offset.0)).unsigned_abs());
                squares += error * error;
            }
        }
        let shift = (u32::BITS - largest.leading_zeros()).saturating_sub(15);
        let half = 1_i32 << shift >> 1;
        for index in 0..self.shape.edges() as usize {
            let rounded = self.buffers.sum()[index].saturating_add(half) >> shift;
            #[allow(clippy::cast_possible_truncation)]
            let packed = rounded.min(i32::from(i16::MAX)) as i16;
            self.buffers.work().as_flattened_mut()[index] = packed;
        }
        let table_rms = (squares / u128::from(self.shape.edges())).isqrt();
        (shift, u32::try_from(table_rms).unwrap_or(u32::MAX))
    }
}
