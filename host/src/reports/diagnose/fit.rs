//! How well it fits: the residual in numbers, and along each recording.

use crate::diagnose::diagnosis::Answer;
use crate::diagnose::diagnosis::Fit;
use crate::report::plot::{Axis, Series, Xy};
use crate::report::{Body, Cell, Colour, si};
use crate::reports::diagnose::words::removed;

/// One part of the residual: its name and its RMS before, after and of noise alone, rad.
pub(super) struct Part {
    pub(super) name: &'static str,
    pub(super) rms_rad: [Option<f64>; 3],
}

/// The parts of the residual that were compared.
pub(super) fn parts(fit: &Fit) -> Vec<Part> {
    let part = |name, before, after, floor| Part {
        name,
        rms_rad: [before, after, floor],
    };
    let held = &fit.held_out;
    let all = [
        part(
            "All edges",
            fit.rms_before_rad,
            fit.rms_after_rad,
            fit.floor_rad,
        ),
        part(
            "Turns held out of the fit",
            held.rms_before_rad,
            held.rms_after_rad,
            held.floor_rad,
        ),
    ];
    let given = |part: &Part| part.rms_rad[0].is_some();
    all.into_iter().filter(given).collect()
}

/// Whether what was found makes the residual another one: a finding, or a disc that the twin leaves open.
pub(super) fn fell(answer: &Answer) -> bool {
    !answer.diagnosis.findings.is_empty() || answer.learned_disc_rms_rad.is_some()
}

/// A part in a line.
pub(super) fn line(part: &Part, found: bool) -> String {
    let [before, after, floor] = part.rms_rad;
    let mut all = vec![match found {
        true => format!("{} before", before.map_or_else(dash, rad)),
        false => before.map_or_else(dash, rad),
    }];
    if let (true, Some(after)) = (found, after) {
        all.push(format!("{} after", rad(after)));
    }
    if let Some(floor) = floor {
        all.push(format!("noise alone {}", rad(floor)));
    }
    all.join(", ")
}

fn rad(value: f64) -> String {
    si(value, "rad")
}

fn dash() -> String {
    "–".to_owned()
}

/// How much of the residual is no white noise, before and after.
pub(super) fn correlated(fit: &Fit, found: bool) -> Option<String> {
    let before = share(fit.correlated_before?);
    match fit.correlated.filter(|_| found) {
        Some(after) => Some(format!("{before} before, {} after", share(after))),
        None => Some(before),
    }
}

/// A share in per cent.
fn share(value: f64) -> String {
    match 100.0 * value {
        percent if percent < 0.1 => "under 0.1 %".to_owned(),
        percent if percent < 10.0 => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    }
}

/// The section with its table and curves.
pub(super) fn section(body: &mut Body, answer: &Answer) {
    let fit = &answer.diagnosis.fit;
    let found = fell(answer);
    let mut text = "The residual is the innovation: how far each edge comes from where the twin, the edges before it and the noise of \
                    the shaft let it expect."
        .to_owned();
    if let Some(shares) = correlated(fit, found) {
        text += &format!(
            " Share of its variance that the edges before foretell, of which noise has none: {shares}."
        );
    }
    if let Some(percent) = removed(&answer.diagnosis) {
        text += &format!(
            " On turns held out of the fit the findings foretell {percent:.1} % of what they can explain at best."
        );
    }
    body.section("Residual", &[&text]);
    let cell = |rms: Option<f64>| rms.map_or(Cell::Empty, |rms| Cell::si(rms, "rad"));
    let rows = parts(fit).into_iter().map(|part| {
        let [before, after, floor] = part.rms_rad;
        let mut row = vec![part.name.into(), cell(before)];
        if found {
            row.push(cell(after));
        }
        row.push(cell(floor));
        row
    });
    let rows: Vec<Vec<Cell>> = rows.collect();
    if !rows.is_empty() {
        let columns: &[&str] = match found {
            true => &["RMS", "Twin as given", "With what was found", "Noise alone"],
            false => &["RMS", "Twin as given", "Noise alone"],
        };
        body.table("All recordings together", columns, rows);
    }
    for curve in &answer.curves {
        let mut plot = Xy::new(Axis::new("Time", "s"), Axis::new("Innovation, RMS", "rad")).series(
            Series::line("twin as given", &curve.time_s, &curve.before_rad).colour(Colour::BEFORE),
        );
        // Noise that was found leaves the residual as it is.
        if found && curve.after_rad != curve.before_rad {
            let after = Series::line("with what was found", &curve.time_s, &curve.after_rad);
            plot = plot.series(after.colour(Colour::AFTER));
        }
        body.figure(
            plot,
            format!(
                "Innovations along {}, RMS of {} windows.",
                curve.file,
                curve.time_s.len()
            ),
        );
    }
}
