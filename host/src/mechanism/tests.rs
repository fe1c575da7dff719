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
        for other in &one.card().look_alikes {
            assert_ne!(one, *other);
            assert!(other.card().look_alikes.contains(&one), "{one} and {other}");
        }
        assert_eq!(one.card().look_alikes.is_empty(), one == Mechanism::Unknown);
        let card = one.card();
        for other in card.same_mark.iter().chain(&card.told_by_rig) {
            assert!(one.card().look_alikes.contains(other), "{one} and {other}");
        }
        for other in &card.same_mark {
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
        assert!(card.separated_by.ends_with('.'));
        assert!(!mechanism.title().ends_with('.'));
        assert!(card.physics.ends_with('.'), "{mechanism}");
    }
}

#[test]
fn the_catalogue_has_a_card_for_each_and_nothing_else() {
    let cards = card::read(card::TEXT).unwrap();
    assert!(cards.into_keys().eq(Mechanism::ALL));
    for (right, wrong) in [
        ("[unknown]", "[gremlins]"),
        ("separated_by", "seperated_by"),
        ("range = \"torque\"", "range = \"torqe\""),
        ("unit = \"rad\"", "units = \"rad\""),
    ] {
        assert!(card::read(&card::TEXT.replace(right, wrong)).is_err());
    }
}

#[test]
fn every_section_is_one_that_a_twin_may_have() {
    let keys: Vec<String> = crate::twin::KEYS
        .lines()
        .filter_map(|line| Some(line.split_whitespace().next()?.replace("[]", "")))
        .collect();
    for mechanism in Mechanism::ALL {
        let twin = &mechanism.card().twin;
        let known = mechanism != Mechanism::Unknown;
        let there = |key: &String| key == twin || key.starts_with(&format!("{twin}."));
        assert_eq!(keys.iter().any(there), known, "{mechanism}: {twin}");
    }
}

#[test]
fn ranges_hold_numbers_and_units_are_those_of_the_names() {
    for mechanism in Mechanism::ALL {
        for one in &mechanism.card().parameters {
            let [from, to] = one.range;
            assert!(from < to && one.allows(0.5 * (from + to)), "{one:?}");
            assert!(!one.allows(f64::NAN) && !one.allows(2.0 * to));
            let end = match one.unit.as_str() {
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
