//! The published method (Yin, Guo et al., doi 10.19650/j.cnki.cjsi.J2210801) in double precision, equation by equation.

use std::f64::consts::PI;

/// What equations (13), (14) and (18) give, rad.
#[derive(Debug, Clone)]
pub struct PaperEstimate {
    /// Error of every edge by (19), zero mean.
    pub error: Vec<f64>,
    /// xi_A by (13).
    pub xi_a: f64,
    /// xi_B by (13).
    pub xi_b: f64,
    /// p by (18).
    pub p: f64,
}

/// Window and order of section 4.
const WINDOW: usize = 31;
const ORDER: usize = 5;

/// Applies the method to `turns` turns out of `times` (in any unit; edge 0 first, one turn of margin at each end).
/// With `closed`, the running sum (14) is brought back to where it started after one turn.
#[must_use]
pub fn estimate(times: &[u64], lines: usize, turns: usize, closed: bool) -> PaperEstimate {
    let a = channel(times, lines, turns, 0, closed);
    let b = channel(times, lines, turns, 1, closed);
    let edges = 4 * lines;
    // (15): eps and xi of both channels taken off, p still in.
    let mut error = vec![0.0; edges];
    for i in 0..2 * lines {
        let falling = (i % 2) as f64;
        error[2 * i] = a.eps[i] + a.xi * falling;
        error[2 * i + 1] = b.eps[i] + b.xi * falling;
    }
    let step = 2.0 * PI / edges as f64;
    // (17), (18): at x4, with the angles of (15).
    let speeds: Vec<f64> = (0..times.len() - 1)
        .map(|i| {
            let moved = step - error[(i + 1) % edges] + error[i % edges];
            moved / (times[i + 1] - times[i]) as f64
        })
        .collect();
    let modulation = averaged_modulation(&speeds, edges, turns);
    let p = (0..edges)
        .map(|i| step * (1.0 - 1.0 / modulation[i]) * if i % 2 == 0 { 1.0 } else { -1.0 })
        .sum::<f64>()
        / edges as f64;
    for (k, e) in error.iter_mut().enumerate() {
        *e += p * (k % 2) as f64;
    }
    let mean = error.iter().sum::<f64>() / edges as f64;
    error.iter_mut().for_each(|e| *e -= mean);
    PaperEstimate {
        error,
        xi_a: a.xi,
        xi_b: b.xi,
        p,
    }
}

struct Channel {
    eps: Vec<f64>,
    xi: f64,
}

/// (3), (7), (20), (13), (14) on the x2 edges of one channel.
fn channel(times: &[u64], lines: usize, turns: usize, first: usize, closed: bool) -> Channel {
    let t: Vec<u64> = times.iter().skip(first).step_by(2).copied().collect();
    let samples = 2 * lines;
    let step = PI / lines as f64;
    let speeds: Vec<f64> = t.windows(2).map(|w| step / (w[1] - w[0]) as f64).collect();
    let modulation = averaged_modulation(&speeds, samples, turns);
    // The interval from i to i + 1 ends in a falling edge where i is even: its error step is + xi there, - xi elsewhere.
    let error_steps: Vec<f64> = modulation.iter().map(|a| step * (1.0 - 1.0 / a)).collect();
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let xi = error_steps
        .iter()
        .enumerate()
        .map(|(i, e)| sign(i) * e)
        .sum::<f64>()
        / samples as f64;
    let mut eps = vec![0.0; samples];
    let mut run = 0.0;
    for i in 0..samples {
        eps[i] = run;
        run += error_steps[i] - sign(i) * xi;
    }
    if closed {
        for (i, e) in eps.iter_mut().enumerate() {
            *e -= run * i as f64 / samples as f64;
        }
        let mean = eps.iter().sum::<f64>() / samples as f64;
        eps.iter_mut().for_each(|e| *e -= mean);
    }
    Channel { eps, xi }
}

/// (7) and (20): speed over smoothed speed, averaged over `turns` turns after one turn of margin.
fn averaged_modulation(speeds: &[f64], samples: usize, turns: usize) -> Vec<f64> {
    let taps = savgol_taps(WINDOW, ORDER);
    let half = WINDOW / 2;
    (0..samples)
        .map(|i| {
            (0..turns)
                .map(|r| {
                    let at = (r + 1) * samples + i;
                    // The last turn may end with the recording: its window is shifted by whole turns, not cut.
                    let at = if at + half >= speeds.len() {
                        at - samples
                    } else {
                        at
                    };
                    let smooth: f64 = taps
                        .iter()
                        .zip(&speeds[at - half..])
                        .map(|(c, w)| c * w)
                        .sum();
                    speeds[at] / smooth
                })
                .sum::<f64>()
                / turns as f64
        })
        .collect()
}

/// Smoothing taps (8)-(11): least-squares polynomial of `order` at the middle of `window` samples.
#[must_use]
pub fn savgol_taps(window: usize, order: usize) -> Vec<f64> {
    let half = (window / 2) as f64;
    let x: Vec<f64> = (0..window).map(|i| (i as f64 - half) / half).collect();
    // Orthonormal polynomials on the samples (Gram-Schmidt, twice for rounding); taps are sum of P_j(0) P_j(x).
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for degree in 0..=order {
        let mut column: Vec<f64> = x.iter().map(|x| x.powi(degree as i32)).collect();
        for _ in 0..2 {
            for b in &basis {
                let dot: f64 = b.iter().zip(&column).map(|(b, c)| b * c).sum();
                column.iter_mut().zip(b).for_each(|(c, b)| *c -= dot * b);
            }
        }
        let norm = column.iter().map(|c| c * c).sum::<f64>().sqrt();
        column.iter_mut().for_each(|c| *c /= norm);
        basis.push(column);
    }
    (0..window)
        .map(|i| basis.iter().map(|b| b[window / 2] * b[i]).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smoother_passes_minus_six_percent_at_the_alternating_frequency() {
        let taps = savgol_taps(31, 5);
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let gain: f64 = taps
            .iter()
            .enumerate()
            .map(|(i, c)| c * sign(i) * sign(15))
            .sum();
        assert!((gain + 0.0614).abs() < 1e-4, "{gain}");
        assert!((taps.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
