//! The report of a check of a table on a recording.

use crate::report::plot::{Axis, Series, Xy};
use crate::report::{Body, Cell, Colour, Footer, Level, Report, Tile, si};
use crate::verify::{ReferenceCheck, Verdict, Verification};

use super::{figures, words};

/// The verdict in one sentence.
#[must_use]
pub fn headline(check: &Verification) -> String {
    let (what, before, after) = compared(check);
    let gain = words::reduction_percent(before, after);
    match check.verdict() {
        Verdict::Better => format!("The table takes {gain:.1} % off the {what}"),
        Verdict::Same => format!("The table makes no difference to the {what}"),
        Verdict::Worse => format!(
            "The table makes the {what} worse by {:.1} %: don't use it",
            -gain
        ),
        Verdict::OtherDisc => format!(
            "The table is of another disc, or the index moved: {:.0} % of its line pattern shows, so don't use it, though the {what} \
             changes by {:.1} %",
            100.0 * check.pattern.map_or(0.0, |pattern| pattern.share.max(0.0)),
            -gain
        ),
    }
}

/// What decides, before and after.
#[must_use]
pub fn compared(check: &Verification) -> (&'static str, f64, f64) {
    match &check.reference {
        Some(reference) => (
            "angle error against the reference",
            reference.before_rad,
            reference.after_rad,
        ),
        None => (
            "scatter of the intervals",
            check.scatter.before,
            check.scatter.after,
        ),
    }
}

/// The turns that were looked at, in words.
#[must_use]
pub fn turns_used(check: &Verification) -> &'static str {
    if check.same_recording {
        "turns after those the table was learned from"
    } else {
        "all turns: the table is from another recording"
    }
}

/// The page of a check of the table `table` on the recording `name`.
#[must_use]
pub fn report(name: &str, table: &str, check: &Verification, footer: Footer) -> Report {
    let mut report = Report::new("Check of an error table", format!("{table} on {name}"));
    let level = match check.verdict() {
        Verdict::Better => Level::Good,
        Verdict::Same => Level::Warn,
        Verdict::Worse | Verdict::OtherDisc => Level::Bad,
    };
    let scatter = &check.scatter;
    let percent = |share: f64| format!("{:.3}", 100.0 * share);
    let mut tiles = Vec::new();
    if let Some(reference) = &check.reference {
        tiles.extend([
            Tile::si(
                "RMSE before",
                reference.before_rad,
                "rad",
                "against the reference, equation (22)",
            ),
            Tile::si(
                "RMSE after",
                reference.after_rad,
                "rad",
                "same edges, corrected",
            ),
        ]);
    }
    tiles.extend([
        Tile::new(
            "Scatter before",
            percent(scatter.before),
            "%",
            "RMS of the speed from edge to edge",
        ),
        Tile::new(
            "Scatter after",
            percent(scatter.after),
            "%",
            "same intervals, corrected",
        ),
    ]);
    report.verdict(level, format!("{}.", headline(check)), tiles);
    let body = report.body();
    if let Some(reference) = &check.reference {
        against_reference(body, reference);
    }
    let text = format!(
        "{} intervals, on {}. Each speed is held against the mean over the turn around it, which holds no encoder error.",
        scatter.intervals,
        turns_used(check)
    );
    body.section("Speed before and after", &[&text]);
    body.figure(
        figures::speed(&check.profile),
        "Speed at every edge of one turn.",
    );
    body.figure(
        figures::speed_pattern(&check.profile),
        "Deviation of the speed at every edge, mean over all turns: what repeats is the encoder's error and what the machine does \
         every turn.",
    );
    report.footer(footer);
    report
}

fn against_reference(body: &mut Body, reference: &ReferenceCheck) {
    let text = format!(
        "Angle of the encoder less the reference's over its ratio, equation (21), at {} edges; every unbroken stretch with its own \
         origin.",
        reference.edges
    );
    body.section("Against the reference", &[&text]);
    let angle = figures::degrees(reference.error_before_rad.len());
    let series = |name, values: &[f64], colour| {
        if angle.len() < 64 {
            Series::points(name, &angle, values).colour(colour)
        } else {
            Series::line(name, &angle, values).colour(colour)
        }
    };
    body.figure(
        Xy::new(Axis::turn(), Axis::new("Angle error", "rad"))
            .series(series(
                "as measured",
                &reference.error_before_rad,
                Colour::BEFORE,
            ))
            .series(series(
                "corrected",
                &reference.error_after_rad,
                Colour::AFTER,
            )),
        "Mean angle error of every edge over one turn.",
    );
    body.table(
        "Root mean square error, equation (22)",
        &["", "RMSE", "In arc seconds"],
        [
            ("before", reference.before_rad),
            ("after", reference.after_rad),
        ]
        .map(|(name, rad)| -> Vec<Cell> {
            vec![
                name.into(),
                si(rad, "rad").into(),
                words::arc_seconds(rad).into(),
            ]
        })
        .to_vec(),
    );
}
