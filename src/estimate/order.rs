//! Orders of a turn: how many are looked at one by one, and those that one speed cannot decide.

/// Orders weighed one by one at the most; above, all are weighed alike.
pub const ORDERS_MAX: usize = 240;

/// Orders listed in [`LockedOrder`] at the most.
pub const LOCKED_MAX: usize = 16;

/// Orders listed in [`TorqueOrder`] at the most.
pub const TORQUES_MAX: usize = 16;

/// An order that repeats every turn and stands far above its neighbours: geometry (eccentricity, tilt) or torque ripple
/// locked to the shaft. One speed can't tell which, so the table leaves it alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LockedOrder {
    /// Cycles a turn.
    pub order: u16,
    /// Peak size in angle, 2^-32 turn.
    pub amplitude: u32,
}

/// Torque locked to the shaft, told from geometry by turns of different speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TorqueOrder {
    /// Cycles a turn.
    pub order: u16,
    /// Peak swing of the shaft's angle that it makes at the first turn's speed, 2^-32 turn; it falls with the speed squared.
    /// The torque is this angle x inertia x (order x speed)^2.
    pub amplitude: u32,
    /// Standard error of the amplitude, 2^-32 turn.
    pub standard_error: u32,
}

/// A set of single orders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct OrderSet([u32; ORDERS_MAX.div_ceil(32)]);

impl OrderSet {
    pub(super) const NONE: Self = Self([0; ORDERS_MAX.div_ceil(32)]);

    /// All of them.
    pub(super) const ALL: Self = Self([u32::MAX; ORDERS_MAX.div_ceil(32)]);

    /// Adds an order, from 1 on.
    pub(super) fn insert(&mut self, order: usize) {
        if let Some(word) = self.0.get_mut((order - 1) / 32) {
            *word |= 1 << ((order - 1) % 32);
        }
    }

    /// Whether an order is among them.
    pub(super) fn contains(self, order: usize) -> bool {
        let word = self.0.get((order - 1) / 32);
        word.is_some_and(|word| word >> ((order - 1) % 32) & 1 == 1)
    }
}

/// How an encoder's orders are split.
#[derive(Clone, Copy)]
pub(super) struct OrderPlan {
    /// Edges a turn.
    pub edges: usize,
    /// Lines a turn; their multiples belong to the edge classes.
    pub lines: usize,
    /// Orders weighed one by one: 1..=`single`.
    pub single: usize,
    /// Samples a turn of the coarse sums.
    pub blocks: usize,
    /// Samples are averaged by this factor before the single orders are taken.
    pub decimation: usize,
}

impl OrderPlan {
    /// Of no encoder.
    pub(super) const NONE: Self = Self {
        edges: 0,
        lines: 0,
        single: 0,
        blocks: 0,
        decimation: 0,
    };

    /// For an encoder that is learned in so many blocks.
    pub(super) fn new(edges: usize, lines: usize, blocks: usize) -> Self {
        let half = (edges - 1) / 2;
        let mut decimation = 1;
        // Room for the samples is half the edges, or the blocks where edges are few.
        while (edges > 2048 && decimation == 1)
            || (decimation < 32
                && edges.is_multiple_of(decimation * 2)
                && edges >= decimation * 16 * ORDERS_MAX)
        {
            decimation *= 2;
        }
        // With few edges there is no neighbourhood to learn from, and every order stands for itself.
        let single = if edges < 64 {
            half
        } else if decimation == 1 {
            edges / 4
        } else {
            edges / decimation / 8
        };
        Self {
            edges,
            lines,
            blocks,
            // Noise at a quarter of the blocks and above would show at orders below.
            single: single
                .min(ORDERS_MAX)
                .min(if blocks < edges { blocks / 4 + 6 } else { half }),
            decimation,
        }
    }

    /// Whether orders have neighbours like them.
    pub(super) fn has_neighbours(self) -> bool {
        self.edges >= 64
    }

    /// Whether an order belongs to the edge classes.
    pub(super) fn is_class_order(self, order: usize) -> bool {
        order.is_multiple_of(self.lines)
    }

    /// Orders from `single + 1` on, each counted twice (plus and minus), the class orders left out.
    pub(super) fn common_count(self) -> usize {
        let class_orders = self.edges / self.lines;
        let single_class = self.single / self.lines;
        (self.edges + 2 * single_class).saturating_sub(class_orders + 2 * self.single)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_single_common_or_of_a_class() {
        for (edges, lines) in [
            (12, 2),
            (90, 15),
            (6, 6),
            (240, 60),
            (10_000, 2500),
            (16_384, 4096),
            (120, 60),
        ] {
            let plan = OrderPlan::new(edges, lines, edges.min(1000));
            let single = (1..=plan.single)
                .filter(|&n| !plan.is_class_order(n))
                .count();
            let class = edges / lines;
            assert_eq!(
                2 * single + plan.common_count() + class,
                edges,
                "{edges} {lines}"
            );
        }
    }

    #[test]
    fn a_set_holds_what_was_put_in() {
        let mut set = OrderSet::default();
        for order in [1, 32, 33, ORDERS_MAX] {
            set.insert(order);
        }
        let held = (1..=ORDERS_MAX).filter(|&n| set.contains(n));
        assert!(held.eq([1, 32, 33, ORDERS_MAX]));
        assert!((1..=ORDERS_MAX).all(|n| OrderSet::ALL.contains(n)));
    }

    #[test]
    fn decimation_leaves_four_samples_a_cycle() {
        for edges in [240, 1000, 4096, 10_000, 10_004, 40_000] {
            let plan = OrderPlan::new(edges, edges / 4, 1000);
            assert!(
                edges / plan.decimation >= 4 * plan.single && edges.is_multiple_of(plan.decimation)
            );
        }
    }
}
