//! Geometry and locked torque, order by order: geometry has its size at every speed, torque's angle falls with the square
//! of the speed, so the plain mean over turns holds more of it than the mean weighed by the speed squared.

use core::task::Poll;

use super::cursor::Cursor;
use super::moments::Moments;
use super::noise::Damping;
use super::order::{ORDERS_MAX, OrderPlan, OrderSet, TORQUES_MAX, TorqueOrder};
use super::scale::Fine;
use super::smooth::OWN_BITS;
use super::spectrum::Coefficient;
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

/// Orders of a slice.
const ORDERS: usize = 4;

/// Takes torque, where there is evidence of it, out of the weighed mean, whose noise grows by what it costs.
pub(super) struct Separation {
    cursor: Cursor,
    /// Torque's part in the weighed mean over that in the difference, Q30; none where the speeds tell nothing apart.
    share_q30: Option<i64>,
    /// Its angle at the first turn's speed over that in the difference, Q30.
    scale_q30: i64,
    shaft: Shaft,
}

/// How the shaft departs from torque that goes with 1 / speed^2.
#[derive(Clone, Copy)]
pub(super) struct Shaft {
    pub damping: Damping,
    /// Bend of a turn, Q32: by a change of speed torque of one order shows at those beside it.
    pub bend_q32: u32,
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
            shaft,
            share_q30: moments.separation,
            scale_q30: moments.torque_scale_q30(),
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
        for index in self.cursor.next(ORDERS, plan.single) {
            if !plan.is_class_order(index + 1) {
                let shares = [share_q30, self.scale_q30];
                take_torque(index + 1, shares, orders, self.shaft, fine, torques);
            }
        }
        self.cursor.at_end(plan.single)
    }
}

fn take_torque(
    order: usize,
    [share_q30, scale_q30]: [i64; 2],
    orders: &mut Orders,
    Shaft { damping, bend_q32 }: Shaft,
    fine: Fine,
    torques: &mut Torques,
) {
    let index = order - 1;
    let Orders {
        coefficients,
        noise,
        own,
        difference,
        doubt,
    } = orders;
    let share_square_q30 = u128::from(share_q30.unsigned_abs()).pow(2) >> 30;
    let power = coefficients[index].power();
    let noise_here = doubt[index];
    let unlike =
        (u128::from(power) * share_square_q30.min(UNLIKE_SHARE_SQUARE_Q30)) >> (30 + UNLIKE_BITS);
    let to_exceed = noise_here.saturating_add(u64::try_from(unlike).unwrap_or(u64::MAX));
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
        keep(&mut torques.strongest, torque, bend_q32);
    }
    // The difference that the order shows if it is all torque, against one that would be certain.
    let all_torque_q30 = u128::from(power) << 30;
    let certain = u128::from(to_exceed) * u128::from(CERTAIN);
    if belief < half && all_torque_q30 < certain * share_square_q30 {
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
    let damped = |square_q16| (u128::from(of_order) * u128::from(square_q16)) >> 16;
    let fitted = |power| u64::try_from(power).unwrap_or(u64::MAX);
    let likely = damped(damping.likely_q16);
    let hidden = damped(damping.most_q16) - likely;
    torques.hidden = torques.hidden.saturating_add(fitted(hidden));
    let more = fitted(more + likely + u128::from(left_in));
    if more > 0 {
        own[index] = own_with(own[index], noise[index], more);
        noise[index] = noise[index].saturating_add(more);
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

/// Keeps `torque` in a list of the strongest that has no side bands.
fn keep(list: &mut heapless::Vec<TorqueOrder, TORQUES_MAX>, torque: TorqueOrder, bend_q32: u32) {
    if list
        .iter()
        .any(|kept| is_side_band(torque, *kept, bend_q32))
    {
        return;
    }
    list.retain(|kept| !is_side_band(*kept, torque, bend_q32));
    if list.push(torque).is_err()
        && let Some(weakest) = list.iter_mut().min_by_key(|kept| kept.amplitude)
        && weakest.amplitude < torque.amplitude
    {
        *weakest = torque;
    }
}

/// Whether `torque` is no more than the other's swing makes beside it. With a bend b the square of the speed changes by 4 b in a turn, which
/// puts 4 b / (2 pi (m - n)) of order n at order m, and at the lowest orders twice that.
fn is_side_band(torque: TorqueOrder, other: TorqueOrder, bend_q32: u32) -> bool {
    let apart = u64::from(torque.order.abs_diff(other.order));
    let beside = (u64::from(other.amplitude) * u64::from(bend_q32)) >> 31;
    u64::from(torque.amplitude) * apart < beside
}
