use std::collections::BTreeSet;

use super::*;

#[test]
fn ids_are_what_serde_writes_and_each_is_its_own() {
    let mut seen = BTreeSet::new();
    for mechanism in Mechanism::ALL {
        let written = serde_json::to_string(&mechanism).unwrap();
        assert_eq!(written, format!("\"{}\"", mechanism.id()));
        assert_eq!(
            serde_json::from_str::<Mechanism>(&written).unwrap(),
            mechanism
        );
        assert_eq!(Mechanism::from_id(mechanism.id()), Some(mechanism));
        assert_eq!(mechanism.to_string(), mechanism.id());
        assert!(seen.insert(mechanism.id()));
    }
    assert_eq!(seen.len(), 28);
    assert_eq!(Mechanism::from_id("gremlins"), None);
}

#[test]
fn look_alikes_go_both_ways_and_none_is_alike_to_itself() {
    for one in Mechanism::ALL {
        for other in one.look_alikes() {
            assert_ne!(one, *other);
            assert!(other.look_alikes().contains(&one), "{one} and {other}");
        }
        assert_eq!(one.look_alikes().is_empty(), one == Mechanism::Unknown);
        let card = one.card();
        for other in card.same_mark.iter().chain(card.told_by_rig) {
            assert!(one.look_alikes().contains(other), "{one} and {other}");
        }
        for other in card.same_mark {
            assert!(other.card().same_mark.contains(&one), "{one} and {other}");
        }
    }
}

#[test]
fn torque_of_an_order_falls_with_the_square_of_the_speed_and_delays_grow_with_it() {
    let exponent = |mechanism: Mechanism| mechanism.card().speed_exponent;
    assert_eq!(exponent(Mechanism::TorqueRipple), Some(-2));
    assert_eq!(exponent(Mechanism::EdgeDelay), Some(1));
    assert_eq!(exponent(Mechanism::Eccentricity), Some(0));
    assert_eq!(exponent(Mechanism::Bearing), None);
}

#[test]
fn each_says_what_it_keeps_step_with_and_which_recording_decides() {
    for mechanism in Mechanism::ALL {
        let known = mechanism != Mechanism::Unknown;
        let card = mechanism.card();
        assert_eq!(!card.locked_to.is_empty(), known, "{mechanism}");
        assert!(mechanism.separated_by().ends_with('.'));
        assert!(!mechanism.title().ends_with('.'));
        assert!(card.physics.ends_with('.'), "{mechanism}");
    }
}

#[test]
fn the_documentation_of_each_file_has_the_equation_and_the_source_of_its_card() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/mechanism");
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for mechanism in Mechanism::ALL {
        let text = std::fs::read_to_string(format!("{folder}/{mechanism}.rs")).unwrap();
        let lines = text.lines().filter_map(|line| line.strip_prefix("//!"));
        let doc = plain(&lines.collect::<Vec<_>>().join(" "));
        let card = mechanism.card();
        assert!(doc.starts_with(&format!("`{mechanism}`: ")), "{doc}");
        assert!(
            doc.contains(&plain(card.equation)),
            "{mechanism}: {}",
            card.equation
        );
        let source = format!("Source: {}", plain(card.source));
        assert!(doc.contains(&source), "{mechanism}: {source}");
    }
}

#[test]
fn every_section_is_one_that_a_twin_may_have() {
    let keys: Vec<String> = include_str!("../../twins/keys.txt")
        .lines()
        .filter_map(|line| Some(line.split_whitespace().next()?.replace("[]", "")))
        .collect();
    for mechanism in Mechanism::ALL {
        let twin = mechanism.card().twin;
        let known = mechanism != Mechanism::Unknown;
        let there = |key: &String| key == twin || key.starts_with(&format!("{twin}."));
        assert_eq!(keys.iter().any(there), known, "{mechanism}: {twin}");
    }
}

#[test]
fn ranges_hold_numbers_and_units_are_those_of_the_names() {
    for mechanism in Mechanism::ALL {
        for one in mechanism.card().parameters {
            let middle = 0.5 * (one.from + one.to);
            assert!(one.from < one.to && one.allows(middle), "{one:?}");
            assert!(!one.allows(f64::NAN) && !one.allows(2.0 * one.to));
            let end = match one.unit {
                "1" => "",
                "1/s" => "per_s",
                "N m" => "n_m",
                "N m s" => "n_m_s",
                "N m s^2" => "n_m_s2",
                "N^2 m^2 s" => "n2_m2_s",
                "N m/rad" => "n_m_rad",
                "rad/s" => "rad_s",
                "Hz" => "hz",
                unit => unit,
            };
            assert!(one.name.ends_with(end), "{one:?}");
        }
    }
}
