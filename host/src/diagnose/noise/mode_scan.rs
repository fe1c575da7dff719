//! A coarse search for a torsional mode: every frequency of a grid, a few damping ratios and shares of the inertia.

use super::mode_likelihood::cost;
use super::spectral::Band;
use super::two_mass::TwoMass;

const DAMPINGS: [f64; 3] = [0.007, 0.02, 0.05];
const SHARES: [f64; 4] = [0.02, 0.1, 0.3, 0.6];
const LOADS: [f64; 2] = [0.0, 10.0];

/// The mode of a grid that explains most, its gain and how many were tried.
pub(super) fn scan(all: &[Vec<Band>], torque: f64, stamps: f64) -> Option<(TwoMass, f64, f64)> {
    let each = all.iter().flatten();
    let (low, high) = each.fold((f64::INFINITY, 0.0_f64), |(low, high), band| {
        (low.min(band.f_hz), high.max(band.f_hz))
    });
    let without: Vec<Vec<f64>> = all
        .iter()
        .map(|bands| {
            bands
                .iter()
                .map(|band| cost(&[*band], torque, stamps, None))
                .collect()
        })
        .collect();
    let mut best: Option<(TwoMass, f64)> = None;
    let mut places = 0.0;
    for damping_ratio in DAMPINGS {
        let reach = if damping_ratio < 0.01 { 1.2_f64 } else { 1.6 };
        for (inertia_share, load) in SHARES.iter().flat_map(|s| LOADS.map(|load| (*s, load))) {
            let shape = Shape::new(damping_ratio, inertia_share, load, reach);
            let mut f_hz = 1.5 * low;
            while f_hz < 0.9 * high {
                let mut gain = 0.0;
                for (bands, without) in all.iter().zip(&without) {
                    let from = bands.partition_point(|band| band.f_hz < f_hz / reach);
                    for (band, without) in bands[from..].iter().zip(&without[from..]) {
                        let Some(ratio) = shape.at(band.f_hz / f_hz) else {
                            break;
                        };
                        let expected = stamps * (1.0 - band.torque) + torque * band.torque * ratio;
                        gain +=
                            without - 2.0 * band.lines * (expected.ln() + band.power / expected);
                    }
                }
                places += 1.0;
                if best.is_none_or(|(_, other)| gain > other) {
                    let mode = TwoMass {
                        f_hz,
                        damping_ratio,
                        inertia_share,
                        load,
                    };
                    best = Some((mode, gain));
                }
                f_hz *= 1.0 + 0.75 * damping_ratio;
            }
        }
    }
    best.map(|(mode, gain)| (mode, gain, places))
}

/// A mode's gain over frequency, tabled.
struct Shape {
    low: f64,
    step: f64,
    gains: Vec<f64>,
}

impl Shape {
    fn new(damping_ratio: f64, inertia_share: f64, load: f64, reach: f64) -> Self {
        const ENTRIES: usize = 1500;
        let mode = TwoMass {
            f_hz: 1.0,
            damping_ratio,
            inertia_share,
            load,
        };
        let low = 1.0 / reach;
        let step = (reach - low) / (ENTRIES - 1) as f64;
        let gains = (0..ENTRIES).map(|at| mode.gain(low + step * at as f64, 0.0));
        Self {
            low,
            step,
            gains: gains.collect(),
        }
    }

    fn at(&self, ratio: f64) -> Option<f64> {
        self.gains
            .get(((ratio - self.low) / self.step + 0.5) as usize)
            .copied()
    }
}
