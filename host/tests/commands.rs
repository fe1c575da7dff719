//! Simulate, calibrate, verify and demo as a user meets them, the whole way.

mod workshop;

use std::fs;
use std::path::Path;

use workshop::{TWIN, done, json, workshop};

#[test]
fn from_a_twin_to_a_table_that_holds_on_later_turns_and_against_the_reference() {
    let folder = workshop();
    let at = folder.path();
    let recording = fs::read_to_string(at.join("rig.csv")).unwrap();
    assert!(!recording.contains("error") && recording.contains("ticks,a,b,z"));
    let found = json(&done(
        at,
        "calibrate rig.csv --turns 11 -o again.qct --csv table.csv --report cal.html --json -",
    ));
    assert_eq!(found["lines"], 50);
    assert_eq!(found["turns"]["used"], 11);
    let bytes = |name| fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("rig.qct"), bytes("again.qct"));
    // Every row of the table agrees with the truth, which only this test puts beside it; the angle's zero is free.
    let column = |name: &str, at_column: usize| -> Vec<f64> {
        let text = fs::read_to_string(at.join(name)).unwrap();
        let rows = text.lines().skip(1);
        rows.map(|row| row.split(',').nth(at_column).unwrap().parse().unwrap())
            .collect()
    };
    let (table, truth) = (column("table.csv", 2), column("truth.csv", 1));
    assert_eq!((table.len(), truth.len()), (200, 200));
    let rest: Vec<f64> = table.iter().zip(&truth).map(|(a, b)| a - b).collect();
    let mean = rest.iter().sum::<f64>() / 200.0;
    assert!(rest.iter().all(|e| (e - mean).abs() < 4e-5), "{rest:?}");
    let check = json(&done(
        at,
        "verify rig.csv --table rig.qct --reference ref.csv --ratio 8 --report ver.html --json -",
    ));
    assert_eq!(check["verdict"], "better");
    assert_eq!(check["same_recording"], true);
    let rmse = |key: &str| check["reference"][key].as_f64().unwrap();
    assert!(
        rmse("rmse_after_rad") < 0.02 * rmse("rmse_before_rad"),
        "{check}"
    );
    for report in ["cal.html", "ver.html"] {
        let page = fs::read_to_string(at.join(report)).unwrap();
        assert!(page.contains("<svg") && !page.contains("NaN"), "{report}");
    }
}

/// The rig with torque ripple at order 3 at a given speed.
fn rippled(r_min: u32) -> String {
    TWIN.replace("= 600", &format!("= {r_min}")).replace(
        "[drive.constant]",
        "[[ripple]]\norder = 3\nphase_rad = 0.4\ntorque_n_m = 5e-3\n[drive.constant]",
    )
}

fn slow_and_fast(at: &Path) {
    for (name, r_min) in [("slow", 300), ("fast", 1200)] {
        fs::write(at.join(format!("{name}.toml")), rippled(r_min)).unwrap();
        done(
            at,
            &format!("simulate {name}.toml -o {name}.csv --truth {name}-truth.csv"),
        );
    }
}

/// Writes a recording again with the times that `time` makes of ticks and levels, before and after.
fn retimed(at: &Path, from: &str, to: &str, time: impl Fn(f64, &str, &str) -> f64) {
    let text = fs::read_to_string(at.join(from)).unwrap();
    let mut before = "";
    let lines = text.lines().map(|line| match line.split_once(',') {
        Some((ticks, levels)) if ticks.parse::<f64>().is_ok() => {
            let levels_before = std::mem::replace(&mut before, levels);
            let ticks = time(ticks.parse().unwrap(), levels_before, levels);
            format!("{},{levels}\n", ticks.round())
        }
        _ => format!("{line}\n"),
    });
    fs::write(at.join(to), lines.collect::<String>()).unwrap();
}

#[test]
fn two_recordings_tell_delays_from_widths() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (name, r_min) in [("slow", 300), ("fast", 1200)] {
        let twin = TWIN.replace("= 600", &format!("= {r_min}"));
        let twin = twin.replace("4e-3", "1e-4").replace("6e-3", "2e-4");
        fs::write(at.join("rig.toml"), twin).unwrap();
        done(at, &format!("simulate rig.toml -o {name}.csv"));
        // A falls 420 ticks late: 5 us.
        retimed(
            at,
            &format!("{name}.csv"),
            &format!("{name}-late.csv"),
            |ticks, before, after| {
                let falls = before.starts_with('1') && after.starts_with('0');
                ticks + if falls { 420.0 } else { 0.0 }
            },
        );
    }
    let learn = |suffix: &str| {
        json(&done(
            at,
            &format!(
                "calibrate slow{suffix}.csv fast{suffix}.csv -o t.qct --report t.html --json -"
            ),
        ))
    };
    let plain = learn("");
    assert_eq!(plain["delays"].as_array().unwrap().len(), 0, "{plain}");
    let late = learn("-late");
    let delays = late["delays"].as_array().unwrap();
    assert_eq!(delays.len(), 3, "{late}");
    for (delay, (name, seconds)) in delays.iter().zip([
        ("edge_delay_a", 5e-6),
        ("edge_delay_b", 0.0),
        ("channel_skew", -2.5e-6),
    ]) {
        assert_eq!(delay["name"], name);
        let found = delay["seconds"].as_f64().unwrap();
        assert!((found - seconds).abs() < 1e-7, "{delay}");
    }
    // At 1200 r/min the delay is 630 urad; none of it is taken for a width.
    for (one, other) in [0, 1, 2].map(|n| (&plain["parameters"][n], &late["parameters"][n])) {
        let off = one["rad"].as_f64().unwrap() - other["rad"].as_f64().unwrap();
        assert!(off.abs() < 1e-5, "{one} {other}");
    }
    let page = fs::read_to_string(at.join("t.html")).unwrap();
    assert!(page.contains("Delay of A, fall less rise"));
}

#[test]
fn two_recordings_tell_torque_from_the_disc() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    slow_and_fast(at);
    let found = json(&done(
        at,
        "calibrate slow.csv fast.csv --turns 11 --inertia 1e-4 -o both.qct --csv both.csv --report both.html --json -",
    ));
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert_eq!(found["two_speeds"], true);
    assert_eq!(found["orders_left_alone"].as_array().unwrap().len(), 0);
    assert_eq!(found["turns"]["used"], 22);
    for (recording, (name, r_min)) in found["recordings"]
        .as_array()
        .unwrap()
        .iter()
        .zip([("slow.csv", 300.0), ("fast.csv", 1200.0)])
    {
        assert_eq!(recording["file"], name);
        assert_eq!(recording["turns"]["used"], 11);
        let speed = number(&recording["turns"]["slowest_rev_per_min"]);
        assert!((speed / r_min - 1.0).abs() < 0.01, "{recording}");
        assert_eq!(recording["later_turns"]["worse"], false, "{recording}");
    }
    let ripple = &found["torque_ripple"][0];
    assert_eq!(ripple["order"], 3);
    assert!(
        (number(&ripple["torque_n_m"]) / 5e-3 - 1.0).abs() < 0.02,
        "{ripple}"
    );
    assert!((number(&ripple["acceleration_rad_s2"]) / 50.0 - 1.0).abs() < 0.02);
    // 50 rad/s^2 at three times 5 Hz.
    let angle = 50.0 / (std::f64::consts::TAU * 15.0).powi(2);
    assert!((number(&ripple["angle_rad"]) / angle - 1.0).abs() < 0.02);
    assert!((number(&ripple["speed_share"]) / (3.0 * angle) - 1.0).abs() < 0.02);
    let page = fs::read_to_string(at.join("both.html")).unwrap();
    for part in ["Torque ripple", "slow.csv", "fast.csv", "5.00", "mN m"] {
        assert!(page.contains(part), "{part}");
    }
    // The table is better at either speed, whichever it is checked on.
    for recording in ["slow.csv", "fast.csv"] {
        let check = json(&done(
            at,
            &format!("verify {recording} --table both.qct --json -"),
        ));
        assert_eq!(check["verdict"], "better", "{recording}");
    }
    let text = done(at, "calibrate fast.csv slow.csv -o t.qct");
    let ripple = text
        .lines()
        .find(|line| line.starts_with("Torque ripple, order 3"));
    assert!(
        ripple.is_some_and(|line| line.contains("rad/s²") && line.contains("at 300")),
        "{text}"
    );
}

#[test]
fn one_speed_says_which_orders_it_leaves_and_what_would_decide_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    slow_and_fast(at);
    let text = done(at, "calibrate slow.csv -o t.qct --report t.html");
    for part in [
        "Order 3 left alone",
        "a recording at another speed decides order 3 (quadcal calibrate A.csv B.csv), or --pole-pairs",
        "a recording at a second speed would separate them",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("Torque ripple,"), "{text}");
    let page = fs::read_to_string(at.join("t.html")).unwrap();
    assert!(page.contains("Orders left alone") && page.contains("--pole-pairs"));
    // The order may be the encoder's: what is expected does not count it, and says so wherever it stands.
    let besides = "besides order 3: up to ";
    assert_eq!(text.matches(besides).count(), 2, "{text}");
    assert!(
        page.contains(besides) && page.contains("verdict warn"),
        "{page}"
    );
    let found = json(&done(at, "calibrate slow.csv -o t.qct --json -"));
    assert_eq!(found["expected_error_complete"], false);
    let share = found["left_alone_up_to_rad"].as_f64().unwrap()
        / found["orders_left_alone"][0]["amplitude_rad"]
            .as_f64()
            .unwrap();
    assert!((share - 0.5_f64.sqrt()).abs() < 1e-9, "{share}");
    let both = json(&done(at, "calibrate slow.csv fast.csv -o t.qct --json -"));
    assert_eq!(both["expected_error_complete"], true);
    // A motor of three pole pairs makes torque at order 3 only, one of seven does not.
    let left = |pole_pairs: u32| {
        let found = json(&done(
            at,
            &format!("calibrate slow.csv --pole-pairs {pole_pairs} -o t.qct --json -"),
        ));
        found["orders_left_alone"].clone()
    };
    assert_eq!(left(3)[0]["order"], 3);
    assert_eq!(left(7).as_array().unwrap().len(), 0);
    let text = done(
        at,
        "calibrate slow.csv --hidden-up-to 8 -o t.qct --csv t.csv",
    );
    assert!(text.contains("orders 1 to 8 left alone"), "{text}");
}

#[test]
fn a_turn_with_a_shock_is_thrown_out_and_the_reason_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    slow_and_fast(at);
    // One turn, amid the others, in which the shaft swings by half a degree.
    let turn = 84_000_000.0 * 60.0 / 1200.0;
    retimed(at, "fast.csv", "shock.csv", |ticks, _, _| {
        let inside = (ticks / turn - 10.5).clamp(0.0, 1.0) * std::f64::consts::TAU;
        ticks + turn / 720.0 * (1.0 - inside.cos())
    });
    let text = done(at, "calibrate shock.csv -o t.qct");
    assert!(
        text.contains("that disagree with their neighbours (load step or shock)"),
        "{text}"
    );
}

#[test]
fn a_table_serves_another_recording_of_its_encoder() {
    let folder = workshop();
    let at = folder.path();
    // Same disc at another speed; the disc comes from the seed.
    fs::write(at.join("fast.toml"), TWIN.replace("= 600", "= 900")).unwrap();
    done(at, "simulate fast.toml -o fast.vcd");
    let check = json(&done(at, "verify fast.vcd --table rig.qct --json -"));
    assert_eq!(check["same_recording"], false);
    assert_eq!(check["verdict"], "better");
}

#[test]
fn every_start_without_an_index_finds_the_place_that_the_index_has() {
    let folder = workshop();
    let at = folder.path();
    // Same disc, forward and at another speed; and the recording learned from, on later turns.
    fs::write(at.join("fast.toml"), TWIN.replace("= 600", "= 900")).unwrap();
    done(at, "simulate fast.toml -o fast.csv");
    for (recording, same) in [("fast.csv", false), ("rig.csv", true)] {
        let arguments = format!("locate {recording} --table rig.qct --starts 50 --json -");
        let found = json(&done(at, &arguments));
        assert_eq!(found["same_recording"], same);
        let number = |key: &str| found[key].as_f64().unwrap();
        // The last start or two have too few edges left.
        assert!(number("found") >= 45.0, "{found}");
        // Before its first index a recording can't bear a place out.
        assert!(number("agree_with_index") >= 45.0, "{found}");
        assert_eq!(found["disagree_with_index"], 0);
        assert_eq!(found["refused"], 0);
        assert!(number("error_probability") < 1e-7, "{found}");
        assert!(number("degrees_most") < 150.0, "{found}");
    }
    // A table whose zero is the first edge is of use for other recordings too.
    let free = TWIN.replace("index = true", "index = false");
    fs::write(at.join("free.toml"), free).unwrap();
    done(at, "simulate free.toml -o free.csv");
    done(at, "calibrate free.csv --twin free.toml -o free.qct");
    let text = done(at, "locate fast.csv --table free.qct --starts 20");
    assert!(text.contains("can't be checked"), "{text}");
}

#[test]
fn a_wheel_with_a_gap_is_simulated_calibrated_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("wheel.toml"), done(at, "simulate --example wheel")).unwrap();
    done(at, "simulate wheel.toml -o wheel.csv --turns 30");
    done(
        at,
        "calibrate wheel.csv --twin wheel.toml --turns 15 -o wheel.qct --report w.html",
    );
    let check = json(&done(
        at,
        "verify wheel.csv --table wheel.qct --missing 2 --json -",
    ));
    assert_eq!(check["verdict"], "better", "{check}");
}

#[test]
fn the_demo_writes_its_folder_and_its_files_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = done(at, "demo");
    assert!(text.contains("demo.html"), "{text}");
    let page = fs::read_to_string(at.join("quadcal-demo/demo.html")).unwrap();
    // What it says to try next works, and keeps most turns.
    let next = text
        .lines()
        .filter_map(|line| line.split_once("quadcal calibrate "));
    let next: Vec<&str> = next.map(|(_, arguments)| arguments).collect();
    assert_eq!(next.len(), 1, "{text}");
    let spindle = json(&done(at, &format!("calibrate {} --json -", next[0])));
    let later = &spindle["recordings"][0]["later_turns"];
    let scatter = |key: &str| later[key].as_f64().unwrap();
    assert!(
        scatter("scatter_after") < 0.2 * scatter("scatter_before"),
        "{later}"
    );
    assert!(spindle["turns"]["used"].as_u64() > spindle["turns"]["disagrees"].as_u64());
    assert!(page.contains("137.50") && page.contains("hall-spindle") && !page.contains("NaN"));
    for name in ["paper-rig", "hall-spindle"] {
        let arguments =
            format!("verify quadcal-demo/{name}.csv --table quadcal-demo/{name}.qct --json -");
        let check = json(&done(at, &arguments));
        assert_eq!(check["verdict"], "better", "{name}");
        assert_eq!(check["same_recording"], true, "{name}");
    }
}
