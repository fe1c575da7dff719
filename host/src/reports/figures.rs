//! Figures and tables that several reports share.

use std::f64::consts::TAU;

use quadcal::units::RAD_PER_TURN32;

use crate::calibrate::{AfterTurn, Calibration};
use crate::findings::{Findings, order_amplitudes};
use crate::report::plot::{Axis, Bars, Series, Spectrum, Xy};
use crate::report::{Body, Cell, Colour};
use crate::verify::Profile;

use super::words;

/// Orders up to which a spectrum names what it shows.
const NAMED: usize = 6;

/// Shaft angle of every edge, degrees.
#[allow(clippy::cast_precision_loss)]
pub(super) fn degrees(edges: usize) -> Vec<f64> {
    (0..edges)
        .map(|edge| 360.0 * edge as f64 / edges as f64)
        .collect()
}

/// Speed over one turn as measured and as corrected.
pub(super) fn speed(profile: &Profile) -> Xy {
    let rev = |rad_s: &[f64]| -> Vec<f64> { rad_s.iter().map(|w| w * 60.0 / TAU).collect() };
    let mut order: Vec<usize> = (0..profile.turn_angle_rad.len()).collect();
    // A turn may begin anywhere on the grid.
    order.sort_by(|&a, &b| profile.turn_angle_rad[a].total_cmp(&profile.turn_angle_rad[b]));
    let sorted = |values: &[f64]| -> Vec<f64> { order.iter().map(|&k| values[k]).collect() };
    let angle: Vec<f64> = sorted(&profile.turn_angle_rad)
        .iter()
        .map(|angle| angle.to_degrees())
        .collect();
    Xy::new(Axis::turn(), Axis::new("Angular speed", "r/min"))
        .series(
            Series::line(
                "as measured",
                &angle,
                &sorted(&rev(&profile.turn_before_rad_s)),
            )
            .colour(Colour::BEFORE),
        )
        .series(
            Series::line(
                "corrected",
                &angle,
                &sorted(&rev(&profile.turn_after_rad_s)),
            )
            .colour(Colour::AFTER),
        )
}

/// Mean relative speed error of every edge before and after.
pub(super) fn speed_pattern(profile: &Profile) -> Xy {
    let angle = degrees(profile.mean_before.len());
    let percent = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| 100.0 * v).collect() };
    let series = |name, values: &[f64], colour| {
        let values = percent(values);
        if angle.len() < 64 {
            Series::points(name, &angle, &values).colour(colour)
        } else {
            Series::line(name, &angle, &values).colour(colour)
        }
    };
    Xy::new(Axis::turn(), Axis::new("Mean speed deviation", "%"))
        .series(series("as measured", &profile.mean_before, Colour::BEFORE))
        .series(series("corrected", &profile.mean_after, Colour::AFTER))
}

/// The table's line position errors by angle.
pub(super) fn eps(findings: &Findings) -> Xy {
    let angle = degrees(findings.eps_rad.len());
    let series = if angle.len() < 64 {
        Series::points("eps", &angle, &findings.eps_rad)
    } else {
        Series::line("eps", &angle, &findings.eps_rad)
    };
    Xy::new(Axis::turn(), Axis::new("Line position error", "rad"))
        .series(series.colour(Colour::BEFORE))
}

/// Mean error of every edge class.
pub(super) fn class_table(body: &mut Body, findings: &Findings) {
    let rows = findings
        .class_names
        .iter()
        .zip(&findings.class_offsets_rad)
        .map(|(name, &offset)| {
            let error = findings.class_standard_error_rad;
            vec![(*name).into(), Cell::with_error(offset, error, "rad")]
        });
    body.table(
        "Mean error of each edge class, less the mean of all",
        &["Edge", "Offset ± standard error"],
        rows.collect(),
    );
}

/// xi_A, xi_B, p or what stands for them; none where a sensor has one class only.
pub(super) fn parameter_table(body: &mut Body, findings: &Findings) {
    if findings.parameters.is_empty() {
        return;
    }
    let rows = findings.parameters.iter().map(|parameter| {
        vec![
            parameter.name.into(),
            Cell::with_error(parameter.rad, parameter.standard_error_rad, "rad"),
            words::arc_seconds(parameter.rad).as_str().into(),
        ]
    });
    body.table(
        "Errors of the edge classes against each other",
        &["Parameter", "Value ± standard error", "In other units"],
        rows.collect(),
    );
}

/// The order spectrum of the table, with the standard error as floor and what was left alone.
#[allow(clippy::cast_precision_loss)]
pub(super) fn spectrum(findings: &Findings, lines: u32, class_label: &str) -> Spectrum {
    let amplitudes = order_amplitudes(&findings.error_rad);
    let edges = findings.error_rad.len() as f64;
    let orders: Vec<f64> = (1..=amplitudes.len()).map(|order| order as f64).collect();
    // The standard error spread over all orders alike: N / 2 of them, each of mean square a^2 / 2.
    let floor = 2.0 * findings.after_rad / edges.sqrt();
    let mut figure = Spectrum::new("rad")
        .stems("in the table", &orders, &amplitudes, Colour::BEFORE)
        .floor("standard error", &[1.0], &[floor]);
    if !findings.left_alone.is_empty() {
        let (at, size): (Vec<f64>, Vec<f64>) = findings
            .left_alone
            .iter()
            .map(|left| (f64::from(left.order), left.amplitude_rad))
            .unzip();
        figure = figure.stems("left alone", &at, &size, Colour::Grey);
        for left in findings.left_alone.iter().take(NAMED) {
            figure = figure.name(f64::from(left.order), format!("{} left alone", left.order));
        }
    }
    if lines as usize <= amplitudes.len() {
        figure = figure.name(f64::from(lines), format!("{lines} {class_label}"));
    }
    figure
}

/// How far every order is believed.
#[allow(clippy::cast_precision_loss)]
pub(super) fn weights(findings: &Findings) -> Xy {
    let orders: Vec<f64> = (1..=findings.weights.len())
        .map(|order| order as f64)
        .collect();
    Xy::new(
        Axis::new("Order (cycles a turn)", ""),
        Axis::new("Weight", "").range(0.0, 1.05),
    )
    .series(Series::step("weight", &orders, &findings.weights).colour(Colour::AFTER))
}

/// Error to expect after every turn, and the goal.
pub(super) fn progress(calibration: &Calibration) -> Option<Xy> {
    let turns = calibration.progress.turns();
    if turns.len() < 2 {
        return None;
    }
    let column = |value: fn(&AfterTurn) -> f64| turns.iter().map(value).collect::<Vec<f64>>();
    let taken = column(|after| f64::from(after.turns));
    let error = column(AfterTurn::error_rad);
    let plot = Xy::new(
        Axis::new("Turns taken", ""),
        Axis::new("Error to expect, RMS", "rad").log(),
    )
    .series(Series::line("after this many turns", &taken, &error).colour(Colour::AFTER));
    Some(match calibration.goal {
        None => plot,
        Some(goal) => {
            let goal = vec![f64::from(goal.error.max(1)) * RAD_PER_TURN32; taken.len()];
            plot.series(Series::dashed("goal", &taken, &goal))
        }
    })
}

/// Turns used and rejected, of all recordings.
pub(super) fn turn_table(body: &mut Body, calibration: &Calibration) {
    let totals = &calibration.totals;
    let row = |what: &str, count: u32, why: &str| -> Vec<Cell> {
        vec![what.into(), Cell::fixed(f64::from(count), 0), why.into()]
    };
    let speeds = words::speed_range(words::speeds_r_min(totals, calibration.clock_hz));
    let used = row("used", totals.turns, &format!("whole, at {speeds}"));
    let rejected = words::rejections(totals).map(|(what, count, why)| row(what, count, why));
    let rows = std::iter::once(used).chain(rejected);
    body.table("Turns", &["Turns", "Number", "Why"], rows.collect());
}

/// Before and after as bars over zero.
pub(super) fn before_after(label: &str, unit: &str, before: f64, after: f64) -> Bars {
    Bars::new(Axis::new(label, unit))
        .bar("before", before, Colour::BEFORE)
        .bar("after", after, Colour::AFTER)
}
