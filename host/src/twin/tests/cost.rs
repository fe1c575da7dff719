use std::time::Instant;

use super::*;
use crate::sim::Simulation;

#[test]
fn steps_of_noise_far_below_an_edge_are_refused_by_their_key() {
    let wander = |keys: &str| {
        format!(
            "{}[noise.speed_wander]\nrms_fraction = 0.01\n{keys}\n",
            paper_text()
        )
    };
    let white = |keys: &str| {
        format!(
            "{}[noise.white]\npsd_n2_m2_s = 1e-12\n{keys}\n",
            paper_text()
        )
    };
    let far = |keys: &str| {
        format!(
            "{}[torsional_resonance]\ninertia_share = 0.5\nload_psd_n2_m2_s = 1e-12\n{keys}\n",
            paper_text()
        )
    };
    for (text, key) in [
        (
            wander("correlation_rad = 1e-300"),
            "noise.speed_wander.correlation_rad",
        ),
        (
            wander("correlation_rad = 1e-6"),
            "noise.speed_wander.correlation_rad",
        ),
        (
            wander("hold_s = 1e-9\ncorrelation_rad = 1"),
            "noise.speed_wander.hold_s",
        ),
        (white("hold_s = 1e-9"), "noise.white.hold_s"),
        (
            far("f_hz = 5\nload_hold_s = 1e-9"),
            "torsional_resonance.load_hold_s",
        ),
        (far("f_hz = 1e6"), "torsional_resonance.f_hz"),
    ] {
        let bad = bad_value(&text);
        assert_eq!(bad.key, key);
        let name = key.rsplit('.').next().unwrap();
        let line = text
            .lines()
            .position(|line| line.starts_with(name) && line.contains("e"))
            .unwrap();
        let line = match name {
            "f_hz" => text.lines().position(|line| line == "f_hz = 1e6").unwrap(),
            _ => line,
        };
        assert_eq!(bad.place.position.map(|p| p.0), Some(line + 1), "{key}");
        assert!(
            bad.allowed.contains("in all") && !bad.to_string().contains('\n'),
            "{bad}"
        );
    }
    // Noise as fine as it helps, and a slow rig for long.
    Twin::parse(&white("hold_s = 1e-5"), "rig.toml").unwrap();
    Twin::parse(&wander("correlation_rad = 1e-3"), "rig.toml").unwrap();
}

#[test]
fn lists_too_long_to_simulate_are_refused_by_their_name() {
    for (key, most) in [("ripple", 250), ("torque_tone", 250), ("load_step", 5000)] {
        let entry = match key {
            "ripple" => "order = 3\ntorque_n_m = 1e-6",
            "torque_tone" => "f_hz = 3\ntorque_n_m = 1e-6",
            _ => "from_s = 1\ntorque_n_m = 1e-6",
        };
        let list = |entries: usize| {
            let mut twin = Twin::paper();
            twin.ripple.clear();
            let more = format!("[[{key}]]\n{entry}\n").repeat(entries);
            twin.to_toml().unwrap() + &more
        };
        Twin::parse(&list(most), "rig.toml").unwrap();
        let bad = bad_value(&list(most + 1));
        assert_eq!(
            (bad.key.as_str(), bad.value),
            (key, format!("{} entries", most + 1))
        );
        assert!(bad.place.position.is_some_and(|p| p.0 > 1));
    }
}

#[test]
fn delays_that_keep_a_hundred_thousand_edges_waiting_are_refused() {
    let mut twin = Twin::paper();
    twin.channel_skew = Some(ChannelSkew {
        b_s: 1.0,
        ..ChannelSkew::default()
    });
    twin.check().unwrap();
    twin.drive = Drive::Constant { r_min: 1000.0 };
    match twin.check() {
        Err(TwinError::Value(bad)) => assert_eq!(bad.key, "channel_skew.b_s"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn files_without_an_end_are_refused_unread() {
    let begun = Instant::now();
    for path in ["/dev/zero", "/dev/stdin", "/"] {
        let mut twin = Twin::paper();
        twin.errors = Errors {
            csv: Some(path.into()),
            ..Errors::default()
        };
        let shown = Simulation::new(&twin).unwrap_err().to_string();
        assert!(shown.starts_with(path) && !shown.contains('\n'), "{shown}");
        let text = format!(
            "duration.turns = 1\n[encoder.hall]\npole_pairs = 2\n[timer]\nclock_hz = 1e6\n[drive.profile]\ncsv = \"{path}\"\n"
        );
        let shown = Twin::parse(&text, "rig.toml").unwrap_err().to_string();
        assert!(shown.starts_with(path) && !shown.contains('\n'), "{shown}");
    }
    assert!(matches!(
        Twin::load(Path::new("/dev/zero")),
        Err(TwinError::TooLarge { .. })
    ));
    assert!(begun.elapsed().as_secs() < 5);
}
