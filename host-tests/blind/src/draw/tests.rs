use std::collections::HashMap;

use super::{CATALOGUE, Family, Kind, again, case, plan};
use crate::rig::{Profile, Told};
use crate::write;

#[test]
fn a_trial_has_its_shares_in_an_order_that_says_nothing() {
    let drawn = plan(400, 1, None);
    let mut counts = HashMap::new();
    for (kind, number) in &drawn {
        let (count, most) = counts.entry(*kind).or_insert((0, 0));
        *count += 1;
        *most = number.max(most).to_owned();
    }
    for (kind, share) in Kind::SHARES {
        let expected = 4 * share as usize;
        assert_eq!(counts[&kind], (expected, expected - 1), "{kind:?}");
    }
    let ordered = drawn.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    assert!(ordered.count() < 160);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_the_open_files_hold_no_effect() {
    let kinds = Kind::SHARES.iter().map(|(kind, _)| *kind);
    for (place, kind) in kinds.enumerate() {
        let (one, two) = (case(5, place, kind, place), case(5, place, kind, place));
        assert_eq!(one.truth, two.truth);
        for ((rig, rows), (_, again)) in one.runs.iter().zip(&two.runs) {
            assert_eq!(rows, again);
            let twin = write::twin(rig);
            let open = twin.clone() + &write::recording(rig, &rows[..10.min(rows.len())]);
            for word in CATALOGUE.into_iter().chain(["seed", kind.name()]) {
                let known = (word, twin.contains("[drive.speed_loop]"));
                assert!(
                    !open.contains(word) || known == ("loop", true),
                    "{word}: {open}"
                );
            }
        }
    }
}

#[test]
fn a_case_recorded_again_has_the_same_truth_and_other_noise() {
    let (first, other) = (
        case(5, 3, Kind::One, 3),
        again(5, 3, None, (Kind::One, 3), 2),
    );
    assert_eq!(first.truth, other.truth);
    assert_eq!(write::twin(&first.runs[0].0), write::twin(&other.runs[0].0));
    assert_ne!(first.runs[0].1, other.runs[0].1);
    let once_more = again(5, 3, None, (Kind::One, 3), 2);
    assert_eq!(other.runs[0].1, once_more.runs[0].1);
}

#[test]
fn sizes_are_the_multiples_that_were_asked_for() {
    for number in [0, 5, 10, 17] {
        let drawn = case(8, number, Kind::One, number);
        let found = &drawn.truth["mechanisms"][0];
        assert_eq!(found["id"], CATALOGUE[number]);
        let times = found["times_ideal"].as_f64().unwrap();
        assert!([3.0, 5.0, 10.0, 30.0].contains(&times), "{times}");
        let power = if found["id"] == "timestamp_jitter" {
            2
        } else {
            1
        };
        let distance = found["d_prime"].as_f64().unwrap() / times.powi(power);
        assert!((3.5..7.0).contains(&distance), "{distance}");
    }
}

#[test]
fn a_play_is_as_large_as_its_own_recording_asks_for() {
    // Both kinds that have one.
    for (kind, number) in [(Kind::One, 22), (Kind::LookAlike, 8), (Kind::LookAlike, 9)] {
        for seed in 0..2 {
            let drawn = case(seed, number, kind, number);
            let found = &drawn.truth["mechanisms"][0];
            let value = |name: &str| found[name].as_f64().unwrap();
            assert!(["hysteresis", "backlash"].contains(&found["id"].as_str().unwrap()));
            let (times, distance) = (value("times_ideal"), value("d_prime"));
            assert!((distance / (5.0 * times) - 1.0).abs() < 1e-9, "{distance}");
            let near = |asked: f64| (0.8..=1.25).contains(&(times / asked));
            assert!([3.0, 5.0, 10.0, 30.0].into_iter().any(near), "{times}");
            let parameters = found["parameters"].as_object().unwrap();
            let size = parameters.values().next().unwrap().as_f64().unwrap();
            let step = drawn.runs[0].0.encoder.step_rad();
            assert!((size / (times * value("ideal_size")) - 1.0).abs() < 1e-9);
            assert!(size < 3.0 * step, "{size} {step}");
        }
    }
}

fn of_family(family: Family, place: usize) -> super::Case {
    let plan = family.plan(12, 5);
    again(5, place, Some(family), plan[place], 0)
}

#[test]
fn a_thin_twin_holds_sensor_timer_and_inertia_alone() {
    for place in 0..4 {
        let case = of_family(Family::Thin, place);
        assert!(case.truth["mechanisms"].as_array().unwrap().is_empty());
        assert_eq!(case.truth["family"], "thin");
        let twin = write::twin(&case.runs[0].0);
        let sections: Vec<&str> = twin.lines().filter(|line| line.starts_with('[')).collect();
        assert!(sections[0].starts_with("[encoder."), "{twin}");
        assert_eq!(sections[1..], ["[shaft]", "[timer]"], "{twin}");
        let keys = twin.lines().filter(|line| line.contains("n_m")).count();
        assert_eq!(keys, 0, "{twin}");
    }
}

#[test]
fn a_free_drive_dwells_and_reverses_and_the_twin_says_nothing_of_it() {
    let mut with_effect = 0;
    for place in 0..6 {
        let case = of_family(Family::FreeDrive, place);
        let rig = &case.runs[0].0;
        let Profile::Free(pieces) = rig.profile else {
            panic!("{:?}", rig.profile);
        };
        assert!(pieces.reverses());
        let still = (0..1000).map(|at| f64::from(at) * pieces.end_s() / 1000.0);
        assert!(still.map(|t| pieces.at(t, t)).any(|now| now == (0.0, 0.0)));
        assert!(!write::twin(rig).contains("drive") && rig.told == Told::NoDrive);
        with_effect += case.truth["mechanisms"].as_array().unwrap().len();
    }
    assert!((1..6).contains(&with_effect), "{with_effect}");
}

#[test]
fn an_effect_in_no_catalogue_says_its_site_and_carrier() {
    let case = of_family(Family::CatalogueFree, 0);
    let effect = &case.truth["mechanisms"][0];
    assert_eq!(effect["id"], "unknown");
    assert!(effect["site"].is_string() && effect["carrier"].is_string());
    assert_eq!(case.truth["verdict"], "unknown");
}
