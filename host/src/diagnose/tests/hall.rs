//! What a diagnosis says of three Hall sensors, whose classes have more numbers than a wave of the disc.

use super::against;
use crate::mechanism::Mechanism;

/// Three Hall sensors at 300 r/min, of a disc that is off as said.
fn hall(pole_pairs: u32, errors: &str) -> String {
    format!(
        "seed = 3\nduration = {{ turns = 150 }}\n[encoder.hall]\npole_pairs = {pole_pairs}\n[errors]\n{errors}\n[shaft]\n\
        inertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\n[drive.constant]\nr_min = 300\n[noise.white]\npsd_n2_m2_s = 1e-13\n\
        [timer]\nclock_hz = 72_000_000\njitter_s = 5e-7\n"
    )
}

#[test]
fn widths_of_hall_sensors_are_no_level_that_swings_as_fast_as_the_shaft_turns() {
    // Such a level makes an edge come at any instant: it took up every error and the noise as well, "over 99.9 %".
    let given = hall(2, "list_rad = [0,0,0,0,0,0,0,0,0,0,0,0]");
    let two = hall(2, "width_b_rad = -1.3537e-3\nwidth_c_rad = 1.1203e-3");
    let five = hall(
        1,
        "width_a_rad = -1.78e-3\nwidth_b_rad = -9.6e-4\nwidth_c_rad = -1.51e-3\nshift_b_rad = -1.82e-3\nshift_c_rad = -1.85e-3",
    );
    let answer = against(&two, &given).diagnosis;
    let [first] = &answer.findings[..] else {
        panic!("{:?}", answer.summary);
    };
    let alike = |one: Mechanism| first.mechanism == one || first.look_alikes.contains(&one);
    assert!(
        alike(Mechanism::WidthError) && alike(Mechanism::EdgeDelay),
        "{:?}",
        answer.summary
    );
    let given = hall(1, "list_rad = [0,0,0,0,0,0]");
    let answer = against(&five, &given).diagnosis;
    let named = answer
        .findings
        .iter()
        .all(|found| found.mechanism != Mechanism::Unknown);
    assert!(named, "{:?}", answer.summary);
    // Stamps are off by 500 ns, at 31.4 rad/s; the torque's noise is on top.
    let after = answer.fit.rms_after_rad.unwrap();
    assert!((15e-6..50e-6).contains(&after), "{after}");
}

#[test]
fn a_wave_that_is_the_same_at_each_pole_pair_is_a_disc_s_where_it_is_fewer_numbers_than_the_sensors_have()
 {
    // It was left to the sensors' own errors, so that a torque was all that could be named: "over 99.9 %".
    let given = hall(2, "list_rad = [0,0,0,0,0,0,0,0,0,0,0,0]");
    let oval = hall(2, "tilt = { amplitude_rad = 1e-3, phase_rad = 0.7 }");
    let answer = against(&oval, &given).diagnosis;
    let [first] = &answer.findings[..] else {
        panic!("{:?}", answer.summary);
    };
    assert_eq!(first.mechanism, Mechanism::DiscTilt, "{:?}", answer.summary);
    assert_eq!(first.look_alikes, [Mechanism::TorqueRipple]);
    let [low, high] = first.parameters["amplitude_rad"].ci95.unwrap();
    assert!(low < 1e-3 && 1e-3 < high, "{low} {high}");
}
