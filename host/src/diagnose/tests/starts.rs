//! Recordings without an index whose twins do not say where the shaft starts.

use std::f64::consts::TAU;

use super::{recorded, twin};
use crate::diagnose::run::Recorded;
use crate::diagnose::search::search;
use crate::diagnose::{prepare, start};
use crate::mechanism::Mechanism;

const LINES: f64 = 150.0;
const DISC: &str = "position = { normal = { rms_rad = 3e-4 } }\n";
const ECCENTRIC: &str = "eccentricity = { amplitude_rad = 2e-3 }\n";

/// A recording that starts at an angle, with `disc` known and `hidden` errors of the disc that are not.
fn starting(at_rad: f64, r_min: f64, seed: u64, hidden: &str, disc: &str, more: &str) -> Recorded {
    // Where on the turn a torque is can be known only with the disc.
    let ripple = match disc {
        "" => "",
        _ => "[[ripple]]\norder = 2\ntorque_n_m = 1e-3\n",
    };
    let rig = |disc: &str, start: &str| {
        format!(
            "seed = {seed}\nduration = {{ turns = 12 }}\n[encoder.quadrature]\nlines = {LINES}\nindex = false\n\
             [errors]\nseed = 5\n{disc}[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\n\
             stiffness_n_m_s = 1e-3\n{start}[drive.constant]\nr_min = {r_min}\n\
             {ripple}\
             [noise.white]\npsd_n2_m2_s = 1e-12\n[timer]\nclock_hz = 84000000\njitter_s = 2e-7\n"
        )
    };
    let start = format!("initial_angle_rad = {at_rad}\n");
    let truth = rig(&format!("{disc}{hidden}"), &start);
    recorded(&twin(&format!("{truth}{more}")), &twin(&rig(disc, "")))
}

/// Edges from one start to another; a line has four, and the first two may come before a recording counts.
fn edges(from_rad: f64, to_rad: f64) -> f64 {
    let turns = (to_rad - from_rad) / TAU;
    (turns - turns.round()) * 4.0 * LINES
}

fn started_at(one: &Recorded) -> f64 {
    one.twin.shaft.initial_angle_rad
}

#[test]
fn a_disc_that_the_twin_knows_says_where_each_recording_starts() {
    for seed in 0..20 {
        let start = 0.05 + 0.31 * seed as f64;
        let r_min = [40.0, 500.0][seed as usize % 2];
        let mut rig = [starting(start, r_min, seed, "", DISC, "")];
        start::counted(&mut rig);
        let off = edges(start, started_at(&rig[0]));
        assert!(off.abs() < 1.8, "seed {seed}: {off}");
    }
}

#[test]
fn a_disc_that_no_twin_knows_ties_recordings_to_the_first() {
    for seed in 0..10 {
        let starts = [1.0 + seed as f64, 4.0];
        let mut rig = [(starts[0], 120.0), (starts[1], 600.0)].map(|(start, r_min)| {
            starting(
                start,
                r_min,
                2 * seed + u64::from(r_min > 200.0),
                DISC,
                "",
                "",
            )
        });
        start::counted(&mut rig);
        let [first, second] = [&rig[0], &rig[1]].map(started_at);
        let off = edges(starts[1] - starts[0], second - first);
        assert!(off.abs() < 1.8, "seed {seed}: {off}");
        assert!(prepare::board(&rig).unwrap().tied);
    }
}

#[test]
fn what_does_not_tell_lines_apart_ties_nothing() {
    let slight = "position = { normal = { rms_rad = 2e-7 } }\n";
    // Simulations with one seed have the same noise edge by edge.
    for (hidden, seeds) in [
        ("", [1, 2]),
        ("", [1, 1]),
        (slight, [3, 4]),
        (ECCENTRIC, [5, 6]),
    ] {
        let mut rig = [(1.0, 120.0, seeds[0]), (4.0, 600.0, seeds[1])]
            .map(|(start, r_min, seed)| starting(start, r_min, seed, hidden, "", ""));
        start::counted(&mut rig);
        assert_eq!(rig.map(|one| started_at(&one)), [0.0; 2], "{hidden}");
    }
}

#[test]
fn a_delay_is_told_from_the_disc_by_two_speeds_without_an_index() {
    let delay = "[edge_delay]\na = { rise_s = 2e-6 }\n";
    let mut rig = [(1.0, 120.0, 1), (4.0, 600.0, 2)]
        .map(|(start, r_min, seed)| starting(start, r_min, seed, DISC, "", delay));
    start::counted(&mut rig);
    let mut board = prepare::board(&rig).unwrap();
    let searched = search(&mut board).unwrap();
    // Few lines that err each by itself have a mean of some size, which is told too.
    let mut at = searched.nuisances;
    let mut named = Vec::new();
    for one in &searched.found {
        let size = searched.model.sizes.rows(at, one.columns.len()).amax();
        at += one.columns.len();
        let mean = [Mechanism::WidthError, Mechanism::QuadratureError];
        if !mean.contains(&one.hypothesis.mechanism) || size > 4.0 * 3e-4 / LINES.sqrt() {
            named.push(one.hypothesis.mechanism);
        }
    }
    assert_eq!(named, [Mechanism::EdgeDelay]);
    assert!(searched.pattern.is_some());
    // The noise is what it is once everything was found.
    for bench in &board.benches {
        assert!(
            (bench.noise.stamp_s / 2e-7 - 1.0).abs() < 0.1,
            "{:?}",
            bench.noise
        );
    }
}
