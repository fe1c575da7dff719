//! How an encoder's orders are looked at, and the plain Fourier sum.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

/// Orders of a turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Edges a turn.
    pub edges: usize,
    /// Edge classes.
    pub classes: usize,
    /// Edges of a block; contrasts are looked at where blocks begin.
    pub block: usize,
    /// Edges between the samples that the lowest orders of a turn are taken from.
    pub sample: usize,
    /// Orders weighed one by one: 1..=`single`.
    pub single: usize,
}

impl Plan {
    /// For an encoder of `edges` edges in `classes` classes.
    pub(super) fn new(edges: usize, classes: usize) -> Self {
        // Blocks as short as 1024 a turn allow, or an edge each where only blocks too long for an order would do.
        let block = (1..=edges)
            .find(|&size| edges.is_multiple_of(size) && edges / size <= 1024)
            .filter(|&size| edges / size >= 128)
            .unwrap_or(1);
        // Half as many as long as 240 are left.
        let mut sample = block;
        while (edges / sample).is_multiple_of(2) && edges / sample >= 2 * 240 {
            sample *= 2;
        }
        let single = match edges {
            ..64 => (edges - 1) / 2,
            64..=2048 => edges / 4,
            _ => edges / 16,
        };
        Self {
            edges,
            classes,
            block,
            sample,
            single: single.min(240).min(if block > 1 {
                edges / block / 4 + 6
            } else {
                (edges - 1) / 2
            }),
        }
    }

    /// Whether an order belongs to the edge classes.
    pub(super) fn is_class_order(self, order: usize) -> bool {
        order.is_multiple_of(self.edges / self.classes)
    }

    /// The orders weighed one by one.
    pub(super) fn orders(self) -> impl DoubleEndedIterator<Item = usize> {
        (1..=self.single).filter(move |&order| !self.is_class_order(order))
    }

    /// Whether orders have neighbours like them.
    pub(super) fn has_neighbours(self) -> bool {
        self.edges >= 64
    }

    /// Neighbours of an order: a third of it to either side, four at least.
    pub(super) fn neighbours(self, order: usize) -> impl Iterator<Item = usize> {
        let reach = (order / 3).max(4);
        self.orders().filter(move |n| n.abs_diff(order) <= reach)
    }

    /// Orders above the single ones, each counted twice.
    pub(super) fn common_count(self) -> usize {
        (self.edges - self.classes).saturating_sub(2 * self.orders().count())
    }

    /// Values by order, from 0 to `single`; zero at those that aren't looked at.
    pub(super) fn by_order<T: Clone + Default>(self, mut value: impl FnMut(usize) -> T) -> Vec<T> {
        let mut values = vec![T::default(); self.single + 1];
        for order in self.orders() {
            values[order] = value(order);
        }
        values
    }
}

/// Mean of x exp(-i n theta).
pub(super) fn coefficient(x: &[f64], order: usize) -> Complex64 {
    let samples = x.len();
    let terms = x.iter().enumerate().map(|(k, value)| {
        let angle = TAU * (order * k % samples) as f64 / samples as f64;
        Complex64::from_polar(*value, -angle)
    });
    terms.sum::<Complex64>() / samples as f64
}

/// Mean power of the orders above the single ones, as the steps between edges show it.
pub(super) fn common_power(plan: Plan, x: &[f64], single: &[Complex64]) -> f64 {
    let gain =
        |order: usize| (Complex64::cis(TAU * order as f64 / x.len() as f64) - 1.0).norm_sqr();
    let all = (0..x.len()).filter(|&order| !plan.is_class_order(order));
    let mut gains: f64 = all.map(gain).sum();
    let before = x.iter().cycle().skip(x.len() - 1);
    let squares = x
        .iter()
        .zip(before)
        .map(|(here, before)| (here - before).powi(2));
    let mut steps = squares.sum::<f64>() / x.len() as f64;
    for order in plan.orders() {
        steps -= 2.0 * gain(order) * single[order].norm_sqr();
        gains -= 2.0 * gain(order);
    }
    if plan.common_count() == 0 {
        0.0
    } else {
        (steps / gains).max(0.0)
    }
}
