//! From the sums of all turns to a table: close the turn, tell torque from geometry, weigh every order, draw the result.

use super::close::{SumScale, close_sum, largest_error, saturated, take_class_means};
use super::draw::{Believed, draw};
use super::fold::thirds;
use super::moments::{Mean, Moments};
use super::noise::{common_noise, damping_square_q16, settle_noise};
use super::order::{LockedOrder, ORDERS_MAX, OrderPlan};
use super::pack::{pack, with_offsets};
use super::power::{single_sizes, split_orders};
use super::scale::Fine;
use super::separate::{Doubt, separate};
use super::solution::{Found, Solution, SolveError};
use super::spectrum::{Coefficient, Sample};
use super::speeds::Speeds;
use super::transform::add_orders;
use super::weigh::{Estimate, WEIGHT_ONE, weigh};
use super::{EdgeBuffers, Estimator, Parts};
use crate::shape::CLASSES_MAX;
use crate::units::TurnDelta32;

impl<B: EdgeBuffers> Estimator<B> {
    /// Solves for the table with the turns taken so far. Not on the edge path.
    ///
    /// # Errors
    /// [`SolveError::TooFewTurns`] with fewer than two turns.
    #[inline]
    pub fn solve(mut self) -> Result<Solution<B>, SolveError> {
        let found = self.find()?;
        Ok(Solution {
            found,
            buffers: self.buffers,
        })
    }

    #[inline]
    fn find(&mut self) -> Result<Found, SolveError> {
        self.interrupt();
        let totals = self.totals;
        if totals.turns < 2 {
            return Err(SolveError::TooFewTurns(totals.turns));
        }
        let classes = self.shape.classes() as usize;
        let plan = self.plan();
        let moments = Moments::of(&self.speeds, &self.weighing, self.totals.two_speeds());
        let mut parts = self.buffers.parts();
        let unit_shift = self.fold.shape.unit_shift;
        let fine = close(&mut parts, plan, &moments, &self.speeds, unit_shift);
        let mut offsets = take_class_means(parts.sum, classes);

        let mut noise = [0; ORDERS_MAX];
        let mut doubt = [0; ORDERS_MAX];
        let mut own = [0; ORDERS_MAX];
        let mut difference = [Coefficient::default(); ORDERS_MAX];
        let [even, even_contrast, contrast] = blocks(&mut parts, plan);
        for (blocks, powers) in [(even_contrast, &mut doubt), (contrast, &mut noise)] {
            single_sizes(blocks, plan, &mut difference);
            for (power, size) in powers.iter_mut().zip(&difference) {
                *power = size.power();
            }
        }
        single_sizes(even, plan, &mut difference);
        let speeds = &self.speeds;
        let (common_noise, low_pairs) = settle(
            plan, &moments, speeds, &mut noise, &mut doubt, &mut own, fine,
        );
        let mut coefficients = [Coefficient::default(); ORDERS_MAX];
        let common = if plan.decimation == 1 {
            split_orders(parts.sum, parts.coarse, plan, &mut coefficients)
        } else {
            let scratch = parts.cells.as_chunks_mut().0;
            split_orders(parts.sum, scratch, plan, &mut coefficients)
        };
        let torques = separate(
            plan,
            &moments,
            &mut coefficients,
            &mut noise,
            &mut difference,
            Doubt {
                noise: &doubt,
                damping_square_q16: damping_square_q16(&self.speeds),
            },
            fine,
        );
        let estimate = Estimate {
            coefficients: &coefficients,
            common,
            noise: &noise,
            own: &own,
            common_noise,
            low_pairs,
            turn: 1 << (32 + fine.bits),
            untold: torques.untold,
            knowledge: self.knowledge,
        };
        // The doubt about torque has been used.
        let weights = weigh(plan, &estimate, &mut doubt);
        let locked = weights.standing.iter().map(|standing| LockedOrder {
            order: standing.order,
            amplitude: fine.root_mean_square(standing.power.saturating_mul(4)),
        });
        let locked = locked.collect();

        // What is to be added to the weighed mean: w_n g_n - w_common c_n, of which the difference holds g_n - c_n.
        let weight = |w: u32| i64::from(w) << 15;
        let geometry = |n: usize| coefficients[n].scaled(weight(weights.single[n].into()));
        for (n, more) in difference.iter_mut().enumerate().take(plan.single) {
            let single = geometry(n);
            let mean = coefficients[n].minus(*more).scaled(weight(weights.common));
            *more = single.minus(mean);
        }
        let delays = self.delays.solve(&self.fold.shape, self.speeds.reference());
        if let Some(delays) = &delays {
            delays.take_from(&mut offsets, moments.mean_speed_q16(&self.speeds), fine);
        }
        redraw(
            &mut parts,
            plan,
            &difference,
            &Believed {
                common: weights.common,
                mounting: [geometry(0), geometry(1)],
                offsets: &offsets,
            },
            fine,
        );

        let mut class_offsets = [TurnDelta32(0); CLASSES_MAX];
        for (angle, offset) in class_offsets.iter_mut().zip(offsets) {
            *angle = TurnDelta32(fine.angle(offset));
        }
        let (shift, table_rms) = pack(&mut parts, fine, &class_offsets, classes);
        let residual = fine.root_mean_square(weights.residual);
        #[cfg(feature = "defmt")]
        defmt::info!(
            "solved from {=u32} turns: table {=u32} RMS, standard error {=u32} (2^-32 turn), {=usize} orders left alone",
            totals.turns,
            table_rms,
            residual,
            weights.standing.len()
        );
        #[allow(clippy::cast_possible_truncation)]
        Ok(Found {
            shape: self.shape,
            turns: totals.turns,
            class_offsets,
            // Never below one unit, to which the offsets are rounded.
            class_error: fine
                .root_mean_square(common_noise.saturating_mul(u64::from(self.shape.classes())))
                .max(1),
            shift,
            residual,
            table_rms,
            uncorrected: with_offsets(
                fine.root_mean_square(weights.uncorrected),
                &class_offsets[..classes],
            ),
            single: weights.single,
            single_count: plan.single,
            common: weights.common.min(WEIGHT_ONE - 1) as u16,
            locked,
            torques,
            reference: self.speeds.reference(),
            delays,
        })
    }
}

impl<B> Estimator<B> {
    /// How this encoder's orders are split.
    pub(super) fn plan(&self) -> OrderPlan {
        let edges = self.shape.edges() as usize;
        let block = self.fold.shape.block as usize;
        OrderPlan::new(edges, self.shape.lines() as usize, edges / block)
    }
}

/// From the powers of both contrasts to the noise of the weighed mean and of what the plain mean differs from it; returns
/// the noise of the orders above, and how many pairs of turns that of the lowest rests on.
#[inline(never)]
fn settle(
    plan: OrderPlan,
    moments: &Moments,
    speeds: &Speeds,
    noise: &mut [u64; ORDERS_MAX],
    doubt: &mut [u64; ORDERS_MAX],
    own: &mut [i16; ORDERS_MAX],
    fine: Fine,
) -> (u64, u32) {
    let shares = moments.shares(Mean::Weighed);
    let signed = moments.contrast(Mean::Weighed, speeds);
    let more = moments.shares(Mean::Plain).minus(&shares);
    let more_signed = moments.contrast(Mean::Plain, speeds).minus(&signed);
    settle_noise(plan, doubt, own, speeds, &more, &more_signed, fine);
    let low_pairs = settle_noise(plan, noise, own, speeds, &shares, &signed, fine);
    let common = common_noise(plan, speeds, &shares, noise[plan.single - 1], fine);
    (common, low_pairs)
}

/// The coarse sums of the blocks there are.
fn blocks<'a>(parts: &'a mut Parts<'_>, plan: OrderPlan) -> [&'a mut [i32]; 3] {
    thirds(parts.coarse).map(|third| &mut third[..plan.blocks])
}

/// Closes all sums; leaves in the coarse ones the plain mean less the weighed one, its contrast, and the contrast of the
/// weighed mean, with what repeats taken out of the contrasts.
#[inline(never)]
fn close(
    parts: &mut Parts<'_>,
    plan: OrderPlan,
    moments: &Moments,
    speeds: &Speeds,
    unit_shift: u32,
) -> Fine {
    let scale = |weight_q16| SumScale {
        unit_shift,
        weight_q16,
    };
    let (weighed, plain) = (
        scale(moments.weight_q16),
        scale(u64::from(moments.turns) << 16),
    );
    let sum = &mut *parts.sum;
    let [even, even_contrast, contrast] =
        thirds(parts.coarse).map(|third| &mut third[..plan.blocks]);
    for third in [&mut *even, &mut *even_contrast, &mut *contrast] {
        third.rotate_right(1);
    }
    let fine = Fine::for_angles(largest_error(sum, weighed).max(largest_error(even, plain)));
    close_sum(sum, weighed, fine);
    close_sum(even, plain, fine);
    close_sum(even_contrast, plain, fine);
    close_sum(contrast, weighed, fine);
    let leftover = |mean| moments.leftover(mean, speeds).map(i128::from);
    let (of_plain, of_weighed) = (leftover(Mean::Plain), leftover(Mean::Weighed));
    let block = plan.edges / plan.blocks;
    let at_blocks = sum.iter().step_by(block).map(|&error| i64::from(error));
    let signed = even_contrast.iter_mut().zip(contrast);
    for ((weighed, even), (even_contrast, contrast)) in at_blocks.zip(even).zip(signed) {
        let plain = i64::from(*even);
        let repeats = |[a, b]: [i128; 2]| {
            #[allow(clippy::cast_possible_truncation)]
            let repeats = ((a * i128::from(weighed) + b * i128::from(plain)) >> 30) as i64;
            repeats
        };
        let signed = i64::from(*contrast) - repeats(of_weighed);
        let plain_signed = i64::from(*even_contrast) - repeats(of_plain);
        *even = saturated(plain - weighed);
        *even_contrast = saturated(plain_signed - signed);
        *contrast = saturated(signed);
    }
    fine
}

/// Draws the orders in `more` over the weighed mean.
#[inline(never)]
fn redraw(
    parts: &mut Parts<'_>,
    plan: OrderPlan,
    more: &[Coefficient; ORDERS_MAX],
    believed: &Believed<'_>,
    fine: Fine,
) {
    let samples = plan.edges / plan.decimation;
    if plan.decimation == 1 {
        let grid = &mut parts.coarse[..samples];
        draw_orders(grid, plan, more);
        draw(parts.sum, grid, believed, plan, fine);
    } else {
        let grid = &mut parts.cells.as_chunks_mut().0[..samples];
        draw_orders(grid, plan, more);
        draw(parts.sum, grid, believed, plan, fine);
    }
}

fn draw_orders<S: Sample>(grid: &mut [S], plan: OrderPlan, more: &[Coefficient; ORDERS_MAX]) {
    grid.fill(S::of(0));
    add_orders(grid, &more[..plan.single]);
}
