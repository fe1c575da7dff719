//! The facts of every recording.

use crate::diagnose::diagnosis::RecordingFacts;
use crate::report::{Body, Cell};
use crate::reports::words::speed_range;

/// What was read.
pub(in crate::reports) fn table(body: &mut Body, recordings: &[RecordingFacts]) {
    let rows = recordings.iter().map(|facts| {
        vec![
            facts.file.as_str().into(),
            facts.twin.as_str().into(),
            #[allow(clippy::cast_precision_loss)]
            Cell::fixed(facts.edges as f64, 0),
            Cell::fixed(facts.turns, 1),
            Cell::si(facts.seconds, "s"),
            speed(facts.speed_r_min).into(),
            facts
                .stamp_rms_s
                .map_or_else(|| "".into(), |stamp| Cell::si(stamp, "s")),
            origin(facts).into(),
            #[allow(clippy::cast_precision_loss)]
            Cell::fixed(facts.disturbed_s.len() as f64, 0),
        ]
    });
    body.table(
        "Recordings",
        &[
            "Recording",
            "Twin",
            "Edges",
            "Turns",
            "Length",
            "Speed",
            "Time stamps, RMS error",
            "Angles from",
            "Disturbances of the count",
        ],
        rows.collect(),
    );
}

/// Where angles count from.
pub(in crate::reports) fn origin(facts: &RecordingFacts) -> String {
    match facts.start_rad {
        _ if facts.anchored => "the disc's index".to_owned(),
        Some(start) => format!("the start at {:.1} degrees", start.to_degrees()),
        None => "the first edge".to_owned(),
    }
}

/// The speeds of a recording.
pub fn speed([least, greatest]: [f64; 2]) -> String {
    let text = speed_range([least, greatest]);
    text.replace('\u{a0}', " ")
}
