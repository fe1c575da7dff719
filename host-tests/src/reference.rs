//! The estimator in double precision, written from its description alone: whole arrays, a plain Fourier sum, no rounding.
//!
//! Input are crossing times only, starting at edge 0 of the first turn. It shares no code with the core.

use std::f64::consts::{LN_2, TAU};

/// Result of [`estimate`], all in radians.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Error of every edge, zero mean.
    pub error: Vec<f64>,
    /// Mean error of each class, zero mean over classes.
    pub class_offsets: Vec<f64>,
    /// Expected RMS of what is left of the line position error.
    pub standard_error: f64,
    /// Weights of orders 1..=K.
    pub weights: Vec<f64>,
    /// Orders left alone as possibly torque.
    pub locked: Vec<usize>,
}

/// Estimates from `times` (any unit): whole turns of `edges` crossings and one more. The first turn only sets the rate.
///
/// # Panics
/// With fewer than three turns.
#[must_use]
pub fn estimate(times: &[u64], edges: usize, classes: usize) -> Reference {
    let turns = (times.len() - 1) / edges;
    assert!(turns >= 3, "three turns at least");
    let lines = edges / classes;
    let duration: Vec<f64> = (0..turns)
        .map(|r| (times[(r + 1) * edges] - times[r * edges]) as f64)
        .collect();
    let used = turns - 1;
    let n = edges as f64;

    let mut sum = vec![0.0; edges];
    let mut contrast = vec![0.0; edges];
    let mut sign_total = 0.0;
    let mut length = 0.0;
    for used_turn in 0..used {
        let r = used_turn + 1;
        let scale = n / duration[r - 1];
        let slope = duration[r] / duration[r - 1];
        let kappa = if r + 1 < turns {
            (duration[r + 1] - duration[r - 1]) / 4.0
        } else {
            (duration[r] - duration[r - 1]) / 2.0
        };
        let sign = if used_turn.count_ones() % 2 == 0 {
            1.0
        } else {
            -1.0
        };
        sign_total += sign;
        length += slope;
        for k in 0..edges {
            let s = k as f64 / n;
            let elapsed = (times[r * edges + k] - times[r * edges]) as f64;
            let x = elapsed * scale - slope * k as f64 + kappa * scale * s * (1.0 - s);
            sum[k] -= x;
            contrast[k] -= sign * x;
        }
    }
    let q = used as f64;
    for (d, x) in contrast.iter_mut().zip(&sum) {
        *d -= sign_total / q * x;
    }
    let class_offsets = take_class_means(&mut sum, classes);
    take_class_means(&mut contrast, classes);

    let single = if edges < 64 {
        (edges - 1) / 2
    } else {
        (edges / 4).min(256)
    };
    let is_class = |order: usize| order.is_multiple_of(lines);
    let signal = powers(&sum, single, lines);
    let mut noise = powers(&contrast, single, lines);
    let contrast_scale = q / (q - sign_total * sign_total / q);
    noise
        .single
        .iter_mut()
        .chain([&mut noise.common])
        .for_each(|power| *power *= contrast_scale);

    let neighbours = |order: usize| -> Vec<usize> {
        let reach = (order / 3).max(2);
        (order.saturating_sub(reach).max(1)..=(order + reach).min(single))
            .filter(|&m| !is_class(m))
            .collect()
    };
    let flattened = |m: usize| noise.single[m - 1].log2() + 4.0 * (m as f64).log2();
    let mean = |orders: Vec<usize>| {
        orders.iter().map(|&m| flattened(m)).sum::<f64>() / orders.len().max(1) as f64
    };
    let smooth: Vec<f64> = (1..=single)
        .map(|order| {
            let last = (order + 24).max(order + order / 3).min(single);
            let first = order.min(last.saturating_sub(24)).max(1);
            let above = mean((first..=last).filter(|&m| !is_class(m)).collect());
            let level = mean(neighbours(order)).max(above) - 4.0 * (order as f64).log2();
            (level + 0.577_215_664_9 / LN_2).exp2()
        })
        .collect();

    let slowest = duration[1..].iter().copied().fold(0.0, f64::max);
    let fastest = duration[1..].iter().copied().fold(f64::INFINITY, f64::min);
    let one_speed = slowest < 1.5 * fastest;
    let with_neighbours = edges >= 64;
    let wiener = |size: f64, noise: f64| ((size / (size + noise) - 0.3) / 0.7).max(0.0);
    let left_over = |w: f64, size: f64, noise: f64| (1.0 - w).powi(2) * size + w * w * noise;

    let common_size = (signal.common - 282.0 / 256.0 * noise.common).max(0.0);
    let common_weight = if common_size > 0.0 {
        wiener(common_size, noise.common)
    } else {
        0.0
    };
    let single_class = (1..=single).filter(|&m| is_class(m)).count();
    let common_count = (edges - 2 * single + 2 * single_class).saturating_sub(classes);
    let mut sizes = vec![0.0; single];
    let mut carried = common_size;
    for order in (1..=single).rev().filter(|&m| !is_class(m)) {
        let (power, noise) = (signal.single[order - 1], smooth[order - 1]);
        carried = if with_neighbours {
            let near = neighbours(order);
            let ratio = median_log(near.iter().map(|&m| signal.single[m - 1] / smooth[m - 1]));
            let plain = median_log(near.iter().map(|&m| signal.single[m - 1]));
            let by_ratio = ratio + noise.log2();
            let signal_rules = ((ratio - 5.0) / 2.0).clamp(0.0, 1.0);
            let level = (by_ratio + (plain - by_ratio) * signal_rules).exp2() / LN_2;
            let margin = (10.4 / (near.len() as f64).sqrt()).exp2();
            (level - margin * noise).max(0.0).max(carried.min(level))
        } else {
            (power - 4.0 * noise).max(0.0)
        };
        sizes[order - 1] = carried;
    }
    let suspect_torque = with_neighbours && one_speed;
    let height =
        |order: usize, noise: f64| (signal.single[order - 1] / (sizes[order - 1] + noise)).log2();
    let locked: Vec<usize> = (1..=single)
        .filter(|&m| suspect_torque && !is_class(m) && height(m, smooth[m - 1]) > 4.0)
        .collect();
    // Pairs of swings u make others of about u u / order at sums and differences; half of that for an order with itself.
    let turn = q * n;
    let mut products = vec![0.0; single];
    for (i, &a) in locked.iter().enumerate() {
        for &b in &locked[i..] {
            let swing = |m: usize| m as f64 * 2.0 * signal.single[m - 1].sqrt() * TAU / turn;
            let both = swing(a) * swing(b) * if a == b { 0.5 } else { 1.0 };
            for order in [a + b, a.abs_diff(b)]
                .into_iter()
                .filter(|&m| m > 0 && m <= single)
            {
                products[order - 1] += both / order as f64 * turn / TAU / 2.0;
            }
        }
    }
    let mut residual = common_count as f64
        * left_over(
            common_weight,
            common_size.max(26.0 / 256.0 * noise.common),
            noise.common,
        );
    let mut weights = vec![0.0; single];
    for order in (1..=single).filter(|&m| !is_class(m)) {
        let level = smooth[order - 1].max(noise.single[order - 1] / 2.0);
        let (size, doubt) = (sizes[order - 1], level + f64::powi(products[order - 1], 2));
        let mut weight = wiener(size, doubt);
        if suspect_torque {
            weight *= (4.0 - height(order, doubt)).clamp(0.0, 1.0);
        }
        weights[order - 1] = weight;
        residual += 2.0 * left_over(weight, size, doubt);
    }

    let mut motion = vec![0.0; edges];
    for order in (1..=single).filter(|&m| !is_class(m)) {
        let (re, im) = coefficient(&sum, order);
        let factor = 2.0 * (weights[order - 1] - common_weight);
        for (k, m) in motion.iter_mut().enumerate() {
            let (s, c) = (TAU * (order * k % edges) as f64 / n).sin_cos();
            *m += factor * (re * c - im * s);
        }
    }
    let mut error: Vec<f64> = sum
        .iter()
        .zip(&motion)
        .map(|(x, m)| x * common_weight + m)
        .collect();
    undo_modulation(&mut error, &class_offsets, &motion, q);
    let to_rad = TAU / n / length;
    for (k, e) in error.iter_mut().enumerate() {
        *e = (*e + class_offsets[k % classes]) * to_rad;
    }
    Reference {
        error,
        class_offsets: class_offsets.iter().map(|x| x * to_rad).collect(),
        standard_error: residual.sqrt() * to_rad,
        weights,
        locked,
    }
}

/// An interval's share of error scales with the slowness of the shaft there, which `motion` says, in steps of `step`.
fn undo_modulation(error: &mut [f64], class_offsets: &[f64], motion: &[f64], step: f64) {
    let edges = error.len();
    let whole: Vec<f64> = error
        .iter()
        .enumerate()
        .map(|(k, e)| e + class_offsets[k % class_offsets.len()])
        .collect();
    let product = |k: usize| {
        let before = (k + edges - 1) % edges;
        (whole[k] - whole[before]) * (motion[k] - motion[before]) / step
    };
    let total: f64 = (0..edges).map(product).sum();
    let mut sum = 0.0;
    for (k, e) in error.iter_mut().enumerate().skip(1) {
        sum += product(k);
        *e -= sum - total * k as f64 / edges as f64;
    }
}

/// Median of the base-2 logarithms.
fn median_log(values: impl Iterator<Item = f64>) -> f64 {
    let mut logs: Vec<f64> = values.map(f64::log2).collect();
    logs.sort_by(f64::total_cmp);
    f64::midpoint(logs[(logs.len() - 1) / 2], logs[logs.len() / 2])
}

struct Powers {
    single: Vec<f64>,
    common: f64,
}

/// Powers of single orders, and the mean power above them as the steps between edges show it.
fn powers(x: &[f64], single: usize, lines: usize) -> Powers {
    let edges = x.len();
    let gain = |order: usize| {
        4.0 * (std::f64::consts::PI * order as f64 / edges as f64)
            .sin()
            .powi(2)
    };
    let mut steps = (0..edges)
        .map(|k| (x[k] - x[(k + edges - 1) % edges]).powi(2))
        .sum::<f64>()
        / edges as f64;
    let mut total_gain: f64 = (0..edges).filter(|m| m % lines != 0).map(gain).sum();
    let single: Vec<f64> = (1..=single)
        .map(|order| {
            let (re, im) = coefficient(x, order);
            let power = re * re + im * im;
            if order % lines != 0 {
                steps -= 2.0 * gain(order) * power;
                total_gain -= 2.0 * gain(order);
            }
            power
        })
        .collect();
    Powers {
        single,
        common: (steps / total_gain).max(0.0),
    }
}

/// Mean of x exp(-i n theta).
fn coefficient(x: &[f64], order: usize) -> (f64, f64) {
    let edges = x.len();
    let (mut re, mut im) = (0.0, 0.0);
    for (k, value) in x.iter().enumerate() {
        let (s, c) = (TAU * (order * k % edges) as f64 / edges as f64).sin_cos();
        re += value * c;
        im -= value * s;
    }
    (re / edges as f64, im / edges as f64)
}

fn take_class_means(x: &mut [f64], classes: usize) -> Vec<f64> {
    let mut means = vec![0.0; classes];
    for (k, value) in x.iter().enumerate() {
        means[k % classes] += value * classes as f64 / x.len() as f64;
    }
    for (k, value) in x.iter_mut().enumerate() {
        *value -= means[k % classes];
    }
    let middle = means.iter().sum::<f64>() / classes as f64;
    means.iter().map(|mean| mean - middle).collect()
}
