//! The estimator in double precision, written from its description alone: whole arrays, a plain Fourier sum, no rounding.
//!
//! Input are crossing times only, starting at edge 0. It shares no code with the core.

mod agree;
mod course;
mod delays;
mod moments;
mod noise;
mod plan;
mod turns;
mod weigh;

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use moments::{Moments, dot, minus};
use noise::{Noise, common_noise, damping_squares};
use plan::{Plan, coefficient, common_power};
use realfft::num_complex::Complex64;
use turns::straight;
use weigh::{Estimate, Weights};

/// Result of [`estimate`]. Angles in radians.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Error of every edge, zero mean.
    pub error: Vec<f64>,
    /// Expected RMS of what is left of the line position error.
    pub standard_error: f64,
    /// Weights of orders 1..=K.
    pub weights: Vec<f64>,
    /// Orders left alone as possibly torque.
    pub locked: Vec<usize>,
    /// Orders at which torque was told from geometry for certain, by turns of different speed.
    pub torques: Vec<usize>,
}

/// Estimates from the recordings of one encoder, fed one after the other. Each holds the times (any unit) of whole turns of
/// `edges` crossings and one more; its first turn only sets the rate. Torque is at multiples of `torque_base` only, at any
/// order with 0.
///
/// # Panics
/// When fewer than two turns can be used, or just one of either of two speeds.
#[must_use]
pub fn estimate(
    recordings: &[&[u64]],
    edges: usize,
    classes: usize,
    torque_base: usize,
) -> Reference {
    let plan = Plan::new(edges, classes);
    let turns = turns::read(recordings, plan);
    assert!(turns.len() >= 2, "two turns at least");
    let moments = Moments::of(&turns);
    let told = moments.separation.is_some();
    assert!(
        !told || turns.len() >= 3,
        "a turn of either speed leaves no contrast"
    );
    let (weighed, more) = (&moments.weighed, minus(&moments.plain, &moments.weighed));
    let signed = moments.contrast(weighed, &turns);
    let signed_more = minus(&moments.contrast(&moments.plain, &turns), &signed);
    let mut noise = Noise::of(plan, &turns, weighed, &signed);

    let mut mean = straight(&turns, weighed, 1);
    let mut offsets = take_class_means(&mut mean, classes);
    let of_mean = plan.by_order(|order| coefficient(&mean, order));
    let common_noise = common_noise(plan, &turns, weighed, noise.level[plan.single]);
    let mut found = of_mean.clone();
    let mut torques = Vec::new();
    let mut untold: Vec<usize> = if told {
        vec![]
    } else {
        plan.orders().collect()
    };
    // What damping may have left beyond what orders are weighed with.
    let mut hidden = 0.0;
    if let Some(share) = moments.separation {
        let doubt = Noise::of(plan, &turns, &more, &signed_more);
        let damping = damping_squares(&turns);
        let samples = straight(&turns, &more, plan.block);
        for order in plan.orders() {
            let difference = coefficient(&samples, order);
            let doubt = doubt.level[order];
            // Speeds near each other show a disc alike to one part in 1024 only.
            let unlike = found[order].norm_sqr() * (share.min(16.0) / 16_384.0).powi(2);
            // Torque for certain at twelve times the noise, none at half of that.
            let evidence = difference.norm_sqr() / (doubt + unlike);
            let belief = (evidence / 6.0 - 1.0).clamp(0.0, 1.0);
            if belief >= 1.0 {
                torques.push(order);
            }
            let all_torque = found[order].norm_sqr() / (share * share);
            if belief < 1.0 && all_torque < 12.0 * (doubt + unlike) {
                untold.push(order);
            }
            let mut more = 0.0;
            if evidence > 5.0 || difference.norm_sqr() > 12.0 * doubt {
                more = difference.norm_sqr() * (share * (1.0 - belief)).powi(2);
            }
            found[order] -= share * belief * difference;
            let damped = difference.norm_sqr() * (share * belief / order as f64).powi(2);
            let [likely, most] = damping.map(|square| square * damped);
            more += doubt * (share * belief).powi(2) + likely;
            hidden += most - likely;
            // What the contrast showed at the order itself is no more of that.
            let own = noise.level[order] * (noise.own[order] / 2.0).max(1.0);
            noise.level[order] += more;
            noise.own[order] = 2.0 * (own + more) / noise.level[order];
        }
    }
    let weights = Estimate {
        coefficients: &found,
        noise: &noise,
        common: common_power(plan, &mean, &of_mean),
        common_noise,
        torque_base,
        untold: &untold,
    }
    .weigh(plan);

    if let Some(delays) = delays::delays(&turns, plan) {
        let speed = dot(weighed, &turns, |turn| 1.0 / turn.ratio);
        for (offset, delay) in offsets.iter_mut().zip(delays) {
            *offset -= delay * speed;
        }
    }
    Reference {
        error: draw(plan, &mean, &of_mean, &found, &weights, &offsets),
        standard_error: (weights.residual + 2.0 * hidden).sqrt() * TAU,
        weights: weights.single[1..].to_vec(),
        locked: weights.locked,
        torques,
    }
}

/// The mean with its orders weighed, in radians. What is not believed of an order is the shaft's motion; where that made the
/// shaft fast by a share v, an error came out short by v of it, and that is put back (amplitude modulation, eq. (5)).
fn draw(
    plan: Plan,
    mean: &[f64],
    of_mean: &[Complex64],
    found: &[Complex64],
    weights: &Weights,
    offsets: &[f64],
) -> Vec<f64> {
    let edges = plan.edges;
    let wave = |size: Complex64, n: usize, k: usize| {
        2.0 * size * Complex64::cis(TAU * (n * k % edges) as f64 / edges as f64)
    };
    let at = |k: usize| {
        let (mut believed, mut slope) = (weights.common * mean[k] + offsets[k % plan.classes], 0.0);
        // Orders 1 and 2 are not put back: what the motion made of them lies at orders that noise drowns.
        let mut mounting = 0.0;
        for n in plan.orders() {
            let geometry = weights.single[n] * found[n];
            believed += wave(geometry - weights.common * of_mean[n], n, k).re;
            if n <= 2 {
                mounting += wave(geometry, n, k).re;
            }
            // With the angle in turns.
            slope -= wave(of_mean[n] - geometry, n, k).im * n as f64 * TAU;
        }
        believed + (believed - mounting) * slope
    };
    let mut error: Vec<f64> = (0..edges).map(|k| at(k) * TAU).collect();
    take_class_means(&mut error, 1);
    error
}

/// Takes the mean of every class out, and returns them less their own mean.
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
