use super::*;

fn changed(from: &str, to: &str) -> (String, usize) {
    let text = paper_text();
    let at = text
        .find(from)
        .unwrap_or_else(|| panic!("{from} in\n{text}"));
    (text.replacen(from, to, 1), text[..at].lines().count() + 1)
}

#[test]
fn a_whole_number_may_be_written_as_a_float() {
    let read = |from, to| Twin::parse(&changed(from, to).0, "rig.toml").unwrap();
    assert_eq!(
        read("clock_hz = 84000000", "clock_hz = 16e6")
            .timer
            .clock_hz,
        16_000_000
    );
    assert_eq!(
        read("clock_hz = 84000000", "clock_hz = 1E12")
            .timer
            .clock_hz,
        1_000_000_000_000
    );
    assert_eq!(read("bits = 64", "bits = 16.0").timer.bits, 16);
    let lines = read("lines = 2500", "lines = 1e3").encoder.grid_edges();
    assert_eq!(lines, 4000);
    let (text, _) = changed("[errors]", "[errors]\nseed = 7e0");
    let more = "[faults]\nlost_edges = [1, 2e3]\n[[index_slip]]\nat_s = 1\nedges = -3.0\n";
    let twin = Twin::parse(&(text + more), "rig.toml").unwrap();
    assert_eq!(twin.errors.seed, Some(7));
    assert_eq!(twin.faults.lost_edges, [1, 2000]);
    assert_eq!(twin.index_slip[0].edges, -3);
}

#[test]
fn a_float_that_is_not_whole_or_too_large_is_refused_with_its_place() {
    for (from, to, key) in [
        ("clock_hz = 84000000", "clock_hz = 16.5", "timer.clock_hz"),
        ("clock_hz = 84000000", "clock_hz = nan", "timer.clock_hz"),
        ("clock_hz = 84000000", "clock_hz = inf", "timer.clock_hz"),
        ("clock_hz = 84000000", "clock_hz = 1e19", "timer.clock_hz"),
        ("clock_hz = 84000000", "clock_hz = -1.0", "timer.clock_hz"),
        ("lines = 2500", "lines = 5e9", "encoder.quadrature.lines"),
        ("lines = 2500", "lines = -25", "encoder.quadrature.lines"),
    ] {
        let (text, line) = changed(from, to);
        match Twin::parse(&text, "rig.toml") {
            Err(TwinError::Syntax {
                place,
                key: found,
                message,
            }) => {
                let found = (found.as_str(), place.position.map(|p| p.0));
                assert_eq!(found, (key, Some(line)), "{to}");
                assert!(
                    message.contains("expected a whole number from 0 to "),
                    "{message}"
                );
            }
            other => panic!("{to}: {other:?}"),
        }
    }
    // In range of the type and out of the key's own.
    let (text, line) = changed("clock_hz = 84000000", "clock_hz = 2e12");
    let bad = bad_value(&text);
    assert_eq!(
        (bad.key.as_str(), bad.place.position),
        ("timer.clock_hz", Some((line, 12)))
    );
}
