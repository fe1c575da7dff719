//! One kind of edge of one channel comes late.

use std::collections::BTreeSet;

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

const LATE_S: f64 = 3e-7;

fn rig(drive: &str) -> String {
    format!(
        "duration = {{ turns = 14 }}\n[encoder.quadrature]\nlines = 500\nindex = true\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 2e-3\n\
         [drive]\n{drive}\n[noise.white]\npsd_n2_m2_s = 1e-12\n\
         [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n"
    )
}

fn of(seed: u64, drive: &str, late: &str) -> Diagnosis {
    let rig = rig(drive);
    let truth = format!("seed = {seed}\n{rig}{late}");
    let one = recorded(&twin(&truth), &twin(&rig));
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

fn late(channel: &str) -> String {
    format!("[edge_delay.{channel}]\nfall_s = {LATE_S}\n")
}

/// At one speed that may be the disc's as well as the capture's.
#[test]
fn at_one_speed_a_late_fall_may_be_a_width() {
    for (seed, channel) in [(1, "a"), (2, "b"), (3, "b")] {
        let said = of(seed, "constant = { r_min = 300 }", &late(channel));
        assert_eq!(said.verdict, Verdict::Ambiguous, "{:?}", said.findings);
        let one = &said.findings[0];
        let names: BTreeSet<Mechanism> = one
            .look_alikes
            .iter()
            .copied()
            .chain([one.mechanism])
            .collect();
        let both = [Mechanism::EdgeDelay, Mechanism::WidthError];
        assert_eq!(names, BTreeSet::from(both), "{one:?}");
    }
}

/// Where the speed changes it is a delay of that channel alone, and no skew beside.
#[test]
fn at_several_speeds_a_late_fall_is_one_delay() {
    for (seed, channel) in [(4, "a"), (5, "b")] {
        let drive = "ramp = { from_r_min = 100, to_r_min = 600, over_s = 2 }";
        let said = of(seed, drive, &late(channel));
        assert_eq!(said.verdict, Verdict::Explained, "{:?}", said.findings);
        let [one] = &said.findings[..] else {
            panic!("{:?}", said.findings);
        };
        assert_eq!(one.mechanism, Mechanism::EdgeDelay);
        let size = &one.parameters[&format!("{channel}.rise_less_fall_s")];
        assert!((size.value + LATE_S).abs() < 3e-9, "{size:?}");
        assert!(one.text.contains("fall later"), "{}", one.text);
    }
}
