//! From the sums of all turns to a table: close the turn, tell torque from geometry, weigh every order, draw the result.

use core::task::{Poll, ready};

use super::close::{ClassMeans, Closing, Scales, SumScale};
use super::contrast::Contrasting;
use super::course::Straightening;
use super::cursor::Cursor;
use super::damping::DampingFit;
use super::delays::DelayFit;
use super::draw::{Believed, Drawing};
use super::fold::thirds;
use super::locked::NoiseShares;
use super::moments::{MeanSpeed, Moments};
use super::noise::{Scatter, Stamp, jitter_q16};
use super::order::{LockedOrder, OrderPlan};
use super::pack::{Packed, Packing, with_offsets};
use super::power::{SplitOrders, single_sizes};
use super::scale::Fine;
use super::separate::Separation;
use super::settle::{Estimated, Known, Settling};
use super::solution::{Findings, Solution, SolveError};
use super::solver::{Coarse, Solver, Stage};
use super::spectrum::Coefficient;
use super::transform::TakeOrders;
use super::weigh::{Estimate, WEIGHT_ONE, Weighting};
use super::{EdgeBuffers, Estimator, Parts, Totals};
use crate::shape::CLASSES_MAX;
use crate::units::TurnDelta32;

/// Edges of a slice that are folded.
const FOLDED: u32 = 100;

/// Orders of a slice whose drawing is prepared.
const DIFFERED: usize = 16;

/// What a slice of solving came to.
// There is no heap to keep it small with.
#[allow(clippy::large_enum_variant)]
pub enum Slice {
    /// There is more to do; how much is done, per cent.
    More(u8),
    /// The table is solved for; [`Estimator::finish`] takes this.
    Solved(Findings),
}

impl<B: EdgeBuffers> Estimator<B> {
    /// Solves for the table with the turns taken so far. Not on the edge path; [`Estimator::slice`] does the same piece by piece.
    ///
    /// # Errors
    /// [`SolveError::TooFewTurns`] with fewer than two turns.
    #[inline(never)]
    pub fn solve(mut self) -> Result<Solution<B>, SolveError> {
        let mut solver = Solver::new();
        loop {
            if let Slice::Solved(findings) = self.slice(&mut solver)? {
                return Ok(self.finish(findings));
            }
        }
    }

    /// Solves for a part, in fewer than 20,000 instructions of a Cortex-M4, so that edges are served in between. From the first slice on
    /// the estimator learns no more: what is pushed spoils the solution. To be called until [`Slice::Solved`] comes.
    ///
    /// # Errors
    /// [`SolveError::TooFewTurns`] at the first slice, with fewer than two turns; the estimator goes on learning.
    pub fn slice(&mut self, solver: &mut Solver) -> Result<Slice, SolveError> {
        match &solver.stage {
            Stage::Begin => self.begin(solver)?,
            Stage::Done(packed) => return Ok(Slice::Solved(self.findings(solver, *packed))),
            _ => {
                let _ = self.advance(solver);
            }
        }
        Ok(Slice::More(solver.percent()))
    }

    /// The solution that the last slice found.
    #[must_use]
    pub fn finish(self, findings: Findings) -> Solution<B> {
        Solution {
            findings,
            buffers: self.buffers,
        }
    }

    fn begin(&mut self, solver: &mut Solver) -> Result<(), SolveError> {
        if self.totals.turns < 2 {
            return Err(SolveError::TooFewTurns(self.totals.turns));
        }
        self.lose_track();
        solver.plan = self.plan();
        solver.moments = Moments::of(&self.speeds, &self.weighing, self.totals.two_speeds());
        solver.noise_shares = NoiseShares::START;
        solver.torques.clear();
        solver.stage = Stage::Fold;
        Ok(())
    }

    /// A slice of a stage; once that is over, the next begins.
    #[inline(never)]
    fn advance(&mut self, solver: &mut Solver) -> Poll<()> {
        let Solver {
            stage,
            plan,
            moments,
            jitter_q16: jitter,
            noise_shares,
            fine,
            leftovers,
            curves,
            orders,
            offsets,
            settled,
            common,
            torques,
            weights,
            delays,
        } = solver;
        let (plan, fine_now) = (*plan, *fine);
        let classes = self.shape.classes() as usize;
        let mut parts = self.buffers.parts();
        let speeds = &self.speeds;
        match stage {
            Stage::Begin | Stage::Done(_) => {}
            Stage::Fold => {
                self.fold.steps(&mut parts, FOLDED);
                if !self.fold.is_idle() {
                    return Poll::Pending;
                }
                self.settle_fold();
                go_to(stage, || Stage::Close(Closing::new()));
            }
            Stage::Close(closing) => {
                let scales = scales(moments, self.fold.shape.unit_shift);
                *fine = ready!(closing.slice(&mut parts, plan, scales));
                *curves = self.course.curves(moments.weight_q16, moments.turns, *fine);
                go_to(stage, || Stage::Contrast(Contrasting::default()));
            }
            Stage::Contrast(contrasting) => {
                let [weighed, plain] = *curves;
                let bent = plain.less(weighed);
                *leftovers = ready!(contrasting.slice(&mut parts, plan, moments, speeds, bent));
                go_to(stage, || Stage::Straighten(Straightening::new(weighed)));
            }
            Stage::Straighten(straightening) => {
                ready!(straightening.slice(parts.sum));
                go_to(stage, || Stage::ClassMeans(ClassMeans::new()));
            }
            Stage::ClassMeans(means) => {
                *offsets = ready!(means.slice(parts.sum, classes));
                *jitter = jitter_q16(plan, speeds);
                go_to(stage, || Stage::Scatter);
            }
            Stage::Scatter => {
                ready!(noise_shares.slice(&speeds.locked));
                go_to(stage, || {
                    Stage::Take(Coarse::PlainContrast, TakeOrders::START)
                });
            }
            Stage::Take(coarse, take) => {
                let third = coarse_sum(&mut parts, plan, *coarse);
                ready!(single_sizes(take, third, plan, &mut orders.difference));
                let powers = match coarse {
                    Coarse::PlainContrast => &mut orders.doubt,
                    Coarse::Contrast => &mut orders.noise,
                    Coarse::Difference => {
                        go_to(stage, || Stage::Settle(Settling::of(Estimated::Difference)));
                        return Poll::Ready(());
                    }
                };
                for (power, size) in powers.iter_mut().zip(&orders.difference) {
                    *power = size.power();
                }
                let next = match coarse {
                    Coarse::PlainContrast => Coarse::Contrast,
                    _ => Coarse::Difference,
                };
                go_to(stage, || Stage::Take(next, TakeOrders::START));
            }
            Stage::Settle(settling) => {
                let known = Known {
                    plan,
                    moments,
                    leftovers: *leftovers,
                    speeds,
                    noise_shares,
                    jitter_q16: *jitter,
                    fine: fine_now,
                };
                match settling.estimated() {
                    Estimated::Difference => {
                        ready!(settling.slice(known, &mut orders.doubt, &mut orders.own));
                        go_to(stage, || Stage::Settle(Settling::of(Estimated::Weighed)));
                    }
                    Estimated::Weighed => {
                        *settled =
                            ready!(settling.slice(known, &mut orders.noise, &mut orders.own));
                        go_to(stage, || Stage::Split(SplitOrders::START));
                    }
                }
            }
            Stage::Split(split) => {
                let sizes = &mut orders.coefficients;
                *common = ready!(if plan.decimation == 1 {
                    split.slice(parts.sum, parts.coarse, plan, sizes)
                } else {
                    let scratch = parts.cells.as_chunks_mut().0;
                    split.slice(parts.sum, scratch, plan, sizes)
                });
                let falls = self.course.falls(moments.weight_q16, moments.turns);
                go_to(stage, || Stage::Damp(DampingFit::new(falls)));
            }
            Stage::Damp(fit) => {
                let Totals {
                    shortest, longest, ..
                } = self.totals;
                let fine = Fine { bits: 0 };
                let scatter = Scatter {
                    speeds,
                    noise: noise_shares,
                    stamp: Stamp::of(plan, *jitter, fine),
                    fine,
                };
                let shaft = ready!(fit.slice(&self.damped, scatter, [shortest, longest]));
                go_to(stage, || Stage::Separate(Separation::new(moments, shaft)));
            }
            Stage::Separate(separation) => {
                ready!(separation.slice(plan, orders, fine_now, torques));
                go_to(stage, || Stage::Weigh(Weighting::START));
            }
            Stage::Weigh(weighting) => {
                let estimate = Estimate {
                    coefficients: &orders.coefficients,
                    common: *common,
                    noise: &orders.noise,
                    own: &orders.own,
                    common_noise: settled.common,
                    low_pairs: settled.low_pairs,
                    turn: 1 << (32 + fine_now.bits),
                    untold: torques.untold,
                    hidden: torques.hidden,
                    knowledge: self.knowledge,
                };
                // The doubt about torque has been used.
                ready!(weighting.slice(plan, &estimate, &mut orders.doubt, weights));
                go_to(stage, || Stage::Differ(Cursor::START));
            }
            Stage::Differ(cursor) => {
                // What is to be added to the weighed mean: w_n g_n - w_common c_n, of which the difference holds g_n - c_n.
                for n in cursor.next(DIFFERED, plan.single) {
                    let geometry = orders.coefficients[n];
                    let mean = geometry.minus(orders.difference[n]);
                    orders.difference[n] = weighed(geometry, weights.single[n].into())
                        .minus(weighed(mean, weights.common));
                }
                ready!(cursor.at_end(plan.single));
                go_to(stage, || Stage::Delays(DelayFit::START));
            }
            Stage::Delays(fit) => {
                *delays = ready!(fit.slice(&self.delays, &self.fold.shape, speeds.reference()));
                go_to(stage, || Stage::Undelay(MeanSpeed::default()));
            }
            Stage::Undelay(mean) => {
                if let Some(delays) = delays {
                    let speed_q16 = ready!(mean.slice(moments, speeds));
                    delays.take_from(offsets, speed_q16, fine_now);
                }
                go_to(stage, || Stage::Draw(Drawing::START));
            }
            Stage::Draw(drawing) => {
                let geometry = |n: usize| weighed(orders.coefficients[n], weights.single[n].into());
                let believed = Believed {
                    common: weights.common,
                    mounting: [geometry(0), geometry(1)],
                    offsets,
                };
                let more = &orders.difference[..plan.single];
                let samples = plan.edges / plan.decimation;
                ready!(if plan.decimation == 1 {
                    let grid = &mut parts.coarse[..samples];
                    drawing.slice(parts.sum, grid, more, believed, plan, fine_now)
                } else {
                    let grid = &mut parts.cells.as_chunks_mut().0[..samples];
                    drawing.slice(parts.sum, grid, more, believed, plan, fine_now)
                });
                go_to(stage, || Stage::Pack(Packing::default()));
            }
            Stage::Pack(packing) => {
                let offsets = class_offsets(offsets, fine_now);
                let packed = ready!(packing.slice(&mut parts, fine_now, &offsets, classes));
                *stage = Stage::Done(packed);
            }
        }
        Poll::Ready(())
    }

    #[inline(never)]
    fn findings(&self, solver: &Solver, packed: Packed) -> Findings {
        let Solver { fine, weights, .. } = solver;
        let classes = self.shape.classes();
        let class_offsets = class_offsets(&solver.offsets, *fine);
        let locked = weights.standing.iter().map(|standing| LockedOrder {
            order: standing.order,
            amplitude: fine.root_mean_square(standing.power.saturating_mul(4)),
        });
        let residual = fine.root_mean_square(weights.residual);
        #[cfg(feature = "defmt")]
        defmt::info!(
            "solved from {=u32} turns: table {=u32} RMS, standard error {=u32} (2^-32 turn), {=usize} orders left alone",
            self.totals.turns,
            packed.rms,
            residual,
            weights.standing.len()
        );
        let class_noise = solver.settled.common.saturating_mul(classes.into());
        #[allow(clippy::cast_possible_truncation)]
        Findings {
            shape: self.shape,
            turns: self.totals.turns,
            class_offsets,
            // Never below one unit, to which the offsets are rounded.
            class_error: fine.root_mean_square(class_noise).max(1),
            shift: packed.shift,
            residual,
            table_rms: packed.rms,
            uncorrected: with_offsets(
                fine.root_mean_square(weights.uncorrected),
                &class_offsets[..classes as usize],
            ),
            single: weights.single,
            single_count: solver.plan.single,
            common: weights.common.min(WEIGHT_ONE - 1) as u16,
            locked: locked.collect(),
            torques: solver.torques.strongest.clone(),
            reference: self.speeds.reference(),
            delays: solver.delays,
        }
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

fn scales(moments: &Moments, unit_shift: u32) -> Scales {
    let of_weight = |weight_q16| SumScale {
        unit_shift,
        weight_q16,
    };
    Scales {
        weighed: of_weight(moments.weight_q16),
        plain: of_weight(u64::from(moments.turns) << 16),
    }
}

/// Begins a stage, which is built on the stack first: not on that of the slices to come.
#[inline(never)]
fn go_to(stage: &mut Stage, next: impl FnOnce() -> Stage) {
    *stage = next();
}

/// A coarse sum at the blocks there are.
fn coarse_sum<'a>(parts: &'a mut Parts<'_>, plan: OrderPlan, coarse: Coarse) -> &'a [i32] {
    let [difference, plain_contrast, contrast] = thirds(parts.coarse);
    let third = match coarse {
        Coarse::Difference => difference,
        Coarse::PlainContrast => plain_contrast,
        Coarse::Contrast => contrast,
    };
    &third[..plan.blocks]
}

fn weighed(size: Coefficient, weight: u32) -> Coefficient {
    size.scaled(i64::from(weight) << 15)
}

fn class_offsets(offsets: &[i32; CLASSES_MAX], fine: Fine) -> [TurnDelta32; CLASSES_MAX] {
    offsets.map(|offset| TurnDelta32(fine.angle(offset)))
}
