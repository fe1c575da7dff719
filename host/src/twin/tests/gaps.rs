use super::*;

fn wheel(keys: &str) -> String {
    format!(
        "duration.turns = 3\n[encoder.wheel]\n{keys}\n[drive.constant]\nr_min = 60\n[timer]\nclock_hz = 1e6\n"
    )
}

fn encoder(keys: &str) -> Encoder {
    Twin::parse(&wheel(keys), "w.toml").unwrap().encoder
}

#[test]
fn edges_of_missing_teeth_are_not_real() {
    let two = encoder("teeth = 36\ngaps = [{ at = 12, missing = 2 }, { at = 20, missing = 1 }]");
    let gone: Vec<u32> = (0..two.grid_edges()).filter(|k| !two.is_real(*k)).collect();
    assert_eq!(gone, [24, 25, 26, 27, 40, 41]);
    assert_eq!((two.grid_edges(), two.real_edges()), (72, 66));
    assert_eq!(two.missing_at_end(), None);
    let short = encoder("teeth = 60\nmissing = 2");
    let same = encoder("teeth = 60\ngaps = [{ at = 58, missing = 2 }]");
    for k in 0..120 {
        assert_eq!(short.is_real(k), same.is_real(k), "{k}");
    }
    assert_eq!(
        (short.missing_at_end(), same.missing_at_end()),
        (Some(2), Some(2))
    );
}

#[test]
fn a_gap_that_goes_on_at_the_turn_s_start_is_one_way_to_the_next_tooth() {
    let round = encoder("teeth = 8\ngaps = [{ at = 7, missing = 1 }, { at = 0, missing = 2 }]");
    assert_eq!(
        round.edges_to_real(14, quadcal::edge::Direction::Forward),
        6
    );
    assert_eq!(round.edges_to_real(3, quadcal::edge::Direction::Reverse), 6);
    assert_eq!(round.edges_to_real(5, quadcal::edge::Direction::Reverse), 0);
}

#[test]
fn gaps_that_can_not_be_are_refused_with_their_place() {
    for (keys, key) in [
        (
            "teeth = 36\ngaps = [{ at = 36, missing = 1 }]",
            "encoder.wheel.gaps[0].at",
        ),
        (
            "teeth = 36\ngaps = [{ at = 35, missing = 2 }]",
            "encoder.wheel.gaps[0].missing",
        ),
        (
            "teeth = 36\ngaps = [{ at = 3, missing = 0 }]",
            "encoder.wheel.gaps[0].missing",
        ),
        (
            "teeth = 36\ngaps = [{ at = 3, missing = 2 }, { at = 4, missing = 1 }]",
            "encoder.wheel.gaps[1]",
        ),
        (
            "teeth = 4\ngaps = [{ at = 0, missing = 2 }, { at = 2, missing = 2 }]",
            "encoder.wheel.gaps",
        ),
        (
            "teeth = 36\nmissing = 1\ngaps = [{ at = 3, missing = 2 }]",
            "encoder.wheel.gaps",
        ),
    ] {
        let bad = bad_value(&wheel(keys));
        assert_eq!(bad.key, key, "{keys}");
        let line = wheel(keys)
            .lines()
            .position(|l| l.starts_with("gaps"))
            .unwrap()
            + 1;
        assert_eq!(bad.place.position.map(|p| p.0), Some(line), "{keys}");
    }
}

#[test]
fn a_table_is_refused_a_wheel_with_several_gaps_in_one_line() {
    let text = wheel("teeth = 36\ngaps = [{ at = 12, missing = 2 }, { at = 20, missing = 1 }]");
    let twin = Twin::parse(&text, "w.toml").unwrap();
    let shown = twin.missing_teeth().unwrap_err().to_string();
    assert!(
        shown.starts_with("w.toml: encoder.wheel.gaps: ") && !shown.contains('\n'),
        "{shown}"
    );
    assert_eq!(
        Twin::parse(&twin.to_toml().unwrap(), "w.toml").unwrap(),
        twin
    );
}
