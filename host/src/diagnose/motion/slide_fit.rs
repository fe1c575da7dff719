//! The law of a sliding shaft that makes its edges most likely.

use nalgebra::{DMatrix, DVector};

use super::slide::{NUMBERS, Slide, SlideLaw, SlideNoise};
use crate::diagnose::noise_fit::simplex;

/// Steps of a fit.
const ROUNDS: usize = 30;
/// Numbers that are as good as none, as logarithms.
pub const NONE: f64 = -60.0;

/// A fit.
#[derive(Clone, Debug)]
pub struct SlideFit {
    /// The law's numbers.
    pub at: [f64; NUMBERS],
    /// Standard errors; zero where a number was given.
    pub errors: [f64; NUMBERS],
    /// The noise.
    pub noise: SlideNoise,
    /// -2 log likelihood.
    pub cost: f64,
}

/// Fits the numbers that are free, by Levenberg and Marquardt's way (SIAM J. Appl. Math. 11, 1963), and the noise by turns.
#[must_use]
pub fn fitted(
    slide: &Slide,
    start: [f64; NUMBERS],
    free: &[usize],
    noise: SlideNoise,
    turns: usize,
) -> Option<SlideFit> {
    let mut fit = descended(slide, start, free, noise)?;
    for _ in 0..turns {
        let noise = noise_of(slide, &fit);
        fit = descended(slide, fit.at, free, noise)?;
    }
    Some(fit)
}

/// The noise that what a fit leaves shows.
fn noise_of(slide: &Slide, fit: &SlideFit) -> SlideNoise {
    let law = SlideLaw::of(&fit.at);
    let of = |logs: &[f64]| SlideNoise {
        acceleration: logs[0].exp(),
        stamp_s: logs[1].exp(),
        ..fit.noise
    };
    let cost = |logs: &[f64]| cost(&law, slide, of(logs)).unwrap_or(f64::INFINITY);
    let start = [fit.noise.acceleration.ln(), fit.noise.stamp_s.ln()];
    of(&simplex(&cost, &start, 1.0))
}

fn cost(law: &SlideLaw, slide: &Slide, noise: SlideNoise) -> Option<f64> {
    let (white, scale) = law.white(slide, noise)?;
    Some(white.iter().map(|w| w * w).sum::<f64>() + scale)
}

fn descended(
    slide: &Slide,
    start: [f64; NUMBERS],
    free: &[usize],
    noise: SlideNoise,
) -> Option<SlideFit> {
    let left = |at: &[f64; NUMBERS]| SlideLaw::of(at).white(slide, noise);
    let pull = start[4].abs();
    if !(pull.is_finite() && pull > 0.0 && start[3].is_finite()) {
        return None;
    }
    let push = start[3].abs().max(pull * pull);
    let step = slide.ways.get(1)? - slide.ways.first()?;
    // Of the numbers that are no logarithms.
    let scales = [1.0, 1.0, 1.0, push, pull, 1.0, step, pull];
    let mut at = start;
    let (mut now, mut scale) = left(&at)?;
    let squares = |white: &[f64]| white.iter().map(|w| w * w).sum::<f64>();
    let mut cost = squares(&now) + scale;
    let mut held = 1e-2;
    let mut gram = DMatrix::zeros(free.len(), free.len());
    for _ in 0..ROUNDS {
        let mut slopes = DMatrix::zeros(now.len(), free.len());
        for (column, &number) in free.iter().enumerate() {
            let nudge = 1e-5 * scales[number];
            let mut aside = at;
            aside[number] += nudge;
            let there = left(&aside)?.0;
            for (row, (there, now)) in there.iter().zip(&now).enumerate() {
                slopes[(row, column)] = (there - now) / nudge;
            }
        }
        gram = slopes.transpose() * &slopes;
        let right = slopes.transpose() * DVector::from_column_slice(&now);
        let before = cost;
        for _ in 0..6 {
            let mut firm = gram.clone();
            for i in 0..free.len() {
                firm[(i, i)] *= 1.0 + held;
            }
            let step = firm.cholesky()?.solve(&right);
            let mut next = at;
            for (step, &number) in step.iter().zip(free) {
                let most = 0.7 * scales[number];
                next[number] -= step.clamp(-most, most);
            }
            let tried = left(&next).map(|(white, scale)| (squares(&white) + scale, white, scale));
            match tried {
                Some((less, white, its)) if less < cost => {
                    (at, now, scale, cost) = (next, white, its, less);
                    held *= 0.2;
                    break;
                }
                _ => held *= 6.0,
            }
        }
        if cost > before - 1e-3 {
            break;
        }
    }
    let _ = scale;
    let inverse = gram.try_inverse()?;
    let mut errors = [0.0; NUMBERS];
    for (i, &number) in free.iter().enumerate() {
        errors[number] = inverse[(i, i)].max(0.0).sqrt();
    }
    Some(SlideFit {
        at,
        errors,
        noise,
        cost,
    })
}
