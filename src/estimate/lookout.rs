//! Works out an [`Outlook`] in slices, as turns are taken.

use core::task::{Poll, ready};

use super::cursor::{Cursor, whole};
use super::locked::NoiseShares;
use super::low::{LOW_BITS, LOW_ORDERS};
use super::moments::{Mean, Moments, Shares, torque_power_q24};
use super::noise::{LowSum, Scatter, Stamp, jitter_power, jitter_q16};
use super::order::OrderPlan;
use super::scale::Fine;
use super::spectrum::{COEFFICIENT_BITS, POWER_BITS};
use super::speeds::Speeds;
use super::{EdgeBuffers, Estimator, Outlook};
use crate::shape::CLASSES_MAX;
use crate::wide::{over, over_signed};

/// Pairs of turns that say how good a mean is: with fewer it looks better by chance too often.
const PAIRS_MIN: u16 = 5;

/// Units of the powers here.
const FINE: Fine = Fine { bits: LOW_BITS };

/// An [`Outlook`] that is being worked out, slice by slice.
pub struct Lookout {
    part: Part,
    plan: OrderPlan,
    moments: Moments,
    shares: Shares,
    jitter_q16: u128,
    stamp: Stamp,
    noise_shares: NoiseShares,
    /// Powers at every order: of time stamps' jitter, and of geometry.
    jitter: u64,
    geometry: u64,
    /// Mean of the lowest orders' torque times the order's fourth power.
    slope: u64,
    /// Sums over the orders of what is left now, and after twice as many turns.
    now: u128,
    twice: u128,
    cursor: Cursor,
}

enum Part {
    Begin,
    Jitter,
    /// What of the turns' scatter is noise.
    Scatter,
    Geometry([[i64; 2]; CLASSES_MAX]),
    Level(LowLevel),
    Low(u128, LowSum),
    Orders,
}

/// Torque that the turns compared show at one of the lowest orders.
struct LowLevel {
    index: usize,
    seen: u128,
    torque: u128,
    /// The next bin to look at.
    bin: usize,
}

/// Edges and orders of a slice.
const EDGES: usize = 500;

/// Lines of a slice at the most: with few classes they cost more than their edges.
const LINES: usize = 250;
const ORDERS: usize = 4;

impl Lookout {
    /// With nothing done.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            part: Part::Begin,
            plan: OrderPlan::NONE,
            moments: Moments::NONE,
            shares: Shares::NONE,
            jitter_q16: 0,
            stamp: Stamp::NONE,
            noise_shares: NoiseShares::START,
            jitter: 0,
            geometry: 0,
            slope: 0,
            now: 0,
            twice: 0,
            cursor: Cursor::START,
        }
    }

    /// Adds what is left of an order with so much torque noise.
    fn add(&mut self, order: usize, torque: u64, may_be_torque: bool) {
        let noise = torque.saturating_add(self.jitter);
        // Eccentricity and tilt are taken as they show, whatever their size; of the rest no more is left than there is.
        let size = if order <= 2 && !may_be_torque {
            u64::MAX
        } else {
            self.geometry
        };
        self.now += 2 * u128::from(left(noise, size));
        self.twice += 2 * u128::from(left(noise / 2, size));
    }

    /// Adds the orders above the single ones.
    fn add_common(&mut self) {
        let above = self.plan.edges.saturating_sub(2 * self.plan.single) as u128;
        self.now += above * u128::from(left(self.jitter, self.geometry));
        self.twice += above * u128::from(left(self.jitter / 2, self.geometry));
    }
}

impl Default for Lookout {
    fn default() -> Self {
        Self::new()
    }
}

fn scatter<'a>(speeds: &'a Speeds, noise: &'a NoiseShares, stamp: Stamp) -> Scatter<'a> {
    Scatter {
        speeds,
        noise,
        stamp,
        fine: FINE,
    }
}

impl LowLevel {
    const fn of(index: usize) -> Self {
        Self {
            index,
            seen: 0,
            torque: 0,
            bin: 0,
        }
    }

    /// In the end, the level over that of a turn of the first one's speed, Q24.
    fn slice(&mut self, scatter: Scatter<'_>) -> Poll<u128> {
        let Some((b, bin)) = scatter.speeds.taken().find(|(b, _)| *b >= self.bin) else {
            return Poll::Ready(over(self.seen << 24, self.torque));
        };
        self.bin = b + 1;
        let pairs = u128::from(bin.pairs);
        self.seen += u128::from(scatter.low_power(b, self.index, 0)) * pairs;
        self.torque += u128::from(torque_power_q24(b)) * pairs;
        Poll::Pending
    }
}

impl<B: EdgeBuffers> Estimator<B> {
    /// What the turns taken so far let expect; none before six turns of like speed came in a row. Right after
    /// [`Progress::TurnTaken`](super::Progress), not on the edge path: some 700,000 instructions at 10,000 edges. [`Estimator::look_out`] does the
    /// same piece by piece.
    #[must_use]
    #[inline(never)]
    pub fn outlook(&mut self) -> Option<Outlook> {
        let mut lookout = Lookout::new();
        whole(|| self.look_out(&mut lookout))
    }

    /// A part of [`Estimator::outlook`], in fewer than 20,000 instructions of a Cortex-M4; begun with a new [`Lookout`], and to be called
    /// until it is ready. Edges may be pushed in between; turns that are taken meanwhile may count or not.
    pub fn look_out(&mut self, lookout: &mut Lookout) -> Poll<Option<Outlook>> {
        let speeds = &self.speeds;
        match &mut lookout.part {
            Part::Begin => {
                if !speeds.bins.iter().any(|bin| bin.pairs >= PAIRS_MIN) {
                    return Poll::Ready(None);
                }
                lookout.plan = self.plan();
                lookout.moments = Moments::of(speeds, &self.weighing, self.totals.two_speeds());
                lookout.jitter_q16 = jitter_q16(lookout.plan, speeds);
                lookout.part = Part::Jitter;
            }
            Part::Jitter => {
                lookout.shares = lookout.moments.shares(Mean::Weighed);
                let (plan, jitter_q16) = (lookout.plan, lookout.jitter_q16);
                lookout.jitter = jitter_power(plan, speeds, &lookout.shares, jitter_q16, FINE);
                lookout.stamp = Stamp::of(plan, jitter_q16, FINE);
                lookout.part = Part::Scatter;
            }
            Part::Scatter => {
                ready!(lookout.noise_shares.slice(&speeds.locked));
                lookout.part = Part::Geometry([[0; 2]; CLASSES_MAX]);
            }
            Part::Geometry(of_class) => {
                let classes = self.shape.classes() as usize;
                let sum = self.buffers.parts().sum;
                let lines = sum.len() / classes;
                let stretch = lookout.cursor.next((EDGES / classes).min(LINES), lines);
                add_steps(
                    &sum[stretch.start * classes..stretch.end * classes],
                    of_class,
                    classes,
                );
                if !stretch.is_empty() {
                    return Poll::Pending;
                }
                let power = self.geometry_power(of_class, lookout.moments.weight_q16);
                lookout.geometry = power.saturating_sub(lookout.jitter);
                lookout.part = Part::Level(LowLevel::of(0));
            }
            Part::Level(level) => {
                let scatter = scatter(speeds, &lookout.noise_shares, lookout.stamp);
                let level_q24 = ready!(level.slice(scatter));
                lookout.part = Part::Low(level_q24, LowSum::of(level.index));
            }
            Part::Low(level_q24, low) => {
                let (index, level_q24) = (low.index, *level_q24);
                let expected = |b| {
                    let expected = (level_q24 * u128::from(torque_power_q24(b))) >> 24;
                    u64::try_from(expected).unwrap_or(u64::MAX)
                };
                let scatter = scatter(speeds, &lookout.noise_shares, lookout.stamp);
                let found = ready!(low.slice(scatter, &lookout.shares, expected));
                let order = index + 1;
                if order > LOW_ORDERS / 2 {
                    let slope = found.power.saturating_mul((order as u64).pow(4)) / 3;
                    lookout.slope = lookout.slope.saturating_add(slope);
                }
                lookout.add(order, found.power, self.may_be_torque(order));
                lookout.part = if order < LOW_ORDERS.min(lookout.plan.single) {
                    Part::Level(LowLevel::of(index + 1))
                } else {
                    lookout.cursor = Cursor::START;
                    lookout.cursor.next(order, lookout.plan.single);
                    Part::Orders
                };
            }
            Part::Orders => {
                let single = lookout.plan.single;
                for index in lookout.cursor.next(ORDERS, single) {
                    let torque = lookout.slope / (index as u64 + 1).pow(4);
                    lookout.add(index + 1, torque, false);
                }
                ready!(lookout.cursor.at_end(single));
                lookout.add_common();
                return Poll::Ready(Some(self.seen_from(lookout)));
            }
        }
        Poll::Pending
    }

    fn seen_from(&self, lookout: &Lookout) -> Outlook {
        let (bin, standing) = self.drift.standing();
        let standing = standing << (2 * COEFFICIENT_BITS + 1);
        let standing = u128::from(lookout.shares.of_bin(&self.speeds, bin, standing));
        let root = |power: u128| FINE.root_mean_square(u64::try_from(power).unwrap_or(u64::MAX));
        Outlook {
            error: root(lookout.now + standing),
            after_twice: root(lookout.twice + standing),
            stamp: root(lookout.stamp.edge.into()),
        }
    }

    /// Whether torque may make an order, which one speed does not tell.
    fn may_be_torque(&self, order: usize) -> bool {
        let base = usize::from(self.knowledge.torque_base);
        !self.totals.two_speeds() && (base == 0 || order.is_multiple_of(base))
    }

    /// Power at every order of what repeats from edge to edge beside the classes' means, time stamps' jitter included: the sum's
    /// intervals hardly know the low orders of torque. Each class's deviations are given, added up, and their squares.
    fn geometry_power(&self, of_class: &[[i64; 2]; CLASSES_MAX], weight_q16: u64) -> u64 {
        let shape = self.fold.shape;
        let lines = i128::from(shape.edges / shape.classes).max(1);
        let (mut squares, mut of_means) = (0_i128, 0_i128);
        for [sum, square] in of_class {
            squares += i128::from(*square);
            of_means += i128::from(*sum) * i128::from(*sum);
        }
        let squares = squares - over_signed(of_means, lines);
        // The turn taken last is folded into the sum while the next one comes.
        let mut weight_q16 = weight_q16;
        if let Some(place) = self
            .folding
            .filter(|_| 2 * self.fold.remaining > shape.edges)
        {
            let before = weight_q16.saturating_sub(self.weighing.weight_q16(place.bin));
            weight_q16 = before << self.fold.sum_down();
        }
        let edges = i128::from(shape.edges);
        // A step between two errors has twice the power of either; all orders together have an error's.
        let per_order = over(
            squares.max(0).unsigned_abs() << 20,
            (2 * edges * edges).unsigned_abs(),
        );
        let weight_q8 = u128::from(weight_q16 >> 8).max(1);
        let up = 2 * (shape.unit_shift + FINE.bits) + POWER_BITS + 16 - 20;
        u64::try_from(over(per_order << up, weight_q8 * weight_q8)).unwrap_or(u64::MAX)
    }
}

/// What Wiener's weight leaves of a size in noise: S N / (S + N).
fn left(noise: u64, size: u64) -> u64 {
    let excess = 32_u32.saturating_sub((noise | size).leading_zeros());
    let (small, large) = (noise.min(size), noise.max(size));
    if small >> excess == 0 || large / small.max(1) > 1 << 16 {
        return small;
    }
    let (a, b) = (noise >> excess, size >> excess);
    (a * b / (a + b)) << excess
}

/// Adds up deviations and their squares by class.
fn add_steps(deviations: &[i32], of_class: &mut [[i64; 2]; CLASSES_MAX], classes: usize) {
    for line in deviations.chunks_exact(classes) {
        for (deviation, [sum, squares]) in line.iter().zip(&mut *of_class) {
            let deviation = i64::from(*deviation);
            *sum += deviation;
            *squares = squares.saturating_add(deviation * deviation);
        }
    }
}
