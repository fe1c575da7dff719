mod cost;
mod drives;
mod edit;
mod gaps;
mod mechanisms;
mod whole;

use super::*;

fn paper_text() -> String {
    Twin::paper().to_toml().unwrap()
}

fn bad_value(text: &str) -> BadValue {
    match Twin::parse(text, "rig.toml") {
        Err(TwinError::Value(bad)) => *bad,
        other => panic!("expected a bad value, got {other:?}"),
    }
}

#[test]
fn a_twin_written_out_reads_back_the_same() {
    let text = paper_text();
    let back = Twin::parse(&text, "paper").unwrap();
    assert_eq!(back, Twin::paper());
    assert_eq!(back.to_toml().unwrap(), text);
}

#[test]
fn delays_are_kept_and_a_key_they_do_not_have_is_refused() {
    let mut twin = Twin::paper();
    twin.edge_delay = Some(EdgeDelay {
        a: RiseFall {
            rise_s: 1e-6,
            fall_s: 2.5e-7,
        },
        ..EdgeDelay::default()
    });
    let text = twin.to_toml().unwrap();
    assert_eq!(Twin::parse(&text, "paper").unwrap(), twin);
    let text = text.replace("rise_s = 1e-6", "rise_us = 1");
    let text = text.replace("rise_s = 0.000001", "rise_us = 1");
    match Twin::parse(&text, "rig.toml") {
        Err(TwinError::Syntax { key, .. }) => assert_eq!(key, "edge_delay.a.rise_us"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn loads_are_kept_and_one_that_goes_before_it_comes_is_refused() {
    let mut twin = Twin::paper();
    twin.load_step = vec![
        LoadStep {
            torque_n_m: -2e-3,
            from_s: 1.5,
            until_s: None,
        },
        LoadStep {
            torque_n_m: 1e-3,
            from_s: 2.5,
            until_s: Some(3.25),
        },
    ];
    let text = twin.to_toml().unwrap();
    assert_eq!(Twin::parse(&text, "paper").unwrap(), twin);
    for (from, to, key) in [
        ("until_s = 3.25", "until_s = 2.5", "load_step[1].until_s"),
        ("until_s = 3.25", "until_s = nan", "load_step[1].until_s"),
        ("from_s = 1.5", "from_s = -1.5", "load_step[0].from_s"),
        (
            "torque_n_m = 0.001",
            "torque_n_m = 1e7",
            "load_step[1].torque_n_m",
        ),
    ] {
        let text = text.replace(from, to);
        let bad = bad_value(&text);
        let line = text.lines().position(|l| l == to).unwrap() + 1;
        assert_eq!(
            (bad.key.as_str(), bad.place.position.map(|p| p.0)),
            (key, Some(line))
        );
    }
}

#[test]
fn a_value_out_of_range_names_line_column_key_value_and_range() {
    let text = paper_text().replace("lines = 2500", "lines = 0");
    let bad = bad_value(&text);
    let line = text.lines().position(|l| l == "lines = 0").unwrap() + 1;
    assert_eq!(bad.place.position, Some((line, 9)));
    assert_eq!(bad.key, "encoder.quadrature.lines");
    assert_eq!(bad.value, "0");
    assert_eq!(bad.allowed, "1 to 1000000");
    let shown = TwinError::Value(Box::new(bad)).to_string();
    assert!(
        shown.starts_with(&format!(
            "rig.toml:{line}:9: encoder.quadrature.lines = 0: "
        )),
        "{shown}"
    );
}

#[test]
fn an_entry_of_a_list_is_named_by_its_number_and_found() {
    let text = paper_text().replace("order = 10.0", "order = nan");
    let bad = bad_value(&text);
    let line = text.lines().position(|l| l == "order = nan").unwrap() + 1;
    assert_eq!(
        (bad.key.as_str(), bad.place.position),
        ("ripple[1].order", Some((line, 9)))
    );
}

#[test]
fn an_unknown_key_and_a_wrong_type_are_placed() {
    for (from, to, key, column) in [
        ("index = true", "indx = true", "encoder.quadrature.indx", 1),
        (
            "clock_hz = 84000000",
            "clock_hz = \"fast\"",
            "timer.clock_hz",
            12,
        ),
        ("r_min = 15.0", "r_min = 15,0", "", 11),
    ] {
        let text = paper_text().replace(from, to);
        let line = text.lines().position(|l| l == to).unwrap() + 1;
        match Twin::parse(&text, "rig.toml") {
            Err(TwinError::Syntax {
                place, key: found, ..
            }) => {
                assert_eq!(place.position, Some((line, column)), "{to}");
                assert_eq!(found, key, "{to}");
            }
            other => panic!("{to}: {other:?}"),
        }
    }
}

#[test]
fn conflicts_are_refused() {
    let mut wander = Twin::paper();
    wander.shaft.stiffness_n_m_s = 1e-3;
    wander.noise = Some(Noise::SpeedWander {
        rms_fraction: 0.01,
        correlation_rad: Some(0.5),
        hold_s: None,
    });
    let mut both_sizes = Twin::paper();
    both_sizes.ripple[0].torque_n_m = Some(1e-3);
    let mut list_and_parts = Twin::paper();
    list_and_parts.errors.list_rad = vec![0.0; 10_000];
    let mut loop_and_wander = Twin::paper();
    loop_and_wander.noise = wander.noise;
    loop_and_wander.drive = Drive::SpeedLoop {
        r_min: 15.0,
        f_hz: 1e4,
        bandwidth_hz: Some(100.0),
        kp_n_m_s: None,
        ki_n_m: None,
        timeout_s: None,
        limit_n_m: None,
    };
    let mut two_gains = Twin::paper();
    two_gains.drive = Drive::SpeedLoop {
        r_min: 15.0,
        f_hz: 1e4,
        bandwidth_hz: Some(100.0),
        kp_n_m_s: Some(1.0),
        ki_n_m: None,
        timeout_s: None,
        limit_n_m: None,
    };
    let mut no_channel = Twin::paper();
    no_channel.encoder = Encoder::Wheel {
        teeth: 60,
        missing: 2,
        gaps: Vec::new(),
    };
    let mut third = Twin::paper();
    third.channel_skew = Some(ChannelSkew {
        c_s: 1e-6,
        ..ChannelSkew::default()
    });
    let mut ahead = Twin::paper();
    ahead.edge_delay = Some(EdgeDelay {
        b: RiseFall {
            rise_s: 0.0,
            fall_s: -1e-6,
        },
        ..EdgeDelay::default()
    });
    for (twin, key) in [
        (third, "channel_skew.c_s"),
        (ahead, "edge_delay.b.fall_s"),
        (wander, "noise.speed_wander.correlation_rad"),
        (both_sizes, "ripple[0]"),
        (list_and_parts, "errors.list_rad"),
        (loop_and_wander, "noise.speed_wander"),
        (two_gains, "drive.speed_loop.bandwidth_hz"),
        (no_channel, "errors.width_b_rad"),
    ] {
        match twin.check() {
            Err(TwinError::Value(bad)) => assert_eq!(bad.key, key),
            other => panic!("{key}: {other:?}"),
        }
    }
}

#[test]
fn every_number_that_is_not_finite_is_refused() {
    let text = paper_text();
    let mut tried = 0;
    for (i, line) in text.lines().enumerate() {
        let Some((key, value)) = line.split_once(" = ") else {
            continue;
        };
        if value.parse::<f64>().is_err() || !value.contains(['.', 'e']) {
            continue;
        }
        for bad in ["nan", "inf", "-inf"] {
            let changed: String = text
                .lines()
                .enumerate()
                .map(|(j, l)| {
                    if i == j {
                        format!("{key} = {bad}\n")
                    } else {
                        format!("{l}\n")
                    }
                })
                .collect();
            assert!(
                matches!(Twin::parse(&changed, "rig"), Err(TwinError::Value(_))),
                "{key} = {bad} was taken"
            );
        }
        tried += 1;
    }
    assert!(tried > 15, "only {tried} numbers were found to try");
}

#[test]
fn a_seed_that_toml_cannot_hold_is_an_error_and_not_another_seed() {
    let twin = Twin {
        seed: u64::MAX,
        ..Twin::paper()
    };
    match twin.to_toml() {
        Err(TwinError::Value(bad)) => assert_eq!(bad.key, "seed"),
        other => panic!("{other:?}"),
    }
    let mut twin = Twin::paper();
    twin.errors.seed = Some(u64::MAX);
    match twin.to_toml() {
        Err(TwinError::Value(bad)) => assert_eq!(bad.key, "errors.seed"),
        other => panic!("{other:?}"),
    }
}
