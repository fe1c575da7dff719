//! What a report draws of a finding: the size that was found, in bins that show it.

use super::super::run::diagnose;
use super::super::shown::FindingPlot;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

/// 83 lines: no number of bins keeps step with them by itself.
const RIG: &str = "duration = { turns = 30 }\nseed = 8\n[encoder.quadrature]\nlines = 83\nindex = true\n\
                   [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
                   [drive.constant]\nr_min = 300\n[noise.white]\npsd_n2_m2_s = 1e-12\n\
                   [timer]\nclock_hz = 84000000\njitter_s = 1e-6\n";

fn drawn(missing: &str, mechanism: Mechanism) -> FindingPlot {
    let told = twin(RIG);
    let truth = twin(&format!("{RIG}{missing}"));
    let found = diagnose(&[recorded(&truth, &told)], &mut |_, _| {}).unwrap();
    let mut plots = found.shown.findings.into_iter();
    plots.find(|plot| plot.mechanism == mechanism).unwrap()
}

fn range(line: &[(f64, f64)]) -> [f64; 2] {
    let each = line.iter().map(|(_, y)| *y);
    each.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| {
        [low.min(y), high.max(y)]
    })
}

#[test]
fn a_delay_of_one_channel_is_drawn_as_large_as_it_is_from_beginning_to_end() {
    let plot = drawn("[edge_delay.b]\nrise_s = 4e-5\n", Mechanism::EdgeDelay);
    // At 300 r/min 40 us are 1257 urad.
    let late = -1e6 * 4e-5 * 300.0 * std::f64::consts::TAU / 60.0;
    for line in [&plot.model, &plot.before] {
        let [low, high] = range(line);
        assert!(line.len() > 40, "{}", line.len());
        assert!(
            (low / late - 1.0).abs() < 0.03 && (high / late - 1.0).abs() < 0.03,
            "{low} to {high} of {late}"
        );
    }
}

#[test]
fn a_rhythm_is_drawn_around_nothing() {
    let missing = "[[gear_mesh]]\norder = 17.34\ntorque_n_m = 5e-3\nphase_rad = 1.0\n";
    let told = twin(RIG);
    let truth = twin(&format!("{RIG}{missing}"));
    let found = diagnose(&[recorded(&truth, &told)], &mut |_, _| {}).unwrap();
    let plot = &found.shown.findings[0];
    let [low, high] = range(&plot.model);
    assert!(high > 50.0, "{low} to {high}");
    assert!((low + high).abs() < 0.05 * (high - low), "{low} to {high}");
}
