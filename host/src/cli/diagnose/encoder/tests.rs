use super::*;
use crate::sim::Simulation;
use crate::twin::Twin;

/// A survey of a twin's recording, as `change` leaves its header.
fn survey(twin: &str, change: impl Fn(&mut Header)) -> Survey {
    let twin = Twin::parse(twin, "twin.toml").unwrap();
    let simulation = Simulation::new(&twin).unwrap();
    let mut header = simulation.header();
    change(&mut header);
    Survey::of(header, simulation.map(|event| Ok(event.row))).unwrap()
}

const QUADRATURE: &str = include_str!("../../../../twins/pair-fast.toml");
const HALL: &str = include_str!("../../../../twins/hall.toml");

fn quadrature(lines: u32, index: bool) -> Encoder {
    Encoder::Quadrature { lines, index }
}

fn silent(header: &mut Header) {
    header.notes.clear();
}

#[test]
fn the_twin_decides_whether_the_index_counts() {
    let survey = survey(QUADRATURE, silent);
    let lines = survey.lines().unwrap();
    for (declared, index) in [(true, Some(survey.index_state())), (false, None)] {
        let found = sensor(&quadrature(lines, declared), &survey).unwrap();
        assert_eq!(found, Sensor::Quadrature { lines, index });
    }
    assert_eq!(
        sensor(&quadrature(lines + 1, true), &survey),
        Err(OtherEncoder::Lines {
            declared: lines + 1,
            shown: lines,
            name: "lines",
            shown_by: "the recording's edges between two index pulses make",
        })
    );
}

#[test]
fn a_recording_with_less_than_the_twin_declares_is_refused() {
    let mut survey = survey(HALL, silent);
    let hall = Encoder::Hall { pole_pairs: 2 };
    assert_eq!(sensor(&hall, &survey), Ok(Sensor::Hall { pole_pairs: 2 }));
    survey.header.channels = Channels::Quadrature { index: false };
    assert!(matches!(
        sensor(&hall, &survey),
        Err(OtherEncoder::Kind { .. })
    ));
    assert_eq!(
        sensor(&quadrature(3, true), &survey),
        Err(OtherEncoder::NoIndexChannel)
    );
    survey.header.channels = Channels::Quadrature { index: true };
    assert_eq!(
        sensor(&quadrature(3, true), &survey),
        Err(OtherEncoder::NoIndexPulse)
    );
}

#[test]
fn one_pulse_a_tooth_is_enough_for_a_wheel() {
    let mut survey = survey(HALL, silent);
    survey.header.channels = Channels::Pulses;
    let wheel = Encoder::Wheel {
        teeth: 4,
        missing: 1,
        gaps: Vec::new(),
    };
    let pulses = Sensor::Wheel {
        present: vec![true, true, true, false],
        both_edges: false,
    };
    assert_eq!(sensor(&wheel, &survey), Ok(pulses));
}

#[test]
fn a_header_contradicts_and_so_does_a_strong_pattern_without_one() {
    let with_notes = survey(HALL, |_| ());
    let other = Encoder::Hall { pole_pairs: 3 };
    let lines = |survey: &Survey| match sensor(&other, survey) {
        Err(OtherEncoder::Lines {
            shown, shown_by, ..
        }) => Some((shown, shown_by)),
        _ => None,
    };
    let said = (2, "the recording's header says");
    assert_eq!(lines(&with_notes), Some(said));
    // Steps of the clock hide the pattern.
    assert_eq!(lines(&survey(HALL, silent)), None);
    let clean = HALL
        .replace("rms_fraction = 0.005", "rms_fraction = 0.0001")
        .replace("30_000", "30_000_000");
    let shown = (2, "the recording's intervals repeat after");
    assert_eq!(lines(&survey(&clean, silent)), Some(shown));
}
