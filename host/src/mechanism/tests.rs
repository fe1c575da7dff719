use super::*;

#[test]
fn ids_are_what_serde_writes_and_each_is_its_own() {
    let mut seen = std::collections::BTreeSet::new();
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
    }
}

#[test]
fn torque_of_an_order_falls_with_the_square_of_the_speed_and_delays_grow_with_it() {
    assert_eq!(Mechanism::TorqueRipple.speed_exponent(), Some(-2));
    assert_eq!(Mechanism::EdgeDelay.speed_exponent(), Some(1));
    assert_eq!(Mechanism::Eccentricity.speed_exponent(), Some(0));
    assert_eq!(Mechanism::Bearing.speed_exponent(), None);
}

#[test]
fn each_says_what_it_keeps_step_with_and_which_recording_decides() {
    for mechanism in Mechanism::ALL {
        let known = mechanism != Mechanism::Unknown;
        assert_eq!(!mechanism.locked_to().is_empty(), known, "{mechanism}");
        assert!(mechanism.separated_by().ends_with('.'));
        assert!(!mechanism.title().ends_with('.'));
    }
}
