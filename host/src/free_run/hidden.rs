//! Which orders a speed loop may hide.

/// A loop still answers at this multiple of its bandwidth: with a gain of about a half, which hides a third.
const REACH: f64 = 2.0;

/// Orders that a loop may hide: 1 up to and with `last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HiddenOrders {
    /// The highest; 0 where none is in reach.
    pub last: u32,
}

impl HiddenOrders {
    /// Whether an order is among them.
    #[must_use]
    pub const fn contains(self, order: u32) -> bool {
        order >= 1 && order <= self.last
    }
}

/// The orders of a turn of `edges` that a loop of `bandwidth_hz` may hide at `turns_per_s`: those below twice the bandwidth.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn hidden_orders(bandwidth_hz: f64, turns_per_s: f64, edges: u32) -> HiddenOrders {
    let highest = (REACH * bandwidth_hz / turns_per_s.abs()).ceil();
    HiddenOrders {
        // `as` holds what is too large, an infinity at standstill too.
        last: (highest as u32).min(edges / 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_of_100_hz_hides_800_orders_at_15_r_min_and_20_at_600() {
        assert_eq!(hidden_orders(100.0, 0.25, 10_000).last, 800);
        assert_eq!(hidden_orders(100.0, -10.0, 10_000).last, 20);
        assert_eq!(hidden_orders(100.0, 0.0, 10_000).last, 5_000);
        let none = hidden_orders(0.0, 10.0, 10_000);
        assert!(!none.contains(1) && !none.contains(0));
    }
}
