//! The report of a calibration.

use crate::calibrate::Calibration;
use crate::findings::Findings;
use crate::report::{Body, Cell, Footer, Level, Report, Tile};
use crate::sensor::SensorKind;
use crate::showcase::Showcase;

use super::{figures, words};

/// The page of a calibration of the recording `name`.
#[must_use]
pub fn report(
    name: &str,
    calibration: &Calibration,
    findings: &Findings,
    shown: &Showcase,
    footer: Footer,
) -> Report {
    let plan = calibration.plan;
    let mut report = Report::new(
        "Encoder calibration",
        format!(
            "{name}: {}, {} {}",
            words::sensor(plan.kind),
            plan.lines,
            plan.kind.line_name()
        ),
    );
    verdict(&mut report, calibration, findings, shown);
    let body = report.body();
    speed(body, shown);
    errors(body, calibration, findings);
    turns(body, calibration);
    report.details("Details", details(calibration, findings));
    report.footer(footer);
    report
}

fn verdict(report: &mut Report, calibration: &Calibration, findings: &Findings, shown: &Showcase) {
    let (before, after) = (findings.before_rad, findings.after_rad);
    let gain = words::reduction_percent(before, after);
    let outlook = words::outlook(before, after);
    let mut headline = outlook.clone();
    if let Some(first) = outlook.get(..1) {
        headline = first.to_uppercase() + &outlook[1..];
    }
    let mut level = if gain < 5.0 { Level::Warn } else { Level::Good };
    if shown.worse_later() {
        level = Level::Bad;
        headline = words::worse_later(shown);
    }
    let totals = &calibration.totals;
    let rejected = totals.broken + totals.irregular + totals.speed_change;
    report.verdict(
        level,
        format!("{headline}."),
        vec![
            Tile::si(
                "Error before",
                before,
                "rad",
                "RMS expected without the table",
            ),
            Tile::si(
                "Error after",
                after,
                "rad",
                "RMS expected with it: its standard error",
            ),
            Tile::new("Reduction", format!("{gain:.1}"), "%", "of the RMS error"),
            Tile::new(
                "Turns used",
                totals.turns.to_string(),
                "",
                format!("{rejected} rejected"),
            ),
        ],
    );
}

/// Speed before and after, on which turns.
pub(super) fn speed(body: &mut Body, shown: &Showcase) {
    let which = if shown.later {
        "on turns after those learned from"
    } else {
        "on the turns learned from, as the recording has no later ones (calibrate with --turns or --fraction to keep some)"
    };
    let scatter = &shown.check.scatter;
    let text = format!(
        "Speed from edge to edge (T-method) {which}. It scatters by {:.3} % RMS around the mean speed of the turn as measured and by \
         {:.3} % corrected; what is left is the motion itself and the clock's resolution.",
        100.0 * scatter.before,
        100.0 * scatter.after
    );
    body.section("Speed before and after", &[&text]);
    body.figure(
        figures::speed(&shown.check.profile),
        "Speed at every edge of one turn.",
    );
}

fn errors(body: &mut Body, calibration: &Calibration, findings: &Findings) {
    body.section(
        "What was learned",
        &["The angle read at an edge is the grid's; the shaft's own is the grid's less the error of that edge. The error is the offset \
           of its class (which signal, rising or falling) plus the line position error eps of that one edge."],
    );
    figures::parameter_table(body, findings);
    let caption = format!(
        "Line position error eps of every edge: {} RMS, each known to {}.",
        crate::report::si(findings.eps_rms_rad(), "rad"),
        crate::report::si(findings.after_rad, "rad")
    );
    body.figure(figures::eps(findings), caption);
    let class_label = match calibration.plan.kind {
        SensorKind::Quadrature { .. } => "width, quadrature",
        _ => "edge classes",
    };
    body.figure(
        figures::spectrum(findings, calibration.plan.lines, class_label),
        "Order spectrum of the table: cycles a turn and their size in angle. The level line is the standard error of one order.",
    );
    if findings.left_alone.is_empty() {
        return;
    }
    body.section(
        "Orders left alone",
        &["These orders repeat every turn and stand far above their neighbours. Torque ripple locked to the shaft does that, and so do \
           eccentricity and tilt of the disc; a recording at one speed can't tell which. The table does not touch them, so real \
           ripple is not hidden. A recording at a second speed tells: a disc's error keeps its size in angle, torque ripple shrinks \
           with the square of the speed."],
    );
    let rows = findings.left_alone.iter().map(|left| {
        vec![
            Cell::fixed(f64::from(left.order), 0),
            Cell::si(left.amplitude_rad, "rad"),
        ]
    });
    body.table(
        "Orders left alone",
        &["Order (cycles a turn)", "Peak size in angle"],
        rows.collect(),
    );
}

fn turns(body: &mut Body, calibration: &Calibration) {
    body.section(
        "Turns",
        &["The first whole turn only sets the speed. Turns with faults are left out, not mended."],
    );
    figures::turn_table(body, calibration);
}

#[allow(clippy::cast_precision_loss)]
fn details(calibration: &Calibration, findings: &Findings) -> Body {
    let mut body = Body::new();
    figures::class_table(&mut body, findings);
    body.figure(
        figures::weights(findings),
        "How far each order is believed: 1 is taken as measured, 0 is left alone. Orders to the right of the plot are all weighed \
         like the last one.",
    );
    let (survey, faults) = (&calibration.survey, &calibration.faults);
    let count = |value: u32| Cell::fixed(f64::from(value), 0);
    body.table(
        "Recording",
        &["What", "Value"],
        vec![
            vec![
                "Clock".into(),
                Cell::si(survey.header.clock_hz as f64, "Hz"),
            ],
            vec!["Length".into(), Cell::si(survey.seconds(), "s")],
            vec!["Rows".into(), Cell::fixed(survey.rows as f64, 0)],
            vec![
                "Index pulses".into(),
                Cell::fixed(survey.index_pulses as f64, 0),
            ],
            vec![
                "Edges a turn".into(),
                Cell::fixed(f64::from(calibration.solution.shape().edges()), 0),
            ],
            vec![
                "Edge 0 is at".into(),
                words::origin(calibration.plan).into(),
            ],
            vec!["Lost edges found at the index".into(), count(faults.lost)],
            vec!["Extra edges found at the index".into(), count(faults.extra)],
            vec!["Illegal changes of level".into(), count(faults.illegal)],
            vec!["Glitches".into(), count(faults.glitch)],
        ],
    );
    body
}
