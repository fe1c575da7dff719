//! Orders that stand out and may be torque, and what two of them make together.
//!
//! Angle is measured by time, and time at a place goes with 1 / speed: two speed swings u_m, u_n make a third of about
//! u_m u_n at the orders m + n and |m - n|, as exactly repeated as geometry and often no larger. And the swing is seen at edges
//! that the disc's mounting moved: a swing of the angle at order m makes one at m + 1 and m - 1 with an eccentricity, at m + 2
//! and m - 2 with a tilt. So both are counted as noise there.

use super::order::LOCKED_MAX;
use crate::wide::over;

/// An order far above its neighbours, with its power in 2^-8 of the squared sequence unit, and the root of that.
#[derive(Clone, Copy)]
pub(super) struct Standing {
    pub order: u16,
    pub power: u64,
    root: u64,
}

impl Standing {
    pub(super) fn new(order: u16, power: u64) -> Self {
        Self {
            order,
            power,
            root: power.isqrt(),
        }
    }
}

/// The strongest orders that stand out.
pub(super) type StandingOrders = heapless::Vec<Standing, LOCKED_MAX>;

/// Keeps `standing` in a list of the strongest.
pub(super) fn keep_strongest(list: &mut StandingOrders, standing: Standing) {
    if list.push(standing).is_err()
        && let Some(weakest) = list.iter_mut().min_by_key(|kept| kept.power)
        && weakest.power < standing.power
    {
        *weakest = standing;
    }
}

/// Largest size at an order, in 2^-4 of the unit, of what pairs of standing orders make together, and each with orders 1 and 2, whose
/// powers have the roots `mounting`. `turn` is the length of a turn in the sequence's unit.
pub(super) fn product(list: &StandingOrders, mounting: [u64; 2], turn: u64, order: usize) -> u32 {
    let order = order as u64;
    let (mut seen, mut swings) = (0_u128, 0_u128);
    for (index, one) in list.iter().enumerate() {
        let m = u64::from(one.order);
        for (root, away) in mounting.into_iter().zip(1..) {
            if order.abs_diff(m) == away {
                seen += u128::from(one.root) * u128::from(root) * u128::from(m);
            }
        }
        for other in &list[index..] {
            let n = u64::from(other.order);
            if order == m + n || order == m.abs_diff(n) {
                // A pair of the same order counts once.
                let pair = u128::from(one.root) * u128::from(other.root) * u128::from(m * n);
                swings += if m == n { pair / 2 } else { pair };
            }
        }
    }
    if seen == 0 && swings == 0 {
        return 0;
    }
    // u_m = m 2 |c_m| 2 pi / turn, and the product's angle is u_m u_n / order, in |c| half of that. The edges' displacement times the
    // swing's slope is half of that on either side: in |c| 2 pi m |c_m c_1| / turn. Both are in Q8; sizes are in Q4.
    let both = (seen / 2 + over(swings, order.into())).saturating_mul(FOUR_PI_Q8);
    u32::try_from(over(both, u128::from(turn.max(1)) << 12)).unwrap_or(u32::MAX)
}

const FOUR_PI_Q8: u128 = 3217;

/// Power at an order of a torque there that swings the speed as much as the strongest of the standing orders: where one order of a
/// motor's torque stands out, others may be there that do not.
pub(super) fn strongest_swing(list: &StandingOrders, order: usize) -> u64 {
    let square = |n: u64| u128::from(n * n);
    let swings = list
        .iter()
        .map(|standing| u128::from(standing.power) * square(standing.order.into()));
    u64::try_from(over(swings.max().unwrap_or(0), square(order as u64))).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::ORDERS_MAX;

    #[test]
    fn two_swings_make_a_third_at_sum_and_difference() {
        // Speed swings of 1 % at order 10 and 0.5 % at order 15 on a turn of 2^31 units.
        let turn = 1_u64 << 31;
        let coefficient =
            |order: f64, swing: f64| swing / order * turn as f64 / core::f64::consts::TAU / 2.0;
        let standing = |order: u16, swing: f64| {
            let c = coefficient(f64::from(order), swing);
            Standing::new(order, (c * c * 256.0) as u64)
        };
        let mut list = StandingOrders::new();
        keep_strongest(&mut list, standing(10, 0.01));
        keep_strongest(&mut list, standing(15, 0.005));
        let sizes: [u32; ORDERS_MAX] =
            core::array::from_fn(|index| product(&list, [0; 2], turn, index + 1));
        for (order, product) in [
            (25, 0.01 * 0.005),
            (5, 0.01 * 0.005),
            (20, 0.01 * 0.01 / 2.0),
            (30, 0.005 * 0.005 / 2.0),
        ] {
            let expected = coefficient(f64::from(order), product);
            let found = f64::from(sizes[order as usize - 1]) / 16.0;
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{order}: {found} {expected}"
            );
        }
        assert_eq!(sizes.iter().filter(|&&size| size > 0).count(), 4);
    }

    #[test]
    fn a_swing_seen_on_an_eccentric_disc_has_neighbours() {
        let turn = 1_u64 << 31;
        let c = |amplitude: f64| amplitude * turn as f64 / core::f64::consts::TAU / 2.0;
        let power = |amplitude: f64| (c(amplitude) * c(amplitude) * 256.0) as u64;
        let mut list = StandingOrders::new();
        let (swing, eccentricity) = (6.7e-4, 5e-4);
        keep_strongest(&mut list, Standing::new(15, power(swing)));
        for (order, expected) in [
            (14, c(15.0 * swing * eccentricity / 2.0)),
            (13, 0.0),
            (15, 0.0),
        ] {
            let found = product(&list, [power(eccentricity).isqrt(), 0], turn, order);
            assert!(
                (f64::from(found) / 16.0 - expected).abs() <= 0.01 * expected,
                "{order}"
            );
        }
    }

    #[test]
    fn the_strongest_swing_falls_with_the_order() {
        let mut list = StandingOrders::new();
        assert_eq!(strongest_swing(&list, 7), 0);
        for (order, power) in [(5, 1000), (20, 900)] {
            keep_strongest(&mut list, Standing::new(order, power));
        }
        assert_eq!(
            [5, 20, 60].map(|n| strongest_swing(&list, n)),
            [14_400, 900, 100]
        );
    }

    #[test]
    fn a_full_list_keeps_the_strongest() {
        let mut list = StandingOrders::new();
        for power in 1..=20 {
            keep_strongest(&mut list, Standing::new(power as u16, power));
        }
        assert_eq!(list.iter().map(|kept| kept.power).min(), Some(5));
    }
}
