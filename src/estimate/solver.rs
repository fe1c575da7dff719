//! What solving has come to between two slices.

use super::close::{ClassMeans, Closing};
use super::contrast::{Contrasting, Leftovers};
use super::course::{Curve, Straightening};
use super::cursor::Cursor;
use super::damping::DampingFit;
use super::delays::{DelayFit, SolvedDelays};
use super::draw::Drawing;
use super::locked::NoiseShares;
use super::moments::{MeanSpeed, Moments};
use super::order::{ORDERS_MAX, OrderPlan};
use super::pack::{Packed, Packing};
use super::power::SplitOrders;
use super::scale::Fine;
use super::separate::{Orders, Separation, Torques};
use super::settle::{Settled, Settling};
use super::spectrum::Coefficient;
use super::transform::TakeOrders;
use super::weigh::{Weighting, Weights};
use crate::shape::CLASSES_MAX;

/// Memory that [`Estimator::slice`](super::Estimator::slice) works with: 11 KiB, best kept as a `static`. Once it has solved, or
/// was given up, it is of no use to the next estimator before [`Solver::restart`].
pub struct Solver {
    pub(super) stage: Stage,
    pub(super) plan: OrderPlan,
    pub(super) moments: Moments,
    /// Of a time stamp, as [`jitter_q16`](super::noise::jitter_q16) has it.
    pub(super) jitter_q16: u128,
    pub(super) noise_shares: NoiseShares,
    pub(super) fine: Fine,
    pub(super) leftovers: Leftovers,
    /// What the weighed and the plain mean hold of the speed's own course.
    pub(super) curves: [Curve; 2],
    pub(super) orders: Orders,
    /// Means of the classes, in fine angles.
    pub(super) offsets: [i32; CLASSES_MAX],
    pub(super) settled: Settled,
    /// Power of the orders above the single ones.
    pub(super) common: u64,
    pub(super) torques: Torques,
    pub(super) weights: Weights,
    pub(super) delays: Option<SolvedDelays>,
}

/// What is to be done next; every stage goes on in slices.
// What one part works with takes the place of the last one's.
#[allow(clippy::large_enum_variant)]
// With a tag of its own the first one is 0, and a static solver, all zeros, takes no flash.
#[repr(u8)]
pub(super) enum Stage {
    Begin,
    /// What waits to be folded is.
    Fold,
    Close(Closing),
    Contrast(Contrasting),
    /// The speed's own course is taken out of the weighed mean.
    Straighten(Straightening),
    ClassMeans(ClassMeans),
    /// What of the turns' scatter is noise.
    Scatter,
    /// The orders of a coarse sum are taken.
    Take(Coarse, TakeOrders),
    Settle(Settling),
    Split(SplitOrders),
    Damp(DampingFit),
    Separate(Separation),
    Weigh(Weighting),
    /// What is to be drawn over the weighed mean, order by order.
    Differ(Cursor),
    Delays(DelayFit),
    /// Delays are taken out of the class offsets, at the mean speed.
    Undelay(MeanSpeed),
    Draw(Drawing),
    Pack(Packing),
    Done(Packed),
}

/// A coarse sum, once it is closed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Coarse {
    /// Contrast of what the plain mean differs from the weighed one: the noise of that.
    PlainContrast,
    /// Contrast of the weighed mean: its noise.
    Contrast,
    /// The plain mean less the weighed one.
    Difference,
}

impl Solver {
    /// With nothing done.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            stage: Stage::Begin,
            plan: OrderPlan::NONE,
            moments: Moments::NONE,
            jitter_q16: 0,
            noise_shares: NoiseShares::START,
            fine: Fine { bits: 0 },
            leftovers: Leftovers {
                plain: [0; 2],
                weighed: [0; 2],
            },
            curves: [Curve::NONE; 2],
            orders: Orders {
                coefficients: [Coefficient::ZERO; ORDERS_MAX],
                noise: [0; ORDERS_MAX],
                own: [0; ORDERS_MAX],
                difference: [Coefficient::ZERO; ORDERS_MAX],
                doubt: [0; ORDERS_MAX],
            },
            offsets: [0; CLASSES_MAX],
            settled: Settled {
                common: 0,
                low_pairs: 0,
            },
            common: 0,
            torques: Torques::NONE,
            weights: Weights::NONE,
            delays: None,
        }
    }

    /// Forgets what was done: the next slice is another solution's first.
    pub fn restart(&mut self) {
        self.stage = Stage::Begin;
    }

    /// How much is done, per cent, by the instructions that the stages take with 10,000 edges.
    pub(super) fn percent(&self) -> u8 {
        match self.stage {
            Stage::Begin | Stage::Fold => 0,
            Stage::Close(_) => 1,
            Stage::Contrast(_) | Stage::Straighten(_) | Stage::ClassMeans(_) | Stage::Scatter => 7,
            Stage::Take(Coarse::PlainContrast, _) => 10,
            Stage::Take(Coarse::Contrast, _) => 20,
            Stage::Take(Coarse::Difference, _) => 30,
            Stage::Settle(_) => 40,
            Stage::Split(_) => 50,
            Stage::Damp(_) | Stage::Separate(_) => 65,
            Stage::Weigh(_) => 67,
            Stage::Differ(_) | Stage::Delays(_) | Stage::Undelay(_) => 75,
            Stage::Draw(_) => 78,
            Stage::Pack(_) => 97,
            Stage::Done(_) => 99,
        }
    }
}

impl Default for Solver {
    fn default() -> Self {
        Self::new()
    }
}
