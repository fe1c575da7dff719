//! Geometry and locked torque, order by order: geometry has its size at every speed, torque's angle falls with the square
//! of the speed, so the plain mean over turns holds more of it than the mean weighed by the speed squared.
//!
//! Where the speed falls within the turns, torque shows at the orders beside its own too. That is taken out first, the strongest torque's
//! before the next one is looked for.

use core::ops::Range;
use core::task::{Poll, ready};

use super::close::saturated;
use super::course::Falls;
use super::cursor::Cursor;
use super::damping::Shaft;
use super::moments::Moments;
use super::order::{ORDERS_MAX, OrderPlan, OrderSet, TORQUES_MAX, TorqueOrder};
use super::scale::Fine;
use super::smooth::OWN_BITS;
use super::spectrum::{COEFFICIENT_BITS, Coefficient, scaled};
use crate::log2::{LOG2_BITS, exp2, log2};

/// Torque found.
pub(super) struct Torques {
    /// The strongest orders.
    pub strongest: heapless::Vec<TorqueOrder, TORQUES_MAX>,
    /// Orders that torque might make whole, and no turns of different speed would show it.
    pub untold: OrderSet,
    /// Power that damping may have left in all orders beyond what they are weighed with.
    pub hidden: u64,
}

impl Torques {
    pub(super) const NONE: Self = Self {
        strongest: heapless::Vec::new(),
        untold: OrderSet::NONE,
        hidden: 0,
    };

    pub(super) fn clear(&mut self) {
        self.strongest.clear();
        self.untold = OrderSet::NONE;
        self.hidden = 0;
    }
}

/// From so many times the noise on what is not certain counts as doubt: noise alone is five times its mean once in 150 orders.
const UNCERTAIN: u64 = 5;

/// Torque is taken for certain at so many times the noise, and for none at half of it: noise alone is six times its mean
/// once in 400 orders.
const CERTAIN: u64 = 12;

/// Means that differ by less than torque's share times 2^-14 of an order, at most 2^-10, don't tell torque: fields, delays and bearings
/// make a disc differ a little with the speed too, and speeds near each other would make much of it. In squares: 2^-28, and 256 at most.
const UNLIKE_BITS: u32 = 28;
const UNLIKE_SHARE_SQUARE_Q30: u128 = 256 << 30;

/// Orders of a slice that a torque's side bands and its products with those before it are taken out of.
const BESIDE: usize = 8;

/// Torques of a slice whose side bands at an order are added up.
const KNOWN: usize = 4;

/// Takes torque, where there is evidence of it, out of the weighed mean, whose noise grows by what it costs.
pub(super) struct Separation {
    cursor: Cursor,
    part: Part,
    /// Torque's part in the weighed mean over that in the difference, Q30; none where the speeds tell nothing apart.
    share_q30: Option<i64>,
    /// Its angle at the first turn's speed over that in the difference, Q30.
    scale_q30: i64,
    shaft: Shaft,
    /// Torques whose side bands are known, the strongest first.
    known: heapless::Vec<Known, TORQUES_MAX>,
    /// Orders 1 and 2 of the geometry, once a torque is known.
    mounting: [Coefficient; 2],
    /// How many of the known torques, and what they make of the order that is taken next beside their own angle.
    passed: Cursor,
    beside: Coefficient,
}

enum Part {
    Look,
    /// What the torque found last makes of the difference's orders is taken out.
    Clear,
    Take,
}

/// A torque that is certain.
#[derive(Clone, Copy)]
struct Known {
    order: usize,
    /// In the difference.
    size: Coefficient,
}

/// What is known of every single order; order n at n - 1.
pub(super) struct Orders {
    /// The weighed mean.
    pub coefficients: [Coefficient; ORDERS_MAX],
    /// Its noise.
    pub noise: [u64; ORDERS_MAX],
    /// Logarithms of what its contrast showed at each order itself over twice the level, in 2^-[`OWN_BITS`](super::smooth::OWN_BITS) octave.
    pub own: [u8; ORDERS_MAX],
    /// The plain mean less the weighed one, and once torque is told apart, what was added to the coefficients.
    pub difference: [Coefficient; ORDERS_MAX],
    /// Noise of the difference; in the end, the geometry's power.
    pub doubt: [u64; ORDERS_MAX],
}

impl Separation {
    pub(super) fn new(moments: &Moments, shaft: Shaft) -> Self {
        Self {
            cursor: Cursor::START,
            part: Part::Look,
            shaft,
            share_q30: moments.separation,
            scale_q30: moments.torque_scale_q30(),
            known: heapless::Vec::new(),
            mounting: [Coefficient::ZERO; 2],
            passed: Cursor::START,
            beside: Coefficient::ZERO,
        }
    }

    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        plan: OrderPlan,
        orders: &mut Orders,
        fine: Fine,
        torques: &mut Torques,
    ) -> Poll<()> {
        let Some(share_q30) = self.share_q30 else {
            orders.difference.fill(Coefficient::default());
            torques.untold = OrderSet::ALL;
            return Poll::Ready(());
        };
        match self.part {
            Part::Look => {
                let found = self.strongest(plan, orders, share_q30);
                self.part = match found.map(|found| self.known.push(found)) {
                    Some(Ok(())) => Part::Clear,
                    _ => Part::Take,
                };
            }
            Part::Clear => {
                if let Some(torque) = self.known.last() {
                    let falls = self.shaft.falls;
                    let fall_q30 = times_q30(falls.plain_q30 - falls.weighed_q30, self.scale_q30);
                    let own = torque.beside(torque.order, falls.friction_q16, fall_q30);
                    let whole = torque.size.minus(own);
                    let found = *torque;
                    let mounting = self.mounting(orders, share_q30);
                    let fourth_q16 = falls.fourth_plain_q16 - falls.fourth_weighed_q16;
                    let pairs_q30 = self.pairs_q30(fourth_q16);
                    let orders_now = self.cursor.next(BESIDE, plan.single);
                    for index in orders_now.filter(|index| !plan.is_class_order(index + 1)) {
                        let more = torque.beside(index + 1, falls.friction_q16, fall_q30);
                        let products = found.with_mounting(mounting, index + 1, fine, 1 << 30);
                        let with_others = self
                            .known
                            .iter()
                            .filter_map(|other| found.with(*other, index + 1, pairs_q30, fine));
                        let products = with_others.fold(products, Coefficient::plus);
                        orders.difference[index] =
                            orders.difference[index].minus(more).minus(products);
                    }
                    ready!(self.cursor.at_end(plan.single));
                    if let Some(torque) = self.known.last_mut() {
                        torque.size = whole;
                    }
                }
                self.mounting = self.mounting(orders, share_q30);
                (self.part, self.cursor) = (Part::Look, Cursor::START);
            }
            Part::Take => {
                let order = self.cursor.count() + 1;
                if order <= plan.single && !plan.is_class_order(order) {
                    let known = self.passed.next(KNOWN, self.known.len());
                    self.add_beside(known, order, share_q30, fine);
                    ready!(self.passed.at_end(self.known.len()));
                    self.take(order, share_q30, orders, fine, torques);
                    (self.passed, self.beside) = (Cursor::START, Coefficient::ZERO);
                }
                self.cursor.next(1, plan.single);
                return self.cursor.at_end(plan.single);
            }
        }
        Poll::Pending
    }

    /// The strongest torque that is certain and whose side bands are not known yet.
    fn strongest(&self, plan: OrderPlan, orders: &Orders, share_q30: i64) -> Option<Known> {
        let mut strongest: Option<(u64, usize)> = None;
        for index in 0..plan.single {
            let power = orders.difference[index].power();
            let order = index + 1;
            if strongest.is_none_or(|(most, _)| power > most)
                && power > orders.doubt[index].saturating_mul(CERTAIN)
                && !plan.is_class_order(order)
                && !self.known.iter().any(|known| known.order == order)
                && power / CERTAIN > to_exceed(orders, index, share_q30)
            {
                strongest = Some((power, index));
            }
        }
        strongest.map(|(_, index)| Known {
            order: index + 1,
            size: orders.difference[index],
        })
    }

    /// Orders 1 and 2 of the weighed mean without the torque that is known.
    fn mounting(&self, orders: &Orders, share_q30: i64) -> [Coefficient; 2] {
        core::array::from_fn(|index| {
            let torque = self.known.iter().find(|known| known.order == index + 1);
            let torque = torque.map_or(Coefficient::ZERO, |known| known.size.scaled(share_q30));
            orders.coefficients[index].minus(torque)
        })
    }

    /// Adds what some of the known torques make of an order of the weighed mean beside their own angle, alone and with those before them.
    fn add_beside(&mut self, which: Range<usize>, order: usize, share_q30: i64, fine: Fine) {
        let Falls {
            weighed_q30,
            friction_q16,
            fourth_weighed_q16,
            ..
        } = self.shaft.falls;
        let fall_q30 = times_q30(weighed_q30, self.scale_q30);
        let pairs_q30 = self.pairs_q30(fourth_weighed_q16);
        let mut sum = self.beside;
        for at in which {
            let known = self.known[at];
            sum = sum
                .plus(known.beside(order, friction_q16, fall_q30))
                .plus(known.with_mounting(self.mounting, order, fine, share_q30));
            for other in &self.known[..=at] {
                if let Some(both) = known.with(*other, order, pairs_q30, fine) {
                    sum = sum.plus(both);
                }
            }
        }
        self.beside = sum;
    }

    /// What two torques make of a sum with a mean fourth power of the duration, over what they make with their sizes in the difference, Q30.
    fn pairs_q30(&self, fourth_q16: i64) -> i64 {
        let once_q30 = times_q30(fourth_q16 << 14, self.scale_q30);
        times_q30(once_q30, self.scale_q30)
    }
}

impl Known {
    /// What it makes of an order where the speed falls within the turns, by so much as `fall_q30` says.
    ///
    /// With the angle theta from the turn's middle, A the share of the speed that goes in a radian and friction that goes with the power p of
    /// the speed, torque whose angle is the real part of c exp(i n theta) at a steady speed makes that of
    /// ((1 + 2 A theta) + i (3 + p) A / n) c exp(i n theta), to the first order in A. A turn is folded between its ends, which takes 2 A theta
    /// of what it is there from it. These are the orders of what is left beside c itself, by A.
    fn beside(self, order: usize, friction_q16: i64, fall_q30: i64) -> Coefficient {
        #[allow(clippy::cast_possible_wrap)]
        let (n, m) = (self.order as i64, order as i64);
        if n == m {
            let along = self.size.scaled(friction_q16 << 14);
            let across = along.plus(self.size).plus(self.size);
            let own = Coefficient {
                re: across.im.saturating_neg(),
                im: along.re,
            };
            return own.scaled(fall_q30 / n);
        }
        let of_apart_q30 = |times: i64, by: i64| {
            let share_q30 = (times << 30) / (by * (n * n - m * m));
            times_q30(share_q30, fall_q30)
        };
        Coefficient {
            re: scaled(self.size.im, of_apart_q30(4 * n, 1)),
            im: scaled(self.size.re, of_apart_q30(-4 * n * n, m)),
        }
    }

    /// What it makes of an order together with another torque, or with itself, times `share_q30`. The time that a speed w + v takes
    /// is 1 - v / w + (v / w)^2, where v / w is as large as the slope of the angle r, and what r swings back of v is half of that square more:
    /// the angle is larger by the integral of 1.5 (dr / d theta)^2. None of orders that don't add up to it.
    fn with(self, other: Self, order: usize, share_q30: i64, fine: Fine) -> Option<Coefficient> {
        let orders = [self.order, other.order];
        let turned = sum_of(orders, order)?;
        let [a, b] = orders.map(|order| order as i64);
        let twice = if a == b { 3 } else { 6 };
        let opposite = if turned == [false; 2] { 1 } else { -1 };
        let part = opposite * twice * a * b;
        let factor_q30 = times_q30((part << 29) / order as i64, share_q30);
        Some(product([self.size, other.size], turned, factor_q30, fine))
    }

    /// What it makes of an order, of so much of it as `share_q30` says, as the edges are where the disc's mounting puts them.
    fn with_mounting(
        self,
        mounting: [Coefficient; 2],
        order: usize,
        fine: Fine,
        share_q30: i64,
    ) -> Coefficient {
        let mut sum = Coefficient::ZERO;
        for (size, of_mounting) in mounting.into_iter().zip(1..) {
            if let Some(turned) = sum_of([self.order, of_mounting], order) {
                let slope = if turned[0] { -1 } else { 1 } * self.order as i64;
                let factor_q30 = times_q30(slope << 30, share_q30);
                sum = sum.plus(product([self.size, size], turned, factor_q30, fine));
            }
        }
        sum
    }
}

/// Which of two orders counts with a minus where they add up to an order; none where they don't.
fn sum_of([one, other]: [usize; 2], order: usize) -> Option<[bool; 2]> {
    if one + other == order {
        Some([false; 2])
    } else if one == other + order {
        Some([false, true])
    } else if other == one + order {
        Some([true, false])
    } else {
        None
    }
}

/// -i times a factor and the product of two sizes in radians, conjugate where they are `turned`, in their own unit. The factor comes before the
/// product is rounded: from a fast first turn to a slow one what two torques make grows by a million and more.
#[inline(never)]
fn product(sizes: [Coefficient; 2], turned: [bool; 2], factor_q30: i64, fine: Fine) -> Coefficient {
    let [[a, b], [c, d]] = [0, 1].map(|at| {
        let Coefficient { re, im } = sizes[at];
        [re, if turned[at] { im.saturating_neg() } else { im }].map(i64::from)
    });
    // 2 pi, Q16.
    const TAU_Q16: i64 = 411_775;
    let in_unit = |part: i64| {
        let part = times_q30(times_q30(part, TAU_Q16), factor_q30);
        saturated(part >> (16 + 32 - 30 + fine.bits + COEFFICIENT_BITS))
    };
    Coefficient {
        re: in_unit((a * d).saturating_add(b * c)),
        im: in_unit((b * d).saturating_sub(a * c)),
    }
}

/// Product of two factors in Q30.
#[inline(never)]
fn times_q30(a: i64, b: i64) -> i64 {
    let product = (i128::from(a) * i128::from(b)) >> 30;
    i64::try_from(product).unwrap_or(if product < 0 { i64::MIN } else { i64::MAX })
}

/// Power of the difference at an order of which nothing is torque's.
fn to_exceed(orders: &Orders, index: usize, share_q30: i64) -> u64 {
    let power = orders.coefficients[index].power();
    let unlike = (u128::from(power) * share_square_q30(share_q30).min(UNLIKE_SHARE_SQUARE_Q30))
        >> (30 + UNLIKE_BITS);
    orders.doubt[index].saturating_add(u64::try_from(unlike).unwrap_or(u64::MAX))
}

fn share_square_q30(share_q30: i64) -> u128 {
    u128::from(share_q30.unsigned_abs()).pow(2) >> 30
}

impl Separation {
    fn take(
        &self,
        order: usize,
        share_q30: i64,
        orders: &mut Orders,
        fine: Fine,
        torques: &mut Torques,
    ) {
        let Self {
            shaft: Shaft { damping, .. },
            scale_q30,
            beside,
            ..
        } = *self;
        let index = order - 1;
        orders.coefficients[index] = orders.coefficients[index].minus(beside);
        let to_exceed = to_exceed(orders, index, share_q30);
        let Orders {
            coefficients,
            noise,
            own,
            difference,
            doubt,
        } = orders;
        let power = coefficients[index].power();
        let noise_here = doubt[index];
        let over = |doubt: u64| difference[index].power() / (doubt / 16).max(1);
        let (evidence, shown) = (over(to_exceed), over(noise_here));
        let half = CERTAIN * 16 / 2;
        let belief = evidence.saturating_sub(half).min(half);
        if belief == half {
            let amplitude = difference[index].scaled(scale_q30);
            let error = Coefficient {
                re: i32::try_from(noise_here.isqrt()).unwrap_or(i32::MAX),
                im: 0,
            };
            let torque = TorqueOrder {
                #[allow(clippy::cast_possible_truncation)]
                order: order as u16,
                amplitude: peak(amplitude, fine),
                standard_error: peak(error.scaled(scale_q30), fine),
            };
            keep(&mut torques.strongest, torque);
        }
        // The difference that the order shows if it is all torque, against one that would be certain.
        let all_torque_q30 = u128::from(power) << 30;
        let certain = u128::from(to_exceed) * u128::from(CERTAIN);
        if belief < half && all_torque_q30 < certain * share_square_q30(share_q30) {
            torques.untold.insert(order);
        }
        let of_share = |part: u64| share_q30 / half.cast_signed() * part.cast_signed();
        let taken_q30 = of_share(belief);
        // What shows but is not certain may be torque all the same, and a disc that differs with the speed is no better known.
        let left_in = if evidence > UNCERTAIN * 16 || shown > CERTAIN * 16 {
            difference[index].scaled(of_share(half - belief)).power()
        } else {
            0
        };
        difference[index] = difference[index].scaled(-taken_q30);
        coefficients[index] = coefficients[index].plus(difference[index]);
        // The weighed mean is nearly the best there is, so its noise and that of the difference are strangers.
        let more = (u128::from(noise_here) * u128::from(taken_q30.unsigned_abs())) >> 30;
        let more = (more * u128::from(taken_q30.unsigned_abs())) >> 30;
        let of_order = difference[index].power() / (order * order) as u64;
        let damped = |square_q32| (u128::from(of_order) * u128::from(square_q32)) >> 32;
        let fitted = |power| u64::try_from(power).unwrap_or(u64::MAX);
        let likely = damped(damping.likely_q32);
        let hidden = damped(damping.most_q32) - likely;
        torques.hidden = torques.hidden.saturating_add(fitted(hidden));
        let more = fitted(more + likely + u128::from(left_in));
        if more > 0 {
            own[index] = own_with(own[index], noise[index], more);
            noise[index] = noise[index].saturating_add(more);
        }
        difference[index] = difference[index].minus(beside);
    }
}

/// What the contrast shows at an order itself over twice its level, where the noise has `more` that is not from the contrast.
fn own_with(own: u8, noise: u64, more: u64) -> u8 {
    let shown = exp2(log2(noise.into()) + (i32::from(own) << (LOG2_BITS - OWN_BITS)));
    let over = |noise: u64| log2(u128::from(noise) + u128::from(more));
    let ratio = (over(shown) - over(noise)).max(0) >> (LOG2_BITS - OWN_BITS);
    u8::try_from(ratio).unwrap_or(u8::MAX)
}

/// Peak size of an order in 2^-32 turn.
fn peak(coefficient: Coefficient, fine: Fine) -> u32 {
    fine.root_mean_square(coefficient.power().saturating_mul(4))
}

/// Keeps `torque` in a list of the strongest.
fn keep(list: &mut heapless::Vec<TorqueOrder, TORQUES_MAX>, torque: TorqueOrder) {
    if list.push(torque).is_err()
        && let Some(weakest) = list.iter_mut().min_by_key(|kept| kept.amplitude)
        && weakest.amplitude < torque.amplitude
    {
        *weakest = torque;
    }
}

#[cfg(test)]
mod tests;
