//! Sections of mechanisms: kept, checked, refused.

use super::*;

/// A twin with every section that a mechanism has, and values that are allowed together.
fn all_mechanisms() -> Twin {
    let mut twin = Twin::paper();
    twin.shaft.coulomb_n_m = 1e-4;
    twin.shaft.drag_n_m_s2 = 1e-6;
    twin.shaft.stribeck_n_m = 2e-4;
    twin.shaft.stribeck_rad_s = 0.5;
    twin.local_defect = vec![LocalDefect {
        angle_rad: 1.5,
        width_rad: 2e-3,
        error_rad: -1e-4,
        channel: Some(Channel::B),
        edge: Some(Flank::Fall),
    }];
    twin.gear_mesh = vec![Ripple {
        order: 7.25,
        phase_rad: 0.5,
        torque_n_m: Some(1e-5),
        speed_fraction: None,
    }];
    twin.bearing = vec![Bearing {
        order: 3.57,
        phase_rad: 0.25,
        torque_n_m: None,
        speed_fraction: None,
        runout_rad: Some(1e-4),
    }];
    twin.torque_tone = vec![TorqueTone {
        f_hz: 50.5,
        phase_rad: 0.75,
        torque_n_m: None,
        speed_fraction: Some(1e-3),
    }];
    twin.speed_drift = Some(SpeedDrift {
        fraction_per_s: None,
        fraction: Some(0.0625),
        tau_s: Some(3.5),
    });
    twin.stick_slip = Some(StickSlip {
        stiffness_n_m_rad: 0.125,
    });
    twin.torsional_resonance = Some(TorsionalResonance {
        f_hz: 80.5,
        damping_ratio: 0.03125,
        inertia_share: 0.375,
        load_psd_n2_m2_s: Some(1e-13),
        load_hold_s: Some(1.5e-4),
    });
    twin.threshold_ripple = vec![ThresholdRipple {
        f_hz: 100.5,
        phase_rad: 1.25,
        angle_rad: 1.5e-5,
        channel: Some(Channel::A),
    }];
    twin.threshold_drift = vec![ThresholdDrift {
        angle_rad: -2.5e-5,
        tau_s: 6.5,
        from_s: 1.75,
        channel: None,
    }];
    twin.hysteresis = Some(Hysteresis {
        angle_rad: 3.5e-5,
        channel: Some(Channel::B),
    });
    twin.backlash = Some(Backlash { gap_rad: 1.5e-3 });
    twin.index_slip = vec![IndexSlip {
        at_s: 4.5,
        edges: -3,
    }];
    twin.capture_latency = Some(CaptureLatency {
        mean_s: None,
        task_hz: Some(1000.5),
        busy_s: Some(2.5e-5),
        phase_s: Some(1.5e-5),
    });
    twin
}

#[test]
fn every_mechanism_is_kept_and_runs() {
    let twin = all_mechanisms();
    let text = twin.to_toml().unwrap();
    let back = Twin::parse(&text, "paper").unwrap();
    assert_eq!(back, twin);
    let events = crate::sim::Simulation::new(&twin).unwrap().take(30_000);
    assert_eq!(events.count(), 30_000);
    // What is not there is not written.
    let plain = paper_text();
    for key in ["stribeck", "local_defect", "backlash", "capture_latency"] {
        assert!(text.contains(key) && !plain.contains(key), "{key}");
    }
}

#[test]
fn a_mechanism_out_of_its_range_is_placed_by_line_and_key() {
    let text = all_mechanisms().to_toml().unwrap();
    for (from, to, key) in [
        (
            "width_rad = 0.002",
            "width_rad = 0.0",
            "local_defect[0].width_rad",
        ),
        (
            "error_rad = -0.0001",
            "error_rad = 4.0",
            "local_defect[0].error_rad",
        ),
        (
            "channel = \"b\"\nedge",
            "channel = \"c\"\nedge",
            "local_defect[0].channel",
        ),
        ("order = 7.25", "order = 0.0", "gear_mesh[0].order"),
        (
            "runout_rad = 0.0001",
            "runout_rad = -1.0",
            "bearing[0].runout_rad",
        ),
        ("f_hz = 50.5", "f_hz = 2e6", "torque_tone[0].f_hz"),
        (
            "fraction = 0.0625",
            "fraction = -1.0",
            "speed_drift.fraction",
        ),
        ("tau_s = 3.5", "tau_s = 0.0", "speed_drift.tau_s"),
        (
            "stiffness_n_m_rad = 0.125",
            "stiffness_n_m_rad = 0.0",
            "stick_slip.stiffness_n_m_rad",
        ),
        (
            "damping_ratio = 0.03125",
            "damping_ratio = 1.5",
            "torsional_resonance.damping_ratio",
        ),
        (
            "inertia_share = 0.375",
            "inertia_share = 1.0",
            "torsional_resonance.inertia_share",
        ),
        (
            "stribeck_rad_s = 0.5",
            "stribeck_rad_s = -0.5",
            "shaft.stribeck_rad_s",
        ),
        (
            "drag_n_m_s2 = 0.000001",
            "drag_n_m_s2 = -0.1",
            "shaft.drag_n_m_s2",
        ),
        ("f_hz = 100.5", "f_hz = -100.5", "threshold_ripple[0].f_hz"),
        (
            "angle_rad = 0.000015",
            "angle_rad = 0.1",
            "threshold_ripple[0].angle_rad",
        ),
        ("tau_s = 6.5", "tau_s = nan", "threshold_drift[0].tau_s"),
        (
            "from_s = 1.75",
            "from_s = -1.75",
            "threshold_drift[0].from_s",
        ),
        (
            "angle_rad = 0.000035",
            "angle_rad = -1.0",
            "hysteresis.angle_rad",
        ),
        ("gap_rad = 0.0015", "gap_rad = 4.0", "backlash.gap_rad"),
        ("edges = -3", "edges = 0", "index_slip[0].edges"),
        ("at_s = 4.5", "at_s = -4.5", "index_slip[0].at_s"),
        (
            "task_hz = 1000.5",
            "task_hz = 0.0",
            "capture_latency.task_hz",
        ),
        (
            "busy_s = 0.000025",
            "busy_s = 0.1",
            "capture_latency.busy_s",
        ),
    ] {
        let to_find = to.lines().next().unwrap();
        let at = text
            .find(from)
            .unwrap_or_else(|| panic!("{from} in\n{text}"));
        let line = text[..at].lines().count() + 1;
        let changed = text.replacen(from, to, 1);
        let bad = bad_value(&changed);
        let found = (bad.key.as_str(), bad.place.position.map(|p| p.0));
        assert_eq!(found, (key, Some(line)), "{to_find}");
        assert!(!bad.advice.is_empty() && !bad.allowed.is_empty());
    }
}

#[test]
fn mechanisms_that_contradict_the_rig_or_themselves_are_refused() {
    let with = |change: &dyn Fn(&mut Twin)| {
        let mut twin = all_mechanisms();
        change(&mut twin);
        twin
    };
    for (twin, key) in [
        (
            with(&|t| t.bearing[0].torque_n_m = Some(1e-5)),
            "bearing[0]",
        ),
        (with(&|t| t.gear_mesh[0].torque_n_m = None), "gear_mesh[0]"),
        (
            with(&|t| t.torque_tone[0].torque_n_m = Some(1.0)),
            "torque_tone[0]",
        ),
        (
            with(&|t| t.speed_drift = Some(SpeedDrift::default())),
            "speed_drift",
        ),
        (
            with(&|t| t.capture_latency = Some(CaptureLatency::default())),
            "capture_latency",
        ),
        (
            with(&|t| t.shaft.stribeck_rad_s = 0.0),
            "shaft.stribeck_rad_s",
        ),
        (
            with(&|t| {
                t.encoder = Encoder::Quadrature {
                    lines: 2500,
                    index: false,
                };
            }),
            "index_slip[0]",
        ),
        (
            with(&|t| {
                t.drive = Drive::SpeedLoop {
                    r_min: 15.0,
                    f_hz: 1e4,
                    bandwidth_hz: Some(100.0),
                    kp_n_m_s: None,
                    ki_n_m: None,
                    timeout_s: None,
                    limit_n_m: None,
                };
            }),
            "speed_drift",
        ),
    ] {
        match twin.check() {
            Err(TwinError::Value(bad)) => assert_eq!(bad.key, key),
            other => panic!("{key}: {other:?}"),
        }
    }
}
