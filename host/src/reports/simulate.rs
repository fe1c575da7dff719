//! The report of a simulation: what the twin is and what came out. The truth is shown, as it is the simulator's to tell.

use crate::findings::{order_amplitudes, rms};
use crate::report::plot::{Axis, Series, Spectrum, Xy};
use crate::report::{Colour, Footer, Level, Report, Tile};

use super::figures;

/// What a simulation gave.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Rows written.
    pub rows: u64,
    /// Edges among them.
    pub edges: u64,
    /// Length, s.
    pub seconds: f64,
    /// Turns travelled.
    pub turns: f64,
    /// True errors of the encoder, rad.
    pub true_errors_rad: Vec<f64>,
    /// Time and true speed over the run, s and r/min, a few hundred points.
    pub speed: Vec<(f64, f64)>,
}

/// The page of a simulation of `twin` into the recording `output`.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn report(twin: &str, output: &str, outcome: &Outcome, footer: Footer) -> Report {
    let mut report = Report::new("Simulated recording", format!("{output} from {twin}"));
    let errors = &outcome.true_errors_rad;
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    let centred: Vec<f64> = errors.iter().map(|e| e - mean).collect();
    report.verdict(
        Level::Good,
        format!("{:.1} turns were simulated.", outcome.turns),
        vec![
            Tile::si("Encoder error", rms(&centred), "rad", "RMS, true"),
            Tile::new("Edges", outcome.edges.to_string(), "", "on the recording"),
            Tile::si("Length", outcome.seconds, "s", ""),
            Tile::new("Turns", format!("{:.1}", outcome.turns), "", ""),
        ],
    );
    report.section(
        "The encoder's true error",
        &["What a calibration has to find. It stands here and in the file of --truth, never in the recording."],
    );
    let angle = figures::degrees(errors.len());
    let series = if errors.len() < 64 {
        Series::points("true error", &angle, &centred)
    } else {
        Series::line("true error", &angle, &centred)
    };
    report.figure(
        Xy::new(Axis::turn(), Axis::new("Angle error", "rad"))
            .series(series.colour(Colour::BEFORE)),
        "True error of every edge, its mean taken out.",
    );
    let amplitudes = order_amplitudes(&centred);
    let orders: Vec<f64> = (1..=amplitudes.len()).map(|order| order as f64).collect();
    if amplitudes.iter().any(|&a| a > 0.0) {
        report.figure(
            Spectrum::new("rad").stems("true error", &orders, &amplitudes, Colour::BEFORE),
            "Its order spectrum: cycles a turn and their size in angle.",
        );
    }
    report.section("The shaft's true speed", &[]);
    let (time, speed): (Vec<f64>, Vec<f64>) = outcome.speed.iter().copied().unzip();
    report.figure(
        Xy::new(Axis::new("Time", "s"), Axis::new("Angular speed", "r/min"))
            .series(Series::line("true speed", &time, &speed).colour(Colour::AFTER)),
        "Speed between edges picked over the whole run.",
    );
    report.footer(footer);
    report
}
