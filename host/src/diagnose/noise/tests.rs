mod task;

use super::super::board::{Board, Model};
use super::super::prepare;
use super::super::run::Recorded;
use super::super::run::diagnose;
use super::super::track::Track;
use super::resonance;
use super::rings::rings;
use super::spectral::stretches;
use super::{NoiseFinding, is_own, noise_findings, own_columns};
use crate::mechanism::Mechanism;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::Twin;

const SEEDS: [u64; 3] = [11, 12, 13];

/// Recordings at two speeds of a twin with `more`, against the twin without.
fn found(seed: u64, more: &str, jitter_s: f64) -> Vec<NoiseFinding> {
    let board = prepare::board(&rig(seed, "", more, jitter_s)).expect("a board");
    noise_findings(&board, &Model::none(&board))
}

fn rig(seed: u64, known: &str, more: &str, jitter_s: f64) -> Vec<Recorded> {
    let speeds = [200.0, 480.0];
    let each = speeds.iter();
    each.map(|r_min| recorded(seed, *r_min, known, more, jitter_s))
        .collect()
}

/// A recording of a twin with `known` and `more` against that with `known` alone.
fn recorded(seed: u64, r_min: f64, known: &str, more: &str, jitter_s: f64) -> Recorded {
    let text = |jitter_s: f64, more: &str| {
        format!(
            "duration = {{ turns = 40 }}\nseed = {seed}\n[encoder.quadrature]\nlines = 100\nindex = false\n\
             [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 4e-4\n[drive.constant]\nr_min = {r_min}\n\
             [noise.white]\npsd_n2_m2_s = 2e-10\n[timer]\nclock_hz = 84000000\njitter_s = {jitter_s:e}\n{more}"
        )
    };
    let twin = |text: String| Twin::parse(&text, "rig.toml").expect("a twin");
    let more = format!("{known}\n{more}");
    let known = twin(text(2e-7, known));
    let plan = SensorPlan {
        kind: SensorKind::Quadrature { index_state: None },
        lines: 100,
    };
    let real = twin(text(2e-7_f64.hypot(jitter_s), &more));
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
fn few_edges_that_are_far_off_are_no_noise_of_the_stamps() {
    for seed in SEEDS {
        let board = prepare::board(&rig(seed, "", "", 0.0)).expect("a board");
        let mut model = Model::none(&board);
        for left in &mut model.left {
            let each = left.iter_mut().skip(seed as usize).step_by(397);
            each.for_each(|left| *left += 20.0);
        }
        let found = noise_findings(&board, &model);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].mechanism, Mechanism::Unknown);
        near(&found[0], &[("share", 1.0 / 397.0, 0.1)]);
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

/// What declared noise leaves, with a swing of the white numbers on top: its phase in cycles and its size at a time.
fn with_swing(seed: u64, swing: impl Fn(f64) -> (f64, f64)) -> (Board, Model) {
    let board: Board = prepare::board(&rig(seed, "", "", 0.0)).expect("a board");
    let mut model = Model::none(&board);
    for (bench, left) in board.benches.iter().zip(&mut model.left) {
        let first = bench.seen.times_s[0];
        for (left, time_s) in left.iter_mut().zip(&bench.seen.times_s) {
            let (cycles, size) = swing((time_s - first) / bench.seen.seconds());
            *left += size * (std::f64::consts::TAU * cycles * bench.seen.seconds()).sin();
        }
    }
    (board, model)
}

#[test]
fn what_rings_for_a_while_or_sweeps_is_no_mode() {
    let mode = "[torsional_resonance]\nf_hz = 52.0\ndamping_ratio = 0.03\ninertia_share = 0.3";
    // A push's leftover rings at 52 Hz in a fifteenth of the time; a torque sweeps from 45 to 60 Hz.
    let local = |x: f64| {
        let there = (0.4..0.467).contains(&x);
        (52.0 * x, if there { 3.0 } else { 0.0 })
    };
    let sweep = |x: f64| (45.0 * x + 7.5 * x * x, 0.6);
    for seed in SEEDS {
        let board = prepare::board(&rig(seed, "", mode, 0.0)).expect("a board");
        let model = Model::none(&board);
        let found = resonance::find(&board, &model.left).expect("a mode");
        let rings_in = |board: &Board, model: &Model| {
            let parts = stretches(&board.benches[0], &model.left[0], 8);
            rings(&parts, &found, found.gains[0])
        };
        assert!(rings_in(&board, &model), "seed {seed}");
        for (board, model) in [with_swing(seed, local), with_swing(seed, sweep)] {
            assert!(!rings_in(&board, &model), "seed {seed}");
        }
    }
}

#[test]
fn a_mode_that_answers_the_twins_own_ripple_is_no_tone_beside_it() {
    let ripple = "[[ripple]]\norder = 8.0\ntorque_n_m = 1e-4";
    let mode = "[torsional_resonance]\nf_hz = 52.0\ndamping_ratio = 0.03\ninertia_share = 0.3";
    for seed in SEEDS {
        let rig = rig(seed, ripple, mode, 0.0);
        let board = prepare::board(&rig).expect("a board");
        assert_eq!(own_columns(&board, &rig).len(), 4);
        let found = diagnose(&rig, &mut |_, _| ()).expect("a diagnosis");
        let names: Vec<Mechanism> = found
            .diagnosis
            .findings
            .iter()
            .map(|f| f.mechanism)
            .collect();
        assert_eq!(names, [Mechanism::TorsionalResonance], "seed {seed}");
    }
}

#[test]
fn a_rhythm_is_the_twins_own_where_a_recording_has_it() {
    use super::super::basis::Basis;
    use super::super::hypothesis::Hypothesis;
    let rig = rig(
        SEEDS[0],
        "[[ripple]]\norder = 8.0\ntorque_n_m = 1e-4",
        "",
        0.0,
    );
    let board = prepare::board(&rig).expect("a board");
    let own = |f_hz: f64| {
        let tone = Hypothesis {
            mechanism: Mechanism::TorqueTone,
            bases: vec![Basis::TorqueTone { f_hz }],
        };
        is_own(&board, &rig, &tone)
    };
    // 8 x 200 / 60 and 8 x 480 / 60.
    assert!(own(26.67) && own(64.0));
    assert!(!own(29.0) && !own(60.0));
}
