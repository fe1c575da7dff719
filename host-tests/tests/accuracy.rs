//! The accuracy that docs/accuracy.md claims, on a fixed sample of seeds. `accuracy --seeds 200 --check` sweeps more.
#![allow(missing_docs)]

use quadcal_host_tests::accuracy::{RunErrors, Scenario, median, order_ratios, run};

fn runs(scenario: Scenario, seeds: std::ops::Range<u64>) -> Vec<RunErrors> {
    seeds
        .map(|seed| run(&scenario.twin(seed)).errors())
        .collect()
}

fn middle(runs: &[RunErrors], pick: impl Fn(&RunErrors) -> f64) -> f64 {
    median(runs.iter().map(pick).collect())
}

#[test]
fn every_scenario_keeps_its_target_on_seeds_never_tuned_to() {
    for scenario in Scenario::ALL {
        let runs = runs(scenario, 7001..7006);
        if let Some(target) = scenario.target_removed() {
            let removed = middle(&runs, |e| 1.0 - e.ours / e.raw);
            assert!(removed >= target, "{}: {removed}", scenario.name());
        } else {
            let table = middle(&runs, |e| e.table);
            assert!(table < 1e-6, "{}: invented {table:e} rad", scenario.name());
        }
    }
}

#[test]
fn width_and_quadrature_errors_are_within_two_thousandths_without_noise() {
    let runs = runs(Scenario::Quiet, 7001..7006);
    let worst = runs
        .iter()
        .filter_map(|e| e.class_error)
        .fold(0.0, f64::max);
    assert!(worst < 0.002, "{worst}");
}

#[test]
fn fixed_point_is_within_a_hundredth_of_the_standard_error_of_double_precision() {
    for scenario in [Scenario::Quiet, Scenario::Wander01, Scenario::Wander1] {
        let ratio = middle(&runs(scenario, 7001..7006), |e| {
            e.from_reference / e.standard_error
        });
        assert!(ratio < 0.01, "{}: {ratio}", scenario.name());
    }
    // Nothing to estimate: both tables are zero but for rounding, one unit being 1.5e-9 rad.
    let off = middle(&runs(Scenario::Perfect, 7001..7006), |e| e.from_reference);
    assert!(off < 1.5e-9, "{off:e}");
}

#[test]
fn the_standard_error_is_the_error_to_be_expected() {
    for scenario in [Scenario::Quiet, Scenario::Wander01, Scenario::Wander1] {
        let ratio = middle(&runs(scenario, 7001..7016), |e| e.ours / e.standard_error);
        assert!((0.7..1.4).contains(&ratio), "{}: {ratio}", scenario.name());
    }
}

#[test]
fn no_order_is_made_worse() {
    for scenario in [Scenario::Wander01, Scenario::Wander1] {
        let worst = order_ratios(scenario, 7001..7041)
            .into_iter()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        // A weight near zero leaves an order as it is; two percent is for the chance in 40 runs.
        assert!(
            worst.1 < 1.02,
            "{}: order {} has {} times the power",
            scenario.name(),
            worst.0,
            worst.1
        );
    }
}

#[test]
fn no_run_makes_the_encoder_worse() {
    for scenario in [Scenario::Quiet, Scenario::Wander01, Scenario::Wander1] {
        let worst = runs(scenario, 7001..7041)
            .iter()
            .map(|e| e.ours / e.raw)
            .fold(0.0, f64::max);
        assert!(worst < 0.1, "{}: {worst}", scenario.name());
    }
}
