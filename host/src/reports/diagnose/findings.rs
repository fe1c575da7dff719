//! A finding: what, where, how large, and what speaks for it.

use crate::diagnose::diagnosis::{Diagnosis, Finding, Parameter};
use crate::diagnose::shown::{FindingPlot, Shown};
use crate::report::plot::{Series, Xy};
use crate::report::{Body, Cell, Colour};
use crate::reports::words::arc_seconds;

use super::curves::{axis_of, columns, series, unit_factor};
use super::words;

/// All findings, a line each.
pub(super) fn overview(body: &mut Body, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    body.section("What was missing", &[]);
    let rows = (1_u32..).zip(findings).map(|(number, finding)| {
        vec![
            Cell::fixed(f64::from(number), 0),
            words::sentence(finding.mechanism.title()).into(),
            place(finding).into(),
            words::size(finding).into(),
            words::confidence(finding).into(),
        ]
    });
    body.table(
        "",
        &["", "What", "Where", "Size, 95 % interval", "Confidence"],
        rows.collect(),
    );
}

/// A section for each finding.
pub(super) fn sections(body: &mut Body, diagnosis: &Diagnosis, shown: &Shown) {
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        let title = words::sentence(finding.mechanism.title());
        let mut text = format!("{}.", place(finding));
        if let Some(exponent) = finding.place.speed_exponent {
            let goes = match exponent {
                0.0 => "is the same".to_owned(),
                1.0 => "goes with it".to_owned(),
                exponent => format!("goes with its power of {}", exponent_text(exponent)),
            };
            text += &format!(" It was seen at more than one speed, and its angle {goes}.");
        }
        body.section(format!("{}. {title}", index + 1), &[&text]);
        // A finding may have no curve of its own, and then plots are fewer.
        let plot = shown.findings.get(index);
        if let Some(plot) = plot.filter(|plot| plot.mechanism == finding.mechanism) {
            figure(body, plot);
        }
        if !finding.parameters.is_empty() {
            parameters(body, finding);
        }
        evidence(body, finding);
        look_alikes(body, finding, diagnosis);
    }
}

fn place(finding: &Finding) -> String {
    let sentence = finding.text.trim().trim_end_matches('.');
    if sentence.is_empty() {
        return "No one place".to_owned();
    }
    words::sentence(sentence)
}

fn exponent_text(exponent: f64) -> String {
    let text = format!("{exponent:.1}");
    text.replace('-', "\u{2212}").replace(".0", "")
}

fn evidence(body: &mut Body, finding: &Finding) {
    let rows = words::evidence(&finding.evidence).into_iter();
    let rows = rows.map(|(against, result)| vec![words::sentence(&against).into(), result.into()]);
    let confidence = words::confidence(finding);
    let named = words::named(finding.mechanism);
    body.table(
        format!("Evidence: {confidence} that it is {named}"),
        &["Held against", "What comes of it"],
        rows.collect(),
    );
}

/// Its parameters; angles in degrees or arc seconds too.
fn parameters(body: &mut Body, finding: &Finding) {
    let angle = |parameter: &Parameter| parameter.unit == "rad";
    let angles = finding.parameters.values().any(angle);
    let mut columns = vec!["Parameter", "Value", "In twin and JSON"];
    if angles {
        columns.push("In other units");
    }
    let rows = finding.parameters.iter().map(|(name, parameter)| {
        let mut row = vec![
            words::sentence(&words::parameter_name(name, &parameter.unit)).into(),
            Cell::Number(words::with_interval(parameter)),
            name.as_str().into(),
        ];
        if angles {
            let text = match angle(parameter) {
                true => arc_seconds(parameter.value),
                false => String::new(),
            };
            row.push(text.into());
        }
        row
    });
    body.table(
        "Size, with the interval that holds the true value in 95 of 100 cases",
        &columns,
        rows.collect(),
    );
}

fn figure(body: &mut Body, plot: &FindingPlot) {
    let (x, y) = (axis_of(&plot.x_label), axis_of(&plot.y_label));
    let scale = [unit_factor(&plot.x_label), unit_factor(&plot.y_label)];
    let mut drawn =
        Xy::new(x, y).series(series("without it", &plot.before, scale).colour(Colour::BEFORE));
    // What moves no edge leaves the residual as it is.
    let differs = plot.after != plot.before;
    if differs && !plot.after.is_empty() {
        drawn = drawn.series(series("with it", &plot.after, scale).colour(Colour::AFTER));
    }
    if !plot.model.is_empty() {
        let [x, y] = columns(&plot.model, scale);
        let model = Series::dashed("what it makes", &x, &y);
        drawn = drawn.series(model.colour(Colour::Green));
    }
    let caption = if plot.after.is_empty() {
        "How far edges come from where the twin has them, with everything else found in the twin."
    } else if differs {
        "How far edges come from where the twin has them, in the coordinate where this shows: with everything else found in the twin \
         (orange), and with this too (blue)."
    } else {
        "How far edges come from where the twin has them. This moves them no more to one side than to the other."
    };
    body.figure(drawn, caption);
}

fn look_alikes(body: &mut Body, finding: &Finding, diagnosis: &Diagnosis) {
    let names = finding.look_alikes.iter().copied().map(words::named);
    let names: Vec<String> = names.collect();
    let mut paragraphs = Vec::new();
    if !names.is_empty() {
        let these = match diagnosis.recordings.len() {
            1 => "This recording",
            _ => "These recordings",
        };
        paragraphs.push(format!(
            "{these} would look much the same with {} in its place.",
            words::list_or(&names)
        ));
    }
    if let Some(next) = &finding.next_recording {
        let above = diagnosis.next_recording.as_ref() == Some(next);
        paragraphs.push(match above {
            true => "The recording named at the top would tell.".to_owned(),
            false => format!("Record next: {}", words::next(next)),
        });
    }
    let paragraphs: Vec<&str> = paragraphs.iter().map(String::as_str).collect();
    if !paragraphs.is_empty() {
        body.section("", &paragraphs);
    }
}
