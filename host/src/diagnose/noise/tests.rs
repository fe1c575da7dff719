use super::super::board::{Board, Model};
use super::super::prepare;
use super::super::run::Recorded;
use super::super::track::Track;
use super::{NoiseFinding, noise_findings};
use crate::mechanism::Mechanism;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::Twin;

const SEEDS: [u64; 3] = [11, 12, 13];

/// Recordings at two speeds of a twin with `more`, against the twin without.
fn found(seed: u64, more: &str, jitter_s: f64) -> Vec<NoiseFinding> {
    let rig: Vec<Recorded> = [200.0, 480.0]
        .iter()
        .map(|r_min| recorded(seed, *r_min, more, jitter_s))
        .collect();
    let board: Board = prepare::board(&rig).expect("a board");
    noise_findings(&board, &Model::none(&board))
}

fn recorded(seed: u64, r_min: f64, more: &str, jitter_s: f64) -> Recorded {
    let text = |jitter_s: f64, more: &str| {
        format!(
            "duration = {{ turns = 40 }}\nseed = {seed}\n[encoder.quadrature]\nlines = 100\nindex = false\n\
             [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 4e-4\n[drive.constant]\nr_min = {r_min}\n\
             [noise.white]\npsd_n2_m2_s = 2e-10\n[timer]\nclock_hz = 84000000\njitter_s = {jitter_s:e}\n{more}"
        )
    };
    let twin = |text: String| Twin::parse(&text, "rig.toml").expect("a twin");
    let known = twin(text(2e-7, ""));
    let plan = SensorPlan {
        kind: SensorKind::Quadrature { index_state: None },
        lines: 100,
    };
    let real = twin(text(2e-7_f64.hypot(jitter_s), more));
    let rows = Simulation::new(&real)
        .expect("it runs")
        .map(|event| Ok::<_, PlanError>(event.row));
    let track = Track::of(plan, real.timer.clock_hz, rows).expect("it decodes");
    Recorded {
        file: "rec.csv".into(),
        plan,
        track,
        twin: known,
    }
}

/// The finding's numbers are within so many of their standard errors, and shares of the truth.
fn near(finding: &NoiseFinding, truth: &[(&str, f64, f64)]) {
    for (name, value, share) in truth {
        let parameter = finding.parameters.iter().find(|p| p.name == *name);
        let parameter = parameter.unwrap_or_else(|| panic!("{name} in {finding:?}"));
        let off = (parameter.value - value).abs();
        assert!(
            off < 4.5 * parameter.standard_error && off < share * value,
            "{name} {value}: {parameter:?}"
        );
    }
}

#[test]
fn declared_noise_is_no_finding() {
    for seed in SEEDS {
        assert_eq!(found(seed, "", 0.0), Vec::new(), "seed {seed}");
    }
}

#[test]
fn worse_stamps_are_jitter_with_what_comes_on_top() {
    for seed in SEEDS {
        let found = found(seed, "", 3e-7);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].mechanism, Mechanism::TimestampJitter);
        near(&found[0], &[("jitter_s", 3e-7, 0.1)]);
    }
}

#[test]
fn late_stamps_are_told_from_jitter_by_their_skewness() {
    for seed in SEEDS {
        let found = found(seed, "[capture_latency]\nmean_s = 3e-7", 0.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].mechanism, Mechanism::CaptureLatency);
        near(&found[0], &[("mean_s", 3e-7, 0.1)]);
    }
}

#[test]
fn a_mode_that_torque_noise_excites_is_found_with_its_numbers() {
    for seed in SEEDS {
        let mode = "[torsional_resonance]\nf_hz = 52.0\ndamping_ratio = 0.03\ninertia_share = 0.3";
        let found = found(seed, mode, 0.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].mechanism, Mechanism::TorsionalResonance);
        near(
            &found[0],
            &[
                ("f_hz", 52.0, 0.05),
                ("damping_ratio", 0.03, 0.8),
                ("inertia_share", 0.3, 0.3),
            ],
        );
    }
}
