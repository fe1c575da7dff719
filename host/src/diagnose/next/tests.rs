//! What is recommended, recorded for once.

use super::*;
use crate::diagnose::diagnosis::{Diagnosis, Verdict};
use crate::diagnose::run::diagnose;
use crate::diagnose::track::Track;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::{Drive, Duration, Twin};

const RIG: &str = "[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
                   [noise.white]\npsd_n2_m2_s = 1e-13\n[timer]\nclock_hz = 84000000\njitter_s = 1e-7\n";
const HEAD: &str = "duration = { turns = 40 }\n[encoder.quadrature]\nlines = 60\nindex = true\n";
const DRIVE: &str = "[drive.constant]\nr_min = 240\n";

fn told(drive: &Drive, duration: Duration) -> Twin {
    let twin = Twin::parse(&format!("{HEAD}{DRIVE}{RIG}"), "rig").unwrap();
    Twin {
        drive: drive.clone(),
        duration,
        ..twin
    }
}

/// A rig that has something that the twin lacks.
fn truth(lacks: &str) -> Twin {
    Twin::parse(&format!("{HEAD}{DRIVE}{lacks}{RIG}"), "rig").unwrap()
}

fn recorded(truth: &Twin, drive: &Drive, duration: Duration, seed: u64) -> Recorded {
    let truth = Twin {
        seed,
        drive: drive.clone(),
        duration,
        ..truth.clone()
    };
    let index_state = Some(quadcal::edge::Levels(quadcal::edge::Levels::A));
    let plan = SensorPlan {
        kind: SensorKind::Quadrature { index_state },
        lines: 60,
    };
    let rows = Simulation::new(&truth).unwrap();
    let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
    Recorded {
        file: String::new(),
        plan,
        track: Track::of(plan, truth.timer.clock_hz, rows).unwrap(),
        twin: told(drive, duration),
    }
}

fn said(rig: &[Recorded]) -> Diagnosis {
    diagnose(rig, &mut |_, _| {}).unwrap().diagnosis
}

/// The candidate that a text recommends.
fn recommended(first: &Recorded, text: &str) -> Candidate {
    let board = crate::diagnose::prepare::board(std::slice::from_ref(first)).unwrap();
    candidates(&first.twin, &board.benches[0])
        .into_iter()
        .find(|one| text.starts_with(&one.text))
        .unwrap()
}

#[test]
fn the_recommended_recording_gives_the_right_name_by_about_as_much_as_expected() {
    for (mechanism, lacks) in [
        (
            Mechanism::Eccentricity,
            "[errors]\neccentricity = { amplitude_rad = 2e-4, phase_rad = 0.4 }\n",
        ),
        (
            Mechanism::TorqueRipple,
            "[[ripple]]\norder = 1\ntorque_n_m = 1.2e-5\nphase_rad = 0.3\n",
        ),
        (
            Mechanism::EdgeDelay,
            "[edge_delay]\na = { rise_s = 3e-7, fall_s = 0 }\nb = { rise_s = 3e-7, fall_s = 0 }\n",
        ),
        (
            Mechanism::WidthError,
            "[errors]\nwidth_a_rad = 8e-6\nwidth_b_rad = 8e-6\n",
        ),
        (Mechanism::ChannelSkew, "[channel_skew]\nb_s = 4e-7\n"),
        (
            Mechanism::QuadratureError,
            "[errors]\nquadrature_rad = 1e-5\n",
        ),
    ] {
        for seed in 1..=2 {
            let truth = truth(lacks);
            let first = recorded(&truth, &truth.drive, truth.duration, seed);
            let alone = said(std::slice::from_ref(&first));
            assert_eq!(alone.verdict, Verdict::Ambiguous, "{mechanism}");
            let next = alone.next_recording.unwrap();
            let least = next.expected.iter().map(|e| e.delta_bic).reduce(f64::min);
            assert_eq!(next.expected_delta_bic, least);
            let expected = next
                .expected
                .iter()
                .find(|e| e.mechanism == mechanism)
                .unwrap();
            let to_make = recommended(&first, &next.text);
            let second = recorded(&truth, &to_make.drive, to_make.duration, 100 + seed);
            let both = said(&[first, second]);
            let found = &both.findings[0];
            assert_eq!(found.mechanism, mechanism, "{}", next.text);
            assert_eq!(both.verdict, Verdict::Explained, "{}", next.text);
            let delta = found.evidence.runner_up.unwrap().delta_bic;
            assert!(
                (1.0 / 3.0..3.0).contains(&(delta / expected.delta_bic)),
                "{mechanism}: {delta} came, {} was expected: {}",
                expected.delta_bic,
                next.text
            );
        }
    }
}

#[test]
fn what_leaves_the_same_edges_in_every_recording_is_said_not_to_be_simulated() {
    let drive = Drive::Ramp {
        from_r_min: 240.0,
        to_r_min: -240.0,
        over_s: 20.0,
    };
    let truth = truth("[hysteresis]\nangle_rad = 4e-4\n");
    let one = recorded(&truth, &drive, Duration::Seconds(20.0), 5);
    let said = said(&[one]);
    let found = &said.findings[0];
    assert_eq!(found.mechanism, Mechanism::Hysteresis);
    let next = found.next_recording.as_ref().unwrap();
    assert_eq!(next.expected_delta_bic, None);
    assert!(
        next.text.contains("same edges in every recording"),
        "{}",
        next.text
    );
}

#[test]
fn a_delay_of_one_channel_is_told_from_a_width_by_the_recommended_recording_of_both_speeds() {
    for (number, lacks) in [
        "[edge_delay]\na = { rise_s = 3e-6, fall_s = 1e-6 }\n",
        "[edge_delay]\nb = { rise_s = 3e-6, fall_s = 1e-6 }\n",
        "[edge_delay]\na = { rise_s = 3e-6, fall_s = 0 }\nb = { rise_s = 0, fall_s = 2e-6 }\n",
    ]
    .into_iter()
    .enumerate()
    {
        let seed = number as u64 + 1;
        let truth = truth(lacks);
        let first = recorded(&truth, &truth.drive, truth.duration, seed);
        let alone = said(std::slice::from_ref(&first));
        assert_eq!(alone.verdict, Verdict::Ambiguous, "{lacks}");
        // The channels lie off each other as well: whatever is recorded next has to tell both.
        for finding in &alone.findings {
            let next = finding.next_recording.as_ref().unwrap();
            assert!(next.expected_delta_bic.unwrap() > DECIDES, "{}", next.text);
        }
        let next = alone.next_recording.unwrap();
        let to_make = recommended(&first, &next.text);
        let second = recorded(&truth, &to_make.drive, to_make.duration, 100 + seed);
        let both = said(&[first, second]);
        let delay = both
            .findings
            .iter()
            .find(|f| f.mechanism == Mechanism::EdgeDelay);
        let delay = delay.unwrap_or_else(|| panic!("{lacks}: {both:?}"));
        let runner_up = delay.evidence.runner_up.as_ref();
        assert!(runner_up.is_none_or(|next| next.delta_bic > DECIDES));
        let truth = truth.edge_delay.unwrap();
        for (name, one) in [
            ("a.rise_less_fall_s", truth.a),
            ("b.rise_less_fall_s", truth.b),
        ] {
            let [low, high] = delay.parameters[name].ci95.unwrap();
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let off = middle - (one.rise_s - one.fall_s);
            assert!(off.abs() < 3.0 * half, "{lacks}: {name} {off} of {half}");
        }
    }
}

#[test]
fn what_only_the_rig_tells_from_a_gear_mesh_is_listed_with_what_tells_it() {
    for (order, mechanism, alike, verdict) in [
        (
            17.0,
            Mechanism::TorqueRipple,
            Mechanism::GearMesh,
            Verdict::Explained,
        ),
        (
            17.3,
            Mechanism::GearMesh,
            Mechanism::Bearing,
            Verdict::Explained,
        ),
    ] {
        let lacks = format!("[[gear_mesh]]\norder = {order}\ntorque_n_m = 2e-3\nphase_rad = 0.4\n");
        let truth = truth(&lacks);
        let first = recorded(&truth, &truth.drive, truth.duration, 3);
        let fast = Drive::Constant { r_min: 480.0 };
        let second = recorded(&truth, &fast, truth.duration, 4);
        let said = said(&[first, second]);
        let found = &said.findings[0];
        assert_eq!(
            (said.verdict, found.mechanism),
            (verdict, mechanism),
            "{order}"
        );
        assert_eq!(found.look_alikes, [alike]);
        let next = found.next_recording.as_ref().unwrap();
        assert!(
            next.text.contains("with the gear disconnected"),
            "{}",
            next.text
        );
        assert_eq!(next.expected_delta_bic, None);
        assert_eq!(said.next_recording.as_ref(), Some(next));
    }
}
