//! How far each order is believed.

use std::f64::consts::{LN_2, TAU};

use realfft::num_complex::Complex64;

use super::agree::LOW_ORDERS;
use super::noise::Noise;
use super::plan::Plan;

/// An estimate that is to be weighed.
pub(super) struct Estimate<'a> {
    pub coefficients: &'a [Complex64],
    pub noise: &'a Noise,
    pub common: f64,
    pub common_noise: f64,
    /// Orders that torque may make are multiples of this; 0 for all.
    pub torque_base: usize,
    /// Orders at which speeds did not tell torque from geometry.
    pub untold: &'a [usize],
}

/// What the weighing found.
pub(super) struct Weights {
    pub single: Vec<f64>,
    pub common: f64,
    /// Expected squared error of an edge, turns squared.
    pub residual: f64,
    /// Orders left alone.
    pub locked: Vec<usize>,
}

impl Estimate<'_> {
    fn suspect(&self, plan: Plan, order: usize) -> bool {
        let may = self.torque_base == 0 || order.is_multiple_of(self.torque_base);
        plan.has_neighbours() && may && self.untold.contains(&order)
    }

    fn power(&self, order: usize) -> f64 {
        self.coefficients[order].norm_sqr()
    }

    /// Level of geometry at an order: a median over its neighbours, of power over noise where noise rules, of power where it
    /// does not; and how many neighbours there were.
    fn neighbourhood(&self, plan: Plan, order: usize) -> (f64, usize) {
        let near: Vec<usize> = plan.neighbours(order).collect();
        let ratio = median_log(near.iter().map(|&n| self.power(n) / self.noise.level[n]));
        let plain = median_log(near.iter().map(|&n| self.power(n)));
        let by_ratio = ratio + self.noise.level[order].log2();
        let signal_rules = ((ratio - 5.0) / 2.0).clamp(0.0, 1.0);
        // The mean over the median of an exponential distribution.
        let level = (by_ratio + (plain - by_ratio) * signal_rules).exp2() / LN_2;
        (level, near.len())
    }

    /// Power of the geometry at every order, carried down from the order above where noise drowns it.
    fn sizes(&self, plan: Plan, common: f64) -> Vec<f64> {
        let mut sizes = vec![0.0; plan.single + 1];
        let mut carried = common;
        for order in plan.orders().rev() {
            let (power, noise) = (self.power(order), self.noise.level[order]);
            if !plan.has_neighbours() {
                sizes[order] = (power - 4.0 * noise).max(0.0);
                continue;
            }
            let own = if self.suspect(plan, order) {
                0.0
            } else {
                let pairs = if order <= LOW_ORDERS {
                    self.noise.low_pairs.clamp(1.0, 256.0)
                } else {
                    256.0
                };
                power - pairs * ((12.0 / pairs).exp() - 1.0) * noise
            };
            let (level, count) = self.neighbourhood(plan, order);
            let margin = (10.4 / (count as f64).sqrt()).exp2();
            let size = (level - margin * noise).max(0.0);
            sizes[order] = size.max(carried.min(level)).max(own);
            carried = sizes[order].min(level);
        }
        sizes
    }

    /// Weighs all orders.
    pub(super) fn weigh(&self, plan: Plan) -> Weights {
        let common_size = (self.common - 282.0 / 256.0 * self.common_noise).max(0.0);
        let common = wiener(common_size, self.common_noise);
        let sizes = self.sizes(plan, common_size);
        let height = |order: usize, noise: f64| (self.power(order) / (sizes[order] + noise)).log2();
        let stands = |&order: &usize| {
            self.suspect(plan, order) && height(order, self.noise.level[order]) > 4.0
        };
        let mut locked: Vec<usize> = plan.orders().filter(stands).collect();
        // The strongest sixteen.
        locked.sort_by(|&a, &b| self.power(b).total_cmp(&self.power(a)));
        locked.truncate(16);
        let hidden = common_size.max(26.0 / 256.0 * self.common_noise);
        let mut residual =
            plan.common_count() as f64 * left_over(common, hidden, self.common_noise);
        let single = {
            let mut single = vec![0.0; plan.single + 1];
            for order in plan.orders() {
                let level = self.noise.level[order] * (self.noise.own[order] / 2.0).max(1.0);
                let product = self.product(&locked, order).powi(2);
                let suspect = self.suspect(plan, order);
                let hidden = if suspect && self.torque_base > 0 {
                    let swings = locked.iter().map(|&n| self.power(n) * (n * n) as f64);
                    swings.fold(0.0, f64::max) / (order * order) as f64
                } else {
                    0.0
                };
                let doubt = level + product + hidden;
                let gate = if suspect {
                    (4.0 - height(order, doubt)).clamp(0.0, 1.0)
                } else {
                    1.0
                };
                let mounting = order <= 2 && !suspect && plan.has_neighbours();
                let least = if mounting {
                    (1.0 - doubt / self.power(order)).max(0.0)
                } else {
                    0.0
                };
                single[order] = wiener(sizes[order] - product, doubt).max(least) * gate;
                residual += 2.0
                    * if mounting {
                        let rest = (1.0 - single[order]).powi(2);
                        (1.0 - rest) * doubt + rest * self.power(order)
                    } else {
                        left_over(single[order], sizes[order], doubt)
                    };
            }
            single
        };
        locked.sort_unstable();
        Weights {
            single,
            common,
            residual,
            locked,
        }
    }

    /// Size of what pairs of speed swings u make at an order: u u / order at sums and differences, half of that for an order
    /// with itself.
    fn product(&self, locked: &[usize], order: usize) -> f64 {
        let swing = |m: usize| m as f64 * 2.0 * self.power(m).sqrt() * TAU;
        let mut size = 0.0;
        for (i, &a) in locked.iter().enumerate() {
            let away = order.abs_diff(a);
            if (1..=2).contains(&away) {
                // Seen at edges that eccentricity and tilt moved, by two standard errors more than shows.
                let moved = self.power(away) + 4.0 * self.noise.level[away];
                size += TAU * a as f64 * (self.power(a) * moved).sqrt();
            }
            for &b in locked[i..]
                .iter()
                .filter(|&&b| order == a + b || order == a.abs_diff(b))
            {
                let both = swing(a) * swing(b) * if a == b { 0.5 } else { 1.0 };
                size += both / order as f64 / TAU / 2.0;
            }
        }
        size
    }
}

/// Wiener's weight, drawn to zero at 0.3.
fn wiener(size: f64, noise: f64) -> f64 {
    if size > 0.0 {
        ((size / (size + noise) - 0.3) / 0.7).max(0.0)
    } else {
        0.0
    }
}

/// Power left where a size is corrected with a weight.
fn left_over(weight: f64, size: f64, noise: f64) -> f64 {
    (1.0 - weight).powi(2) * size + weight * weight * noise
}

/// Median of the base-2 logarithms.
fn median_log(values: impl Iterator<Item = f64>) -> f64 {
    let mut logs: Vec<f64> = values.map(f64::log2).collect();
    logs.sort_by(f64::total_cmp);
    f64::midpoint(logs[(logs.len() - 1) / 2], logs[logs.len() / 2])
}
