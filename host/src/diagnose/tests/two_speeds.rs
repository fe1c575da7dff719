//! What only recordings at two speeds tell apart.

use super::{recorded, twin};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::prepare;
use crate::diagnose::search::{Found, search};
use crate::mechanism::Mechanism;

/// What a search finds in two recordings of a rig with `more` to it than the twin says, each with noise of its own.
fn found(rig: impl Fn(f64) -> String, r_min: [f64; 2], seed: u64, more: &str) -> Vec<Found> {
    let each = r_min.into_iter().zip(2 * seed..).map(|(r_min, seed)| {
        let told = format!("seed = {seed}\n{}", rig(r_min));
        recorded(&twin(&format!("{told}{more}")), &twin(&told))
    });
    let mut board: Board = prepare::board(&each.collect::<Vec<_>>()).unwrap();
    search(&mut board).unwrap().found
}

#[test]
fn widths_of_two_channels_and_a_skew_are_not_taken_for_a_mixture_of_delays() {
    let rig = |r_min: f64| {
        format!(
            "duration = {{ turns = 40 }}\n[encoder.quadrature]\nlines = 200\nindex = true\n\
             [shaft]\ninertia_kg_m2 = 6.4e-3\nviscous_n_m_s = 4.4e-2\nstiffness_n_m_s = 5.2e-2\n\
             [drive.constant]\nr_min = {r_min}\n[noise.white]\npsd_n2_m2_s = 1.2e-6\n\
             [timer]\nclock_hz = 72000000\njitter_s = 1.6e-7\n"
        )
    };
    let more = "[errors]\nwidth_a_rad = 8.5e-6\nwidth_b_rad = 5.8e-6\n[channel_skew]\na_s = 8e-8\n";
    for seed in 1..4 {
        let found = found(rig, [252.6, 778.0], seed, more);
        let mut named: Vec<Mechanism> = found.iter().map(|f| f.hypothesis.mechanism).collect();
        named.sort_unstable();
        let mut both = [Mechanism::WidthError, Mechanism::ChannelSkew];
        both.sort_unstable();
        assert_eq!(named, both, "seed {seed}");
    }
}

#[test]
fn a_tone_between_the_edges_of_the_slower_recording_has_the_frequency_that_both_show() {
    let rig = |r_min: f64| {
        format!(
            "duration = {{ turns = 60 }}\n[encoder.wheel]\nteeth = 59\n\
             [shaft]\ninertia_kg_m2 = 1.5e-3\nviscous_n_m_s = 7e-4\nstiffness_n_m_s = 1.7e-3\n\
             initial_angle_rad = 0.65\n[drive.constant]\nr_min = {r_min}\n\
             [noise.white]\npsd_n2_m2_s = 1.7e-11\n[timer]\nclock_hz = 84000000\njitter_s = 3e-7\n"
        )
    };
    let more = "[[threshold_ripple]]\nf_hz = 100\nangle_rad = 2e-6\nphase_rad = 0.7\n";
    let found = found(rig, [44.3, 137.4], 1, more);
    let [one] = found.as_slice() else {
        panic!("{found:?}");
    };
    let Some(Basis::LevelTone { f_hz, .. }) = one.hypothesis.bases.first() else {
        panic!("{one:?}");
    };
    assert!((f_hz - 100.0).abs() < 2e-3, "{f_hz}");
}
