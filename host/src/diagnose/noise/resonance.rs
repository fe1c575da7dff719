//! `torsional_resonance`: a lightly damped mode that torque noise excites.
//!
//! Fitted to the spectrum of what is left ([`super::mode_fit`]); it stands at the same Hz in every recording, and rings all the time
//! ([`super::rings`]).

use super::super::board::Board;
use super::super::kalman::ShaftNoise;
use super::mode_fit::{LEAST_GAIN, MISFIT, Mode, search};
use super::mode_likelihood::off;
use super::odds::{anywhere, normal_above};
use super::rings::{rings, stretches_of};
use super::spectral::{Band, bands, held_s, stretches};
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;

/// The twin's name of the density of torque noise on the far side.
pub const LOAD: &str = "load_psd_n2_m2_s";

impl Mode {
    /// As a finding.
    #[must_use]
    pub fn finding(&self, board: &Board) -> NoiseFinding {
        let masses = self.masses;
        let psd = self.load_psd(board);
        let names = ["f_hz", "damping_ratio", "inertia_share", LOAD];
        let values = [masses.f_hz, masses.damping_ratio, masses.inertia_share, psd];
        let [.., of_load] = self.errors;
        let errors = self.errors.into_iter().take(3).chain([psd * of_load]);
        let parameters = names.into_iter().zip(values).zip(errors);
        let count = if psd > 0.0 { 4 } else { 3 };
        let behind = if psd > 0.0 {
            ", which is shaken too"
        } else {
            ""
        };
        NoiseFinding {
            mechanism: Mechanism::TorsionalResonance,
            parameters: parameters
                .take(count)
                .map(|((name, value), standard_error)| NoiseParameter {
                    name,
                    value,
                    standard_error,
                })
                .collect(),
            delta_bic: self.gain - count as f64 * (board.edges() as f64).ln(),
            p_value: anywhere(normal_above(self.gain.sqrt()), self.places),
            text: format!(
                "torque noise excites a mode at {:.4} Hz, damping ratio {:.3}, with {:.0} % of the inertia behind the spring{behind}",
                masses.f_hz,
                masses.damping_ratio,
                100.0 * masses.inertia_share
            ),
            frequencies_hz: vec![masses.f_hz],
            times_s: Vec::new(),
            edge_classes: Vec::new(),
            runner_up: None,
            busy: None,
        }
    }

    /// Density of the torque noise on the far side, N^2 m^2 s, in the first recording.
    fn load_psd(&self, board: &Board) -> f64 {
        let bench = &board.benches[0];
        let near = self.levels[0] * (bench.noise.acceleration + bench.noise.load);
        self.masses.load * near * bench.law.inertia.powi(2)
    }
}

/// Looks for a mode in what a model leaves, white, that rings all the time.
#[must_use]
pub fn find(board: &Board, left: &[Vec<f64>]) -> Option<Mode> {
    if board.benches.iter().any(|bench| bench.law.spring.is_some()) {
        let all = all_bands(board, left);
        if off(&all, [0.0, f64::INFINITY], &|_| 1.0) < MISFIT {
            return None;
        }
        // Not the one that the twins have: what there is instead shows on a stiff shaft.
        let (board, left) = stiff(board, left);
        return find(&board, &left);
    }
    let mode = search(&all_bands(board, left))?;
    let each = board.benches.iter().zip(left);
    let shown = each.zip(&mode.gains).all(|((bench, white), gain)| {
        if *gain < LEAST_GAIN {
            return true;
        }
        let count = stretches_of(held_s(bench), &mode.masses);
        rings(&stretches(bench, white, count), &mode, *gain)
    });
    shown.then_some(mode)
}

/// The spectrum of whole recordings, in bands.
fn all_bands(board: &Board, left: &[Vec<f64>]) -> Vec<Vec<Band>> {
    let each = board.benches.iter().zip(left);
    each.map(|(bench, white)| bands(bench, white)).collect()
}

/// What is left as if no twin had a spring.
fn stiff(board: &Board, left: &[Vec<f64>]) -> (Board, Vec<Vec<f64>>) {
    let mut stiff = board.clone();
    stiff.forget();
    let each = stiff.benches.iter_mut().zip(left);
    let left = each.map(|(bench, left)| {
        let mut angles = left.clone();
        bench.whitener().restore(&mut angles);
        bench.law.spring = None;
        let readings = &mut bench.seen.readings;
        readings.iter_mut().for_each(|one| one.leap.spring = None);
        bench.set_noise(ShaftNoise {
            acceleration: bench.noise.acceleration + bench.noise.load,
            load: 0.0,
            ..bench.noise
        });
        bench.whitened(angles)
    });
    let left = left.collect();
    (stiff, left)
}
