//! A polynomial in time and one offset an edge, fitted together to a run-down (least squares), as chopper discs are calibrated in
//! production. What the speed does must be smooth: torque locked to the shaft passes for the disc.

use std::f64::consts::TAU;

/// Degree of the polynomial.
pub const DEGREE: usize = 5;

/// Error of every edge, zero mean, rad, from whole turns of `edges` times and one more, the first of an edge 0.
#[must_use]
pub fn estimate(times: &[u64], edges: usize) -> Vec<f64> {
    let last = times.len() - 1;
    let turns = (last / edges) as f64;
    let (start, length) = (times[0], (times[last] - times[0]) as f64);
    let base = |i: usize| legendre(2.0 * (times[i] - start) as f64 / length - 1.0);
    let angle = |i: usize| TAU * i as f64 / edges as f64;
    // Means over the turns of an edge, which its offset takes.
    let mut means = vec![[0.0; DEGREE + 1]; edges];
    for i in 0..last {
        let mean = &mut means[i % edges];
        for (sum, value) in mean.iter_mut().zip(base(i).into_iter().chain([angle(i)])) {
            *sum += value / turns;
        }
    }
    let mut normal = [[0.0; DEGREE + 1]; DEGREE];
    for i in 0..last {
        let mut off = [0.0; DEGREE + 1];
        off[..DEGREE].copy_from_slice(&base(i));
        off[DEGREE] = angle(i);
        for (value, mean) in off.iter_mut().zip(means[i % edges]) {
            *value -= mean;
        }
        for (row, factor) in normal.iter_mut().zip(off) {
            for (sum, value) in row.iter_mut().zip(off) {
                *sum += factor * value;
            }
        }
    }
    let factors = solved(normal);
    let error = means.iter().map(|mean| {
        let motion: f64 = factors.iter().zip(mean).map(|(f, m)| f * m).sum();
        mean[DEGREE] - motion
    });
    crate::accuracy::zero_mean(error.collect())
}

/// Legendre's polynomials of degree 1 on.
fn legendre(x: f64) -> [f64; DEGREE] {
    let mut all = [x; DEGREE];
    let (mut before, mut now) = (1.0, x);
    for (n, value) in all.iter_mut().enumerate() {
        *value = now;
        let n = n as f64 + 1.0;
        (before, now) = (now, ((2.0 * n + 1.0) * x * now - n * before) / (n + 1.0));
    }
    all
}

/// Solves equations whose matrix is positive definite (Gauss).
fn solved(mut rows: [[f64; DEGREE + 1]; DEGREE]) -> [f64; DEGREE] {
    for pivot in 0..DEGREE {
        let of_pivot = rows[pivot];
        for (n, row) in rows.iter_mut().enumerate() {
            let factor = if n == pivot {
                0.0
            } else {
                row[pivot] / of_pivot[pivot]
            };
            for (value, other) in row.iter_mut().zip(of_pivot) {
                *value -= factor * other;
            }
        }
    }
    std::array::from_fn(|n| rows[n][DEGREE] / rows[n][n])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_shaft_that_slows_down_it_finds_the_errors() {
        let errors = [3e-3, -1e-3, 2e-3, 0.0, -2e-3, -2e-3];
        let times: Vec<u64> = (0..=30 * 6)
            .map(|i| {
                let angle = TAU * f64::from(i) / 6.0 - errors[i as usize % 6];
                (-1e12 * (-(angle + 1.0) / 1000.0).ln_1p()) as u64
            })
            .collect();
        for (found, meant) in estimate(&times, 6).iter().zip(errors) {
            assert!((found - meant).abs() < 1e-7, "{found} {meant}");
        }
    }
}
