//! A fixed small sample of the blind trial: what is found must not fall below what was reached.

use std::path::Path;

use quadcal_blind::draw::Family;
use quadcal_host_tests::trial::cases::{Draw, Folders};
use quadcal_host_tests::trial::figures::{Figure, figures};
use quadcal_host_tests::trial::run::Quadcal;

const CASES: usize = 26;
const SEED: u64 = 11;

/// Value of the figure whose name begins like this.
fn value(figures: &[Figure], name: &str) -> f64 {
    let figure = figures.iter().find(|figure| figure.name.starts_with(name));
    figure
        .and_then(|figure| figure.value)
        .unwrap_or_else(|| panic!("no figure {name}"))
}

/// Figures of a few cases of one kind of draw.
fn drawn(draw: &Draw) -> Vec<Figure> {
    let folder = tempfile::tempdir().unwrap();
    let folders = Folders::within(folder.path());
    folders.draw(draw, 2, || {}).unwrap();
    let quadcal = Quadcal {
        program: Path::new(env!("CARGO_BIN_EXE_quadcal-under-test")).to_owned(),
    };
    let names = folders.names().unwrap();
    figures(&folders.judge(&names, &quadcal, 2, || {}).unwrap())
}

#[test]
fn nothing_false_is_said_in_noise_that_wanders_goes_with_the_speed_or_is_far_out() {
    let figures = drawn(&Draw {
        cases: 10,
        seed: 3,
        kind: None,
        family: Some(Family::Heavy),
        only: Vec::new(),
        again: 0,
    });
    let said = value(&figures, "heavy noise: cases with a false name over 99 %");
    assert!(said <= 0.0, "{said}");
    let right = value(&figures, "heavy noise: right mechanism first");
    assert!(right >= 0.99, "{right}");
}

#[test]
fn a_small_blind_trial_finds_what_it_found_before() {
    let figures = drawn(&Draw {
        cases: CASES,
        seed: SEED,
        kind: None,
        family: None,
        only: Vec::new(),
        again: 0,
    });
    let at_least = [
        ("the same, one only", 0.8),
        ("the same, masked only", 0.99),
        ("two or three effects: all named", 0.49),
        ("physics in no catalogue called unknown", 0.33),
        ("95 % intervals", 0.85),
        ("reducible RMS", 0.9),
        ("ambiguous pairs", 0.33),
    ];
    for (name, least) in at_least {
        let value = value(&figures, name);
        assert!(value >= least, "{name}: {value}, {least} before");
    }
    let at_most = [
        ("runs that failed", 0.0),
        ("physics in no catalogue given", 0.67),
    ];
    for (name, most) in at_most {
        let value = value(&figures, name);
        assert!(value <= most, "{name}: {value}, {most} before");
    }
}
