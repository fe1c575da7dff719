//! A made-up answer with every kind of finding in it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::diagnose::diagnosis::{Answer, Curve, Map, Sized};
use crate::diagnose::diagnosis::{
    Diagnosis, Evidence, Finding, Fit, HeldOut, NextRecording, Parameter, Place, RecordingFacts,
    RunnerUp, Verdict,
};
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::mechanism::Mechanism;

fn parameters(all: &[(&str, f64, &str, f64)]) -> BTreeMap<String, Parameter> {
    let parameter = |&(name, value, unit, half): &(&str, f64, &str, f64)| {
        let parameter = Parameter {
            value,
            unit: unit.to_owned(),
            ci95: (half > 0.0).then_some([value - half, value + half]),
        };
        (name.to_owned(), parameter)
    };
    all.iter().map(parameter).collect()
}

fn evidence(delta_bic: f64, next: Option<(Mechanism, f64)>) -> Evidence {
    Evidence {
        delta_bic,
        p_value: 0.0,
        held_out_rms_ratio: Some(0.41),
        lines_beside: Some(1.0),
        runner_up: next.map(|(mechanism, delta_bic)| RunnerUp {
            mechanism,
            delta_bic,
        }),
    }
}

fn finding(
    mechanism: Mechanism,
    confidence: f64,
    parameters: BTreeMap<String, Parameter>,
    evidence: Evidence,
) -> Finding {
    Finding {
        mechanism,
        text: String::new(),
        confidence,
        parameters,
        place: Place::default(),
        evidence,
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

/// A torque ripple at order 3.
pub(crate) fn ripple() -> Finding {
    finding(
        Mechanism::TorqueRipple,
        0.99998,
        parameters(&[
            ("torque_n_m", 2.0e-3, "N m", 1.1e-5),
            ("phase_rad", 0.9273, "rad", 5.5e-3),
            ("order", 3.0, "1", 0.0),
        ]),
        evidence(5210.4, Some((Mechanism::Eccentricity, 310.0))),
    )
}

fn growing_tone() -> Finding {
    finding(
        Mechanism::Unknown,
        0.984,
        parameters(&[
            ("torque_n_m", 4.1e-4, "1", 2.2e-5),
            ("phase_rad", 2.1, "1", 0.06),
            ("f_hz", 41.3, "1", 0.004),
        ]),
        evidence(212.0, None),
    )
}

fn delay() -> Finding {
    let mut one = finding(
        Mechanism::EdgeDelay,
        0.9999,
        parameters(&[("a.rise_less_fall_s", 1.339e-6, "s", 4.1e-8)]),
        evidence(412.7, Some((Mechanism::WidthError, 1.8))),
    );
    one.look_alikes = vec![Mechanism::WidthError];
    one.next_recording = Some(next());
    one
}

fn next() -> NextRecording {
    NextRecording {
        text: "20 s at 60 r/min would tell edge_delay from width_error: Schwarz's criterion would differ by about 180".to_owned(),
    }
}

fn jitter() -> Finding {
    let mut one = finding(
        Mechanism::TimestampJitter,
        0.97,
        parameters(&[("jitter_s", 3.1e-7, "s", 2.0e-8)]),
        evidence(88.0, Some((Mechanism::CaptureLatency, 21.0))),
    );
    one.text = "stamps spread by 310 ns RMS, 280 ns more than declared".to_owned();
    one.evidence.held_out_rms_ratio = None;
    one
}

fn lost() -> Finding {
    let mut one = finding(
        Mechanism::LostEdges,
        0.999,
        parameters(&[("count", 7.0, "1", 0.0)]),
        evidence(1000.0, None),
    );
    one.text = "edges are missing at 7 instants".to_owned();
    one.evidence.held_out_rms_ratio = None;
    one.place.times_s = (1..=7).map(|n| 1.25 * f64::from(n)).collect();
    one
}

fn friction() -> Finding {
    finding(
        Mechanism::Friction,
        0.9996,
        parameters(&[
            ("coulomb_n_m", 1.2e-3, "N m", 4e-5),
            ("viscous_n_m_s", 2.0e-5, "N m s", 3.1e-5),
        ]),
        evidence(96.0, Some((Mechanism::LoadStep, 44.0))),
    )
}

/// An effect that stays, with sizes.
pub(crate) fn sized(site: Site, carrier: Carrier, sizes: &[f64]) -> Sized {
    Sized {
        effect: Effect::new(site, carrier),
        sizes: sizes.to_vec(),
        ci95: Vec::new(),
        at_speed: None,
    }
}

fn recording(file: &str, r_min: f64) -> RecordingFacts {
    RecordingFacts {
        file: file.to_owned(),
        twin: "rig.toml".to_owned(),
        edges: 40_000,
        edges_recorded: 40_000,
        turns: 20.0,
        seconds: 20.0 * 60.0 / r_min,
        other_speed_r_min: None,
        speed_r_min: [r_min, 1.002 * r_min],
        anchored: true,
        start_rad: None,
        stamp_rms_s: Some(3.4e-7),
        disturbed_s: vec![1.25, 2.5],
        left_out: Vec::new(),
    }
}

fn curve(file: &str, seconds: f64) -> Curve {
    let noise = |n: u32, by: f64| ((f64::from(n) * by).sin() * 43_758.547).fract() * 1e-5;
    let time_s: Vec<f64> = (0..4000).map(|n| seconds * f64::from(n) / 4000.0).collect();
    let of = |(n, t): (u32, &f64)| {
        3.1e-4 * (TAU * 3.0 * t).sin()
            + 4e-5 * (1.0 + 0.03 * t) * (TAU * 41.3 * t).sin()
            + noise(n, 12.9898)
    };
    Curve {
        file: file.to_owned(),
        before_rad: (0..).zip(&time_s).map(of).collect(),
        after_rad: (0..4000).map(|n| noise(n, 78.233)).collect(),
        time_s,
    }
}

/// A map of all sites and carriers of the brief kind; what cannot be has no value.
fn map() -> Map {
    let no = None;
    let some = Some;
    Map {
        sites: vec!["torque", "drive", "disc", "level", "stamp"],
        carriers: vec![
            "order",
            "frequency",
            "place",
            "edge class",
            "instant",
            "slow time",
            "direction",
            "speed",
        ],
        before: vec![
            vec![
                some(5210.0),
                some(212.4),
                some(48.0),
                no,
                some(31.0),
                no,
                no,
                some(24.6),
            ],
            vec![no, some(3.2), no, no, some(2.4), some(1.1), no, no],
            vec![
                some(1890.0),
                no,
                some(36.1),
                some(207.0),
                no,
                no,
                some(0.4),
                no,
            ],
            vec![no, some(11.2), no, some(0.0), no, some(1.9), no, no],
            vec![some(9.7), some(6.1), no, some(412.7), no, no, no, some(4.4)],
        ],
        after: vec![
            vec![
                some(3.1),
                some(6.4),
                some(2.2),
                no,
                some(4.0),
                no,
                no,
                some(1.2),
            ],
            vec![no, some(2.8), no, no, some(1.9), some(0.7), no, no],
            vec![some(4.4), no, some(14.6), some(1.3), no, no, some(0.2), no],
            vec![no, some(3.3), no, some(0.1), no, some(1.4), no, no],
            vec![some(2.0), some(1.8), no, some(1.1), no, no, no, some(0.9)],
        ],
    }
}

/// Two recordings and six findings: named, without a name, one that may be another, noise, counted, and one of several numbers.
pub(crate) fn full() -> Answer {
    let findings = vec![
        ripple(),
        delay(),
        growing_tone(),
        friction(),
        jitter(),
        lost(),
    ];
    let diagnosis = Diagnosis {
        version: 2,
        verdict: Verdict::Ambiguous,
        summary: "The twin lacked: torque ripple of motor or engine, rise and fall delayed unequally, friction, jitter, lost edges; these \
                  recordings allow other names for it."
            .to_owned(),
        recordings: vec![recording("slow.csv", 60.0), recording("fast.csv", 90.0)],
        fit: Fit {
            rms_before_rad: Some(2.23e-4),
            rms_after_rad: Some(6.1e-6),
            floor_rad: Some(5.8e-6),
            whiteness_p_before: Some(0.0),
            whiteness_p: Some(0.31),
            correlated_before: Some(0.42),
            correlated: Some(0.0),
            held_out: HeldOut {
                rms_before_rad: Some(2.25e-4),
                rms_after_rad: Some(6.3e-6),
                floor_rad: Some(5.8e-6),
                reducible_removed: Some(0.987),
            },
        },
        next_recording: findings[1].next_recording.clone(),
        findings,
    };
    let rises = On {
        channel: Some(0),
        rises: Some(true),
    };
    let tone = Sized {
        effect: Effect {
            growth: Growth::Even(0.03),
            ..Effect::new(Site::Torque, Carrier::Tone(41.3))
        },
        sizes: vec![3.5e-4, -2.1e-4],
        ci95: Vec::new(),
        at_speed: None,
    };
    Answer {
        diagnosis,
        map: map(),
        cells: vec![
            vec![sized(Site::Torque, Carrier::Order(3.0), &[1.6e-3, 1.2e-3])],
            vec![sized(Site::Stamp(rises), Carrier::Steady, &[1.339e-6])],
            vec![tone],
            vec![
                sized(Site::Torque, Carrier::Power(0.0), &[1.2e-3]),
                sized(Site::Torque, Carrier::Power(1.0), &[2.0e-5]),
            ],
            Vec::new(),
            Vec::new(),
        ],
        inertia_known: true,
        corrected: Vec::new(),
        declared: vec![Default::default(); 6],
        not_identifiable: Vec::new(),
        learned_speed_loop: None,
        learned_ringing: None,
        learned_disc_rms_rad: None,
        shares: vec![
            Some(0.874),
            Some(0.0312),
            Some(0.0207),
            Some(0.0004),
            None,
            None,
        ],
        pattern: None,
        curves: vec![curve("slow.csv", 20.0), curve("fast.csv", 13.3)],
    }
}

/// The same rig with nothing missing.
pub(crate) fn complete() -> Answer {
    let mut answer = full();
    answer.map.before = answer.map.after.clone();
    // Under what a parameter is worth: ln(80,000) is 11.3.
    answer.map.before[2][2] = Some(7.2);
    answer.map.after = answer.map.before.clone();
    answer.cells.clear();
    answer.shares.clear();
    for curve in &mut answer.curves {
        curve.before_rad = curve.after_rad.clone();
    }
    let diagnosis = &mut answer.diagnosis;
    diagnosis.verdict = Verdict::Complete;
    diagnosis.summary = "The twin explains the recordings: what is left is noise.".to_owned();
    diagnosis.findings.clear();
    diagnosis.next_recording = None;
    diagnosis.fit.rms_before_rad = diagnosis.fit.floor_rad;
    diagnosis.fit.whiteness_p_before = Some(0.31);
    diagnosis.fit.correlated_before = Some(0.0);
    diagnosis.fit.held_out = HeldOut {
        rms_before_rad: Some(5.9e-6),
        floor_rad: Some(5.8e-6),
        ..HeldOut::default()
    };
    answer
}
