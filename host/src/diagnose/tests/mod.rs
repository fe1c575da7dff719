//! Whole diagnoses of simulated recordings, and the parts that they go by held against what they are to be.

mod answers;
mod cells;
mod corners;
mod hall;
mod parts;
mod search;
mod undriven;

use super::bench::Bench;
use super::diagnosis::Answer;
use super::edges::{Edges, Sensor, place};
use super::filter::Noise;
use super::model::Board;
use super::pipeline::diagnose;
use super::record::Record;
use super::rig::Recorded;
use crate::recording::Row;
use crate::sim::Simulation;
use crate::twin::{Encoder, Twin};
use quadcal::edge::Levels;

const PAIR_FAST: &str = include_str!("../../../twins/pair-fast.toml");
const WHEEL: &str = include_str!("../../../twins/wheel-60-2.toml");
const LOAD: &str = include_str!("../../../twins/load-step.toml");

fn twin(text: &str) -> Twin {
    Twin::parse(text, "a.toml").unwrap()
}

fn edges(twin: &Twin) -> Edges {
    let sensor = match &twin.encoder {
        &Encoder::Quadrature { lines, index } => Sensor::Quadrature {
            lines,
            index: index.then_some(Levels(Levels::A)),
        },
        &Encoder::Hall { pole_pairs } => Sensor::Hall { pole_pairs },
        wheel @ Encoder::Wheel { teeth, .. } => Sensor::Wheel {
            present: (0..*teeth).map(|tooth| wheel.is_real(2 * tooth)).collect(),
            both_edges: true,
        },
    };
    let rows: Vec<Row> = Simulation::new(twin)
        .unwrap()
        .map(|event| event.row)
        .collect();
    place(&sensor, twin.timer.clock_hz, &rows).unwrap()
}

/// A recording of one twin beside another.
fn against(real: &str, given: &str) -> Answer {
    let one = Recorded {
        file: "a.csv".to_owned(),
        edges: edges(&twin(real)),
        twin: twin(given),
    };
    diagnose(&mut [one], &mut |_, _| {}).unwrap()
}

/// The recording of a twin beside itself.
fn board(text: &str) -> Board {
    let twin = twin(text);
    board_beside(&twin, &twin)
}

/// The recording of one twin beside another.
fn board_beside(real: &Twin, given: &Twin) -> Board {
    board_of(&edges(real), given)
}

/// Edges beside a twin.
fn board_of(edges: &Edges, given: &Twin) -> Board {
    let record = Record::of(edges, given);
    let errors = crate::sim::true_errors(given).unwrap();
    let noise = Noise {
        torque: 1.0,
        stamp_s: record.tick_s,
        ..Noise::default()
    };
    Board::new(vec![Bench::new(record, given, &errors, &noise)])
}

/// Findings in words.
fn said(answer: &Answer) -> Vec<&str> {
    let findings = answer.diagnosis.findings.iter();
    findings.map(|one| &*one.text).collect()
}
