//! A made-up diagnosis with every field in it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::diagnose::diagnosis::{
    Band, Diagnosis, Evidence, Expected, Finding, Fit, HeldOut, NextRecording, Parameter, Place,
    RecordingFacts, RunnerUp, Verdict,
};
use crate::diagnose::run::Diagnosed;
use crate::diagnose::shown::{FindingPlot, Line, RecordingPlot, Shown};
use crate::mechanism::Mechanism;
use crate::twin::Twin;

/// A small reproducible noise, about normal.
pub(crate) struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            *state ^= *state << 13;
            *state ^= *state >> 7;
            *state ^= *state << 17;
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
    }
}

fn parameters(all: &[(&str, f64, &str, f64)]) -> BTreeMap<String, Parameter> {
    let parameter = |&(name, value, unit, half): &(&str, f64, &str, f64)| {
        let parameter = Parameter {
            value,
            unit: unit.to_owned(),
            ci95: Some([value - half, value + half]),
        };
        (name.to_owned(), parameter)
    };
    all.iter().map(parameter).collect()
}

fn eccentricity() -> Finding {
    let expected = |mechanism, delta_bic| Expected {
        mechanism,
        delta_bic,
    };
    let next = NextRecording {
        text: "44 s at 30 r/min would tell eccentricity from torque_ripple: Schwarz's criterion would differ by about 180".to_owned(),
        expected_delta_bic: Some(184.0),
        expected: vec![
            expected(Mechanism::Eccentricity, 184.0),
            expected(Mechanism::TorqueRipple, 266.0),
        ],
    };
    Finding {
        mechanism: Mechanism::Eccentricity,
        text: "all edges alike, once a turn, largest at 121.3 degrees ± 0.2".to_owned(),
        confidence: 0.71,
        parameters: parameters(&[
            ("amplitude_rad", 4.981e-4, "rad", 2.3e-6),
            ("phase_rad", 0.5458, "rad", 4.6e-3),
        ]),
        place: Place {
            orders: vec![1.0],
            angles_deg: vec![121.3],
            ..Place::default()
        },
        evidence: Evidence {
            delta_bic: 2210.4,
            p_value: 0.0,
            held_out_rms_ratio: Some(0.38),
            runner_up: Some(RunnerUp {
                mechanism: Mechanism::TorqueRipple,
                delta_bic: 1.8,
            }),
        },
        look_alikes: vec![Mechanism::TorqueRipple],
        next_recording: Some(next),
    }
}

fn edge_delay() -> Finding {
    Finding {
        mechanism: Mechanism::EdgeDelay,
        text: "rising edges of both channels against falling ones".to_owned(),
        confidence: 0.9998,
        parameters: parameters(&[("rise_less_fall_s", 1.339e-6, "s", 4.1e-8)]),
        place: Place {
            orders: vec![2500.0],
            edge_classes: vec!["A rise".to_owned(), "B rise".to_owned()],
            channels: vec!["A".to_owned(), "B".to_owned()],
            directions: vec!["forward".to_owned()],
            speed_exponent: Some(1.02),
            frequencies_hz: vec![625.0],
            times_s: vec![0.25],
            ..Place::default()
        },
        evidence: Evidence {
            delta_bic: 412.7,
            p_value: 3.1e-12,
            held_out_rms_ratio: Some(0.83),
            runner_up: Some(RunnerUp {
                mechanism: Mechanism::WidthError,
                delta_bic: 61.0,
            }),
        },
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

fn facts(file: &str, twin: &str, r_min: f64) -> RecordingFacts {
    RecordingFacts {
        file: file.to_owned(),
        twin: twin.to_owned(),
        edges: 110_000,
        turns: 11.0,
        seconds: 660.0 / r_min,
        speed_r_min: [r_min, 1.002 * r_min],
        anchored: false,
        start_rad: Some(0.35),
        stamp_rms_s: Some(6.1e-9),
        disturbed_s: vec![12.3456],
    }
}

/// Two recordings, two findings, one of them ambiguous.
pub(crate) fn full() -> Diagnosed {
    let recordings = vec![
        facts("slow.csv", "slow.toml", 15.0),
        facts("fast.csv", "fast.toml", 18.0),
    ];
    let findings = vec![eccentricity(), edge_delay()];
    let fit = Fit {
        rms_before_rad: Some(3.72e-4),
        rms_after_rad: Some(1.23e-5),
        floor_rad: Some(1.19e-5),
        slow: Band {
            rms_before_rad: Some(2.12e-5),
            rms_after_rad: Some(2.11e-5),
            floor_rad: Some(2.09e-5),
        },
        edge_to_edge: Band {
            rms_before_rad: Some(4.1e-6),
            rms_after_rad: Some(3.2e-6),
            floor_rad: Some(3.2e-6),
        },
        whiteness_p_before: Some(0.0),
        whiteness_p: Some(0.31),
        held_out: HeldOut {
            rms_before_rad: Some(3.70e-4),
            rms_after_rad: Some(1.27e-5),
            floor_rad: Some(1.19e-5),
            reducible_removed: Some(0.987),
        },
    };
    let diagnosis = Diagnosis {
        version: 1,
        verdict: Verdict::Ambiguous,
        summary: "The twin lacks unequal delays of rise and fall, and something once a turn that is an eccentric disc or torque \
                  ripple: these recordings can't tell."
            .to_owned(),
        recordings,
        fit,
        next_recording: findings[0].next_recording.clone(),
        findings,
    };
    Diagnosed {
        diagnosis,
        shown: shown(),
        twins: ["slow", "fast"]
            .map(|name| twin(&format!("rig/{name}.toml")))
            .to_vec(),
        error_lists: vec![None, None],
    }
}

/// The same rig with nothing missing.
pub(crate) fn complete() -> Diagnosed {
    let mut diagnosed = full();
    let diagnosis = &mut diagnosed.diagnosis;
    diagnosis.verdict = Verdict::Complete;
    diagnosis.summary = String::new();
    diagnosis.findings.clear();
    diagnosis.next_recording = None;
    diagnosis.fit.rms_before_rad = diagnosis.fit.floor_rad;
    diagnosis.fit.held_out.reducible_removed = None;
    diagnosed.shown.findings.clear();
    diagnosed
}

/// A small twin by a file's name.
pub(crate) fn twin(name: &str) -> Twin {
    let text = include_str!("../../../twins/pair-slow.toml");
    Twin::parse(text, name).unwrap()
}

fn shown() -> Shown {
    let mut noise = Noise(7);
    let mut scattered = |x: &dyn Fn(f64) -> f64, y: &dyn Fn(f64) -> f64, size: f64, count: u32| {
        let line: Line = (0..count)
            .map(|n| f64::from(n) / f64::from(count))
            .map(|part| (x(part), y(part) + size * noise.next()))
            .collect();
        line
    };
    let degrees = |part: f64| 360.0 * part;
    let once = |part: f64| 498.0 * (TAU * part - 0.5458).sin();
    let classes = |part: f64| f64::from((4.0 * part).round() as u32);
    let delays = |part: f64| {
        if (4.0 * part).round() as u32 & 2 == 0 {
            1.0
        } else {
            -1.0
        }
    };
    let findings = vec![
        FindingPlot {
            mechanism: Mechanism::Eccentricity,
            x_label: "angle of the disc, degrees".to_owned(),
            y_label: "residual, urad".to_owned(),
            before: scattered(&degrees, &once, 12.0, 1000),
            after: scattered(&degrees, &|_| 0.0, 12.0, 1000),
            model: scattered(&degrees, &once, 0.0, 360),
        },
        FindingPlot {
            mechanism: Mechanism::EdgeDelay,
            x_label: "edge class".to_owned(),
            y_label: "residual, urad".to_owned(),
            before: scattered(&classes, &delays, 0.02, 4),
            after: scattered(&classes, &|_| 0.0, 0.02, 4),
            model: Vec::new(),
        },
    ];
    let time = |part: f64| 44.0 * part;
    let turning = |part: f64| 498.0 * (TAU * 11.0 * part).sin();
    let order = |part: f64| 5000.0 * part;
    let power = |peak: f64| {
        move |part: f64| {
            let near = (5000.0 * part - 1.0).abs() < 0.3;
            let exponential = -((part * 7919.0).fract() + 1e-9).ln();
            if near { peak } else { exponential }
        }
    };
    let mut recordings = Vec::new();
    for _ in 0..2 {
        recordings.push(RecordingPlot {
            before: scattered(&time, &turning, 12.0, 8000),
            after: scattered(&time, &|_| 0.0, 12.0, 8000),
            spectrum_before: scattered(&order, &power(4200.0), 0.0, 20_000),
            spectrum_after: scattered(&order, &power(2.0), 0.0, 20_000),
            threshold: 14.2,
        });
    }
    Shown {
        findings,
        recordings,
    }
}
