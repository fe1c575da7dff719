//! The residual of every recording along time and its spectrum, and the facts.

use crate::diagnose::diagnosis::{Diagnosis, RecordingFacts};
use crate::diagnose::shown::RecordingPlot;
use crate::report::plot::{Axis, Spectrum, Xy};
use crate::report::{Body, Cell, Colour};
use crate::reports::words::speed_range;

use super::curves::{columns, series};
use super::words;

/// Figures of each recording.
pub(super) fn sections(body: &mut Body, diagnosis: &Diagnosis, plots: &[RecordingPlot]) {
    let several = diagnosis.recordings.len() > 1;
    for (facts, plot) in diagnosis.recordings.iter().zip(plots) {
        let title = if several {
            format!("What is left of {}", facts.file)
        } else {
            "What is left".to_owned()
        };
        body.section(title, &[words::what_is_left(&diagnosis.fit)]);
        // Noise that was found leaves the residual as it is.
        let found = words::mended(diagnosis) && plot.after != plot.before;
        residual(body, diagnosis, plot, found);
        spectrum(body, diagnosis, plot, found);
    }
}

fn residual(body: &mut Body, diagnosis: &Diagnosis, plot: &RecordingPlot, found: bool) {
    if plot.before.is_empty() {
        return;
    }
    let scale = [1.0, 1e-6];
    // Of turns that is much smaller than the residual of the tiles, and should not have its name.
    let (name, caption) = match words::by_slips(&diagnosis.fit) {
        true => ("Residual", "Residual along the recording."),
        false => (
            "Edges off their expected place",
            "The same along the recording, each point the mean of the edges around it.",
        ),
    };
    let mut drawn = Xy::new(Axis::new("Time", "s"), Axis::new(name, "rad"))
        .series(series("twin as given", &plot.before, scale).colour(Colour::BEFORE));
    if found {
        let after = series("with the findings", &plot.after, scale);
        drawn = drawn.series(after.colour(Colour::AFTER));
    }
    body.figure(drawn, caption);
}

fn spectrum(body: &mut Body, diagnosis: &Diagnosis, plot: &RecordingPlot, found: bool) {
    if plot.spectrum_before.is_empty() {
        return;
    }
    let [x, before] = columns(&plot.spectrum_before, [1.0; 2]);
    let mut drawn = Spectrum::new("")
        .label("Power, 1 is the mean of noise")
        .stems("twin as given", &x, &before, Colour::BEFORE);
    if found {
        let [x, after] = columns(&plot.spectrum_after, [1.0; 2]);
        drawn = drawn.stems("with the findings", &x, &after, Colour::AFTER);
    }
    drawn = drawn.floor(
        "noise alone comes this far once in 20 recordings",
        &[1.0],
        &[plot.threshold],
    );
    for finding in &diagnosis.findings {
        for order in finding.place.orders.iter().take(1) {
            drawn = drawn.name(*order, finding.mechanism.id());
        }
    }
    body.figure(
        drawn,
        "Its spectrum. What stands above the dashed line is seldom noise.",
    );
}

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
