//! The cell that models an effect, with or without a name in the catalogue.

use std::f64::consts::TAU;

use super::{against, said, twin};
use crate::diagnose::diagnosis::{Finding, Verdict};
use crate::diagnose::effect::{Carrier, Site};
use crate::effect::words::words;
use crate::mechanism::Mechanism;

#[test]
fn a_torque_whose_frequency_sweeps_is_one_effect_with_its_rate() {
    let rig = "duration = { turns = 40 }\n\n[encoder.quadrature]\nlines = 60\n\n[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\n\
               stiffness_n_m_s = 3e-4\n\n[drive.constant]\nr_min = 150\n\n[noise.white]\npsd_n2_m2_s = 1e-11\n\n[timer]\n\
               clock_hz = 84_000_000\njitter_s = 5e-8\n";
    // Over 14 Hz in 16 s, where one line tells 0.06 Hz apart, and over 0.5 Hz; each a torque that no line explains much of.
    for (seed, f_hz, rate) in [(1, 9.0, 0.9), (2, 30.0, -0.03)] {
        let sweep = format!(
            "[[effect]]\nsite = \"torque\"\nfollows = \"frequency\"\nf_hz = {f_hz}\nrate_hz_s = {rate}\nphase_rad = 1.0\n\
             torque_n_m = 6e-5\n"
        );
        let answer = against(&format!("seed = {seed}\n{rig}\n{sweep}"), rig);
        let [cells] = &answer.cells[..] else {
            panic!("{:?}", said(&answer));
        };
        let [one] = &cells[..] else {
            panic!("{:?}", said(&answer));
        };
        let Carrier::Chirp(..) = one.effect.carrier else {
            panic!("{:?}", said(&answer));
        };
        assert_eq!(one.effect.site, Site::Torque);
        for (truth, within) in [6e-5, f_hz, rate].into_iter().zip(&one.ci95) {
            let [low, high] = within.unwrap();
            let wide = 0.5 * (high - low);
            assert!(
                (low - wide..high + wide).contains(&truth),
                "{low} {high} {truth}"
            );
            assert!(wide < 0.1 * truth.abs());
        }
        assert!(answer.diagnosis.summary.contains(&*words(&one.effect)));
        let held_out = answer.diagnosis.fit.held_out;
        assert!(held_out.reducible_removed.unwrap() > 0.8);
    }
}

/// A rig whose speed doubles, so that what goes with the time is told from what goes with the angle.
const RAMP: &str = "duration = { turns = 40 }\n\n[encoder.quadrature]\nlines = 60\nindex = true\n\n[errors]\nwidth_a_rad = 1e-6\n\n[shaft]\n\
     inertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 3e-4\n\n[drive.ramp]\nfrom_r_min = 100\nto_r_min = 200\nover_s = 16\n\n\
     [noise.white]\npsd_n2_m2_s = 1e-11\n\n[timer]\nclock_hz = 84_000_000\njitter_s = 5e-8\n";

#[test]
fn what_one_channel_or_one_place_does_is_modelled_there_and_not_by_lines_of_all_edges() {
    let channel = "site = \"stamp\"\nchannel = \"a\"\n";
    let swings = |rest: &str| format!("{channel}{rest}phase_rad = 1.0\ndelay_s = 1e-6\n");
    let cases = [
        swings("follows = \"frequency\"\nf_hz = 4.7\n"),
        swings("follows = \"order\"\norder = 3\n"),
        "site = \"disc\"\nfollows = \"place\"\nangle_rad = 2.0\nwidth_rad = 0.1\nshift_rad = 2e-5\ngrowth_per_s = 0.3\n"
            .to_owned(),
        // A load that the drive does not balance: once "slow change of the drive's speed", over 99.9 %.
        "site = \"torque\"\ntorque_n_m = -1e-6\nspeed_power = 2.5\n".to_owned(),
    ];
    for effect in cases {
        let real = format!("{RAMP}\n[[effect]]\n{effect}");
        let answer = against(&real, RAMP);
        let truth = twin(&real).effect[0].effect();
        let cells: Vec<_> = answer.cells.iter().flatten().collect();
        let [one] = cells[..] else {
            panic!("{effect}: {:?}", said(&answer));
        };
        assert_eq!(one.effect.site, truth.site, "{:?}", said(&answer));
        let kind = std::mem::discriminant::<Carrier>;
        assert_eq!(kind(&one.effect.carrier), kind(&truth.carrier));
        let knobs = one.effect.knobs().into_iter().zip(truth.knobs());
        for ((knob, truth), within) in knobs.zip(&one.ci95[1..]) {
            // A whole order is exact.
            let [low, high] = within.unwrap_or([knob; 2]);
            let wide = 0.5 * (high - low);
            assert!(
                (low - wide..=high + wide).contains(&truth),
                "{low} {high} {truth}"
            );
            assert!(wide < truth, "{low} {high}");
        }
        let held_out = answer.diagnosis.fit.held_out;
        assert!(held_out.reducible_removed.unwrap() > 0.8);
    }
}

#[test]
fn a_comparator_s_level_off_the_middle_is_an_error_of_its_channel_s_width_and_place() {
    // Errors (-o, 0, o, 0) of each line are a wave of the line's order exactly: once a torque ripple of that order, or a drift of the level
    // that settles between two edges, over 99.9 %.
    let level = "[[effect]]\nsite = \"level\"\nchannel = \"a\"\nshift_rad = 4e-5\n";
    let names = |rig: &str| {
        let answer = against(&format!("{rig}\n{level}"), rig).diagnosis;
        let mut names: Vec<Mechanism> = answer.findings.iter().map(|one| one.mechanism).collect();
        names.sort();
        (names, answer)
    };
    let (of_a_ramp, answer) = names(RAMP);
    assert_eq!(
        of_a_ramp,
        [Mechanism::WidthError, Mechanism::QuadratureError]
    );
    for (at, name, truth) in [(0, "width_a_rad", 8e-5), (1, "quadrature_rad", 4e-5)] {
        let of = |one: &&Finding| one.mechanism == of_a_ramp[at];
        let found = answer.findings.iter().find(of).unwrap();
        let value = found.parameters[name].value;
        assert!((value.abs() / truth - 1.0).abs() < 0.1, "{name} {value}");
    }
    // One speed does not tell an angle from a delay.
    let steady = RAMP.replace(
        "[drive.ramp]\nfrom_r_min = 100\nto_r_min = 200\nover_s = 16",
        "[drive.constant]\nr_min = 150",
    );
    let (_, answer) = names(&steady);
    assert_eq!(answer.verdict, Verdict::Ambiguous);
}

#[test]
fn a_delay_of_one_channel_that_settles_is_modelled_as_one() {
    let delay = "[[effect]]\nsite = \"stamp\"\nchannel = \"b\"\nfollows = \"settling\"\nfrom_s = 0\ntau_s = 4\ndelay_s = 2e-6\n";
    let answer = against(&format!("{RAMP}\n{delay}"), RAMP);
    let cells: Vec<_> = answer.cells.iter().flatten().collect();
    let [one] = cells[..] else {
        panic!("{:?}", said(&answer));
    };
    // Two channels show only how late one is against the other.
    assert!(matches!(one.effect.site, Site::Stamp(on) if on.channel.is_some()));
    assert!(matches!(one.effect.carrier, Carrier::Settling(_, tau_s) if (tau_s - 4.0).abs() < 0.4));
    assert!(
        (one.sizes[0].abs() / 2e-6 - 1.0).abs() < 0.1,
        "{:?}",
        one.sizes
    );
}

#[test]
fn a_level_that_swings_once_in_every_two_turns_is_no_pick_up() {
    let rig = RAMP.replace(
        "[drive.ramp]\nfrom_r_min = 100\nto_r_min = 200\nover_s = 16",
        "[drive.constant]\nr_min = 150",
    );
    let level = "site = \"level\"\nphase_rad = 1.0\nshift_rad = 2e-5\n";
    let mechanisms = |follows: &str| -> Vec<Mechanism> {
        let real = format!("{rig}\n[[effect]]\n{follows}{level}");
        let answer = against(&real, &rig).diagnosis;
        answer.findings.iter().map(|one| one.mechanism).collect()
    };
    let two_turns = mechanisms("follows = \"order\"\norder = 1.5\n");
    assert_eq!(two_turns, [Mechanism::Unknown]);
    let other = mechanisms("follows = \"frequency\"\nf_hz = 4.7\n");
    assert_eq!(other, [Mechanism::ThresholdRipple]);
}

#[test]
fn an_edge_beside_a_gap_that_moves_with_the_speed_is_modelled_there_and_takes_no_name_from_a_ripple()
 {
    let rig = "duration = { turns = 40 }\n\n[encoder.wheel]\nteeth = 36\nmissing = 2\n\n[shaft]\ninertia_kg_m2 = 0.1\n\n[noise.white]\n\
               psd_n2_m2_s = 3e-3\n\n[timer]\nclock_hz = 1_000_000\njitter_s = 1e-6\n";
    let real = format!(
        "seed = 2\n{rig}\n[drive.ramp]\nfrom_r_min = 200\nto_r_min = 800\nover_s = 5\n\n[errors]\nposition = {{ normal = {{ rms_rad = 2e-3, \
         per = \"edge\" }} }}\n\n[[ripple]]\norder = 2\ntorque_n_m = 3\n\n[[effect]]\nsite = \"disc\"\nedge = \"rise\"\n\
         follows = \"place\"\nangle_rad = 0\nwidth_rad = 0.02\nshift_rad = 1e-2\nspeed_power = -0.5\n"
    );
    let answer = against(&real, rig);
    let cells = || answer.cells.iter().flatten();
    let beside = cells().find(|one| matches!(one.effect.carrier, Carrier::Bump(..)));
    let Some(beside) = beside else {
        panic!("{:?}", said(&answer));
    };
    let knobs = beside.effect.knobs();
    assert!(knobs[0].min(TAU - knobs[0]) < 0.05, "{knobs:?}");
    let [low, high] = beside.ci95[3].unwrap();
    assert!(low < -0.5 && -0.5 < high && high < 0.0, "{low} {high}");
    let there = beside.at_speed.unwrap();
    let truth = 1e-2 / there.rad_s.sqrt();
    let [low, high] = there.ci95;
    assert!(low < truth && truth < high, "{there:?} {truth}");
    let findings = &answer.diagnosis.findings;
    assert_eq!(findings[0].mechanism, Mechanism::TorqueRipple);
    assert!(findings[0].parameters.contains_key("torque_n_m"));
}

#[test]
fn an_edge_that_is_far_off_beside_a_gap_leaves_the_torques_of_an_engine_their_sizes_and_phases() {
    let rig = "duration = { turns = 40 }\n\n[encoder.wheel]\nteeth = 36\nmissing = 2\n\n[shaft]\ninertia_kg_m2 = 0.1\n\n[noise.white]\n\
               psd_n2_m2_s = 3e-3\n\n[timer]\nclock_hz = 1_000_000\njitter_s = 1e-6\n";
    let real = format!(
        "seed = 2\n{rig}\n[drive.ramp]\nfrom_r_min = 200\nto_r_min = 800\nover_s = 5\n\n[errors]\nposition = {{ normal = {{ rms_rad = 2e-4, \
         per = \"edge\" }} }}\n\n[[ripple]]\norder = 2\nphase_rad = 1\ntorque_n_m = 3\n\n[[ripple]]\norder = 4\nphase_rad = 1\n\
         torque_n_m = 1\n\n[[effect]]\nsite = \"disc\"\nedge = \"rise\"\nfollows = \"place\"\nangle_rad = 0\nwidth_rad = 0.02\n\
         shift_rad = -2e-2\n"
    );
    let answer = against(&real, rig);
    let [finding] = &answer.diagnosis.findings[..] else {
        panic!("{:?}", said(&answer));
    };
    assert_eq!(finding.mechanism, Mechanism::TorqueRipple);
    for (name, truth) in [("torque_n_m", 3.0), ("phase_rad", 1.0)] {
        let [low, high] = finding.parameters[name].ci95.unwrap();
        assert!(low < truth && truth < high, "{name}: {low} {high}");
    }
}
