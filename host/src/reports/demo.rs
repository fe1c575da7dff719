//! The report of the demonstration.

use crate::demo::{RIG_TURNS, Rig, Run, TABLE_1};
use crate::findings::Parameter;
use crate::report::plot::{Axis, Series, Xy};
use crate::report::{Body, Cell, Colour, Footer, Level, Report, Tile, si};

use super::{figures, words};

/// The page of the demonstration.
#[must_use]
pub fn report(rig: &Rig, spindle: &Run, footer: Footer) -> Report {
    let mut report = Report::new(
        "quadcal demonstration",
        "the paper's rig, simulated, and a recording of a real spindle motor",
    );
    let gain = words::reduction_percent(rig.before_rad, rig.after_rad);
    let scatter = &spindle.check.scatter;
    report.verdict(
        if gain >= 90.0 { Level::Good } else { Level::Warn },
        format!(
            "The simulated encoder's angle error is down by {gain:.1} %, the real spindle's speed scatters by {:.1} % less.",
            words::reduction_percent(scatter.before, scatter.after)
        ),
        vec![
            Tile::si("Simulated: before", rig.before_rad, "rad", "RMS error against the truth"),
            Tile::si("Simulated: after", rig.after_rad, "rad", format!("learned from {RIG_TURNS} turns")),
            Tile::new("Real: before", percent(scatter.before), "%", "scatter of the speed from edge to edge"),
            Tile::new("Real: after", percent(scatter.after), "%", "second half, learned from the first"),
        ],
    );
    let body = report.body();
    simulated(body, rig);
    real(body, spindle);
    let mut details = Body::new();
    figures::turn_table(&mut details, &rig.run.calibration);
    figures::class_table(&mut details, &rig.run.findings);
    details.figure(
        figures::weights(&rig.run.findings),
        "Simulated rig: how far each order is believed: 1 is taken as measured, 0 is left alone.",
    );
    report.details("Details of the simulated rig", details);
    let mut details = Body::new();
    figures::turn_table(&mut details, &spindle.calibration);
    figures::class_table(&mut details, &spindle.findings);
    report.details("Details of the spindle", details);
    report.footer(footer);
    report
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

fn simulated(body: &mut Body, rig: &Rig) {
    let run = &rig.run;
    let text = format!(
        "2500 lines at 15 r/min with the paper's errors, torque ripple at orders 5, 10 and 15, and a speed that wanders by 0.1 %. The \
         table was learned from {RIG_TURNS} turns of edge times alone. Only this report knows the truth, and compares."
    );
    body.section("The paper's rig, simulated", &[&text]);
    table_1(body, rig);
    let (angle, mean) = (
        figures::degrees(rig.truth_rad.len()),
        rig.truth_rad.iter().sum::<f64>() / rig.truth_rad.len() as f64,
    );
    let before: Vec<f64> = rig.truth_rad.iter().map(|e| e - mean).collect();
    let after: Vec<f64> = before
        .iter()
        .zip(&run.findings.error_rad)
        .map(|(e, c)| e - c)
        .collect();
    body.figure(
        Xy::new(Axis::turn(), Axis::new("Angle error", "rad"))
            .series(Series::line("before", &angle, &before).colour(Colour::BEFORE))
            .series(Series::line("after", &angle, &after).colour(Colour::AFTER)),
        format!(
            "True angle error of every edge: {} RMS before, {} after. The calibration itself expected {}.",
            si(rig.before_rad, "rad"),
            si(rig.after_rad, "rad"),
            si(run.findings.after_rad, "rad")
        ),
    );
    body.figure(
        figures::speed(&run.check.profile),
        "Speed at every edge of one turn that was not learned from. What is left after correction is the motion: torque ripple and wander.",
    );
    body.figure(
        figures::spectrum(&run.findings, run.calibration.plan.lines, "width, quadrature"),
        "Order spectrum of the table. Orders that repeat every turn like torque ripple are left alone, as one speed can't tell ripple from \
         the disc's own error.",
    );
}

fn table_1(body: &mut Body, rig: &Rig) {
    let rows = TABLE_1
        .iter()
        .zip(&rig.run.findings.parameters)
        .zip(&rig.true_parameters_rad)
        .map(|((&(name, paper_true, paper), ours), &truth)| {
            let off = |found: f64, truth: f64| Cell::fixed(100.0 * (found / truth - 1.0), 2);
            vec![
                name.into(),
                micro(paper_true),
                micro(paper),
                off(paper, paper_true),
                micro(truth),
                micro_with_error(ours),
                off(ours.rad, truth),
            ]
        });
    body.table(
        "Table 1 of the paper beside ours, µrad, found ± standard error. Our disc's true values include the chance means of its line \
         errors: eps has zero mean in every class, so they belong to xi and p",
        &[
            "Parameter",
            "Paper: true",
            "found",
            "off by, %",
            "Our disc: true",
            "found",
            "off by, %",
        ],
        rows.collect(),
    );
}

fn micro_with_error(parameter: &Parameter) -> Cell {
    Cell::Number(format!(
        "{:.3} ± {:.3}",
        parameter.rad * 1e6,
        parameter.standard_error_rad * 1e6
    ))
}

fn micro(rad: f64) -> Cell {
    Cell::fixed(rad * 1e6, 2)
}

fn real(body: &mut Body, run: &Run) {
    let plan = run.calibration.plan;
    let text = format!(
        "Three Hall sensors of a spindle motor, 28,699 edges with 33 µs time stamps, from a motor controller's own test data. The turn was \
         found to have {} {} by the pattern that the intervals repeat. {} turns of the first half gave the table; the figures are \
         from the second half.",
        plan.lines,
        plan.kind.line_name(),
        run.calibration.totals.turns
    );
    body.section("A real recording: hall-spindle.csv", &[&text]);
    figures::parameter_table(body, &run.findings);
    body.figure(
        figures::speed_pattern(&run.check.profile),
        "Deviation of the speed at each of the 12 edges of a turn, mean over the second half.",
    );
    let scatter = &run.check.scatter;
    body.figure(
        figures::before_after("Scatter of the speed, RMS", "%", 100.0 * scatter.before, 100.0 * scatter.after),
        "Scatter from edge to edge around the mean speed of the turn. Much of what is left alternates between rising and falling edges: \
         their distance grows with speed in this recording, and the second half runs faster. One table holds one mean of that.",
    );
}
