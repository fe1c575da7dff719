//! The report of a calibration.

use crate::calibrate::{Calibration, RecordingUse};
use crate::findings::Findings;
use crate::report::{Body, Cell, Footer, Level, Report, Tile};
use crate::sensor::SensorKind;
use crate::showcase::Showcase;

use super::expected::{self, LeftOut};
use super::{figures, separation, turns, words};

/// A calibration as the report takes it.
pub struct Calibrated<'a> {
    /// Names of the recordings, in the calibration's order.
    pub names: &'a [String],
    /// The calibration.
    pub calibration: &'a Calibration,
    /// What it found.
    pub findings: &'a Findings,
    /// The table at work on each recording.
    pub shown: &'a [Showcase],
    /// Inertia of all that turns, kg m^2, if it is known.
    pub inertia_kg_m2: Option<f64>,
}

/// The page of a calibration.
#[must_use]
pub fn report(calibrated: &Calibrated<'_>, footer: Footer) -> Report {
    let Calibrated {
        names,
        calibration,
        findings,
        shown,
        inertia_kg_m2,
    } = *calibrated;
    let plan = calibration.plan;
    let mut report = Report::new(
        "Encoder calibration",
        format!(
            "{}: {}, {} {}{}",
            names.join(" and "),
            words::sensor(plan.kind),
            plan.lines,
            plan.kind.line_name(),
            words::lines_guessed(calibration)
        ),
    );
    verdict(&mut report, calibration, findings, shown);
    let body = report.body();
    for (name, shown) in names.iter().zip(shown) {
        let of = if names.len() > 1 {
            Some(name.as_str())
        } else {
            None
        };
        speed(body, shown, of);
    }
    errors(body, calibration, findings);
    separation::sections(body, calibration, findings, inertia_kg_m2);
    turns::section(body, calibration, names, findings.after_rad);
    report.details("Details", details(calibration, findings, names));
    report.footer(footer);
    report
}

fn verdict(
    report: &mut Report,
    calibration: &Calibration,
    findings: &Findings,
    shown: &[Showcase],
) {
    let (before, after) = (findings.before_rad, findings.after_rad);
    let gain = words::reduction_percent(before, after);
    let left_out = LeftOut::of(calibration, findings);
    let outlook = expected::outlook(findings, &left_out);
    let mut headline = outlook.clone();
    if let Some(first) = outlook.get(..1) {
        headline = first.to_uppercase() + &outlook[1..];
    }
    let doubtful = gain < 5.0 || findings.loop_suspicion.is_some() || !left_out.is_nothing();
    let mut level = if doubtful { Level::Warn } else { Level::Good };
    if let Some(worse) = shown.iter().find(|shown| shown.worse_later()) {
        level = Level::Bad;
        headline = words::worse_later(worse);
    }
    let totals = &calibration.totals;
    let rejected: u32 = words::rejections(totals).iter().map(|(_, n, _)| n).sum();
    let reduction = match (&findings.loop_suspicion, left_out.is_nothing()) {
        (Some(_), _) => Tile::new("Reduction", "?", "", "not known: was a speed loop on?"),
        (None, true) => Tile::new("Reduction", format!("{gain:.1}"), "%", "of the RMS error"),
        (None, false) => Tile::new(
            "Reduction",
            format!("{gain:.1}"),
            "%",
            "of the RMS error, without the orders left alone",
        ),
    };
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
                format!(
                    "RMS expected with it: its standard error{}{}",
                    left_out.besides(),
                    expected::proviso(findings)
                ),
            ),
            reduction,
            Tile::new(
                "Turns used",
                totals.turns.to_string(),
                "",
                format!("{rejected} rejected"),
            ),
        ],
    );
}

/// Speed before and after, on which turns, of the recording `of` where there are several.
pub(super) fn speed(body: &mut Body, shown: &Showcase, of: Option<&str>) {
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
    let title = "Speed before and after";
    let title = of.map_or_else(|| title.to_owned(), |name| format!("{title}: {name}"));
    body.section(&title, &[&text]);
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
}

fn details(calibration: &Calibration, findings: &Findings, names: &[String]) -> Body {
    let mut body = Body::new();
    figures::class_table(&mut body, findings);
    body.figure(
        figures::weights(findings),
        "How far each order is believed: 1 is taken as measured, 0 is left alone. Orders to the right of the plot are all weighed \
         like the last one.",
    );
    for (name, used) in names.iter().zip(&calibration.recordings) {
        recording_table(&mut body, calibration, name, used);
    }
    body
}

#[allow(clippy::cast_precision_loss)]
fn recording_table(body: &mut Body, calibration: &Calibration, name: &str, used: &RecordingUse) {
    let (survey, faults) = (&used.survey, &used.faults);
    let count = |value: u32| Cell::fixed(f64::from(value), 0);
    body.table(
        format!("Recording {name}"),
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
}
