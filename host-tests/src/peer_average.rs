//! The plain average over turns: an edge is off by what the shaft, at each turn's mean speed, would be elsewhere at that time.

use std::f64::consts::TAU;

/// Error of every edge, zero mean, rad, from whole turns of `edges` times and one more, the first of an edge 0.
#[must_use]
pub fn estimate(times: &[u64], edges: usize) -> Vec<f64> {
    let turns = (times.len() - 1) / edges;
    let mut error = vec![0.0; edges];
    for turn in 0..turns {
        let at = &times[turn * edges..=(turn + 1) * edges];
        let length = (at[edges] - at[0]) as f64;
        for (k, e) in error.iter_mut().enumerate() {
            let passed = (at[k] - at[0]) as f64 / length;
            *e += TAU * (k as f64 / edges as f64 - passed) / turns as f64;
        }
    }
    crate::accuracy::zero_mean(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_a_steady_speed_it_finds_the_errors() {
        let errors = [3e-3, -1e-3, 2e-3, 0.0, -2e-3, -2e-3];
        let times: Vec<u64> = (0..19)
            .map(|i| {
                let angle = TAU * f64::from(i) / 6.0 - errors[i as usize % 6];
                (1e9 * (angle + 1.0)) as u64
            })
            .collect();
        for (found, meant) in estimate(&times, 6).iter().zip(errors) {
            assert!((found - meant).abs() < 1e-8, "{found} {meant}");
        }
    }
}
