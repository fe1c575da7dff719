//! A finding: what, where, how large, and what speaks for it.

use crate::diagnose::diagnosis::Finding;
use crate::diagnose::shown::{FindingPlot, Shown};
use crate::report::plot::Xy;
use crate::report::{Body, Cell, Colour};
use crate::reports::words::arc_seconds;

use super::curves::{axis_of, series, unit_factor};
use super::words;

/// A section for each finding.
pub(super) fn sections(body: &mut Body, findings: &[Finding], shown: &Shown) {
    for (index, finding) in findings.iter().enumerate() {
        let title = finding.mechanism.title();
        let title = format!(
            "{}. {}{}",
            index + 1,
            title[..1].to_uppercase(),
            &title[1..]
        );
        let paragraphs = [place(finding), evidence(finding)];
        let paragraphs: Vec<&str> = paragraphs.iter().map(String::as_str).collect();
        body.section(title, &paragraphs);
        if !finding.parameters.is_empty() {
            table(body, finding);
        }
        // A finding may have no curve of its own, and then plots are fewer.
        let plot = shown.findings.get(index);
        if let Some(plot) = plot.filter(|plot| plot.mechanism == finding.mechanism) {
            figure(body, plot);
        }
        look_alikes(body, finding);
    }
}

fn place(finding: &Finding) -> String {
    let sentence = finding.text.trim().trim_end_matches('.');
    let known = format!("Known as {}", finding.mechanism.id());
    let mut text = match sentence {
        "" => format!("{known}."),
        sentence => format!("{sentence}."),
    };
    if let Some(exponent) = finding.place.speed_exponent {
        text += &format!(
            " Seen at more than one speed, its angle goes with the speed to the power of {}.",
            exponent_text(exponent)
        );
    }
    text
}

fn exponent_text(exponent: f64) -> String {
    let text = format!("{exponent:.1}");
    text.replace('-', "\u{2212}").replace(".0", "")
}

fn evidence(finding: &Finding) -> String {
    let clauses = words::evidence(&finding.evidence).join("; ");
    format!("Confidence {}: {clauses}.", words::confidence(finding))
}

/// Its parameters; angles in degrees or arc seconds too.
fn table(body: &mut Body, finding: &Finding) {
    let rows = finding.parameters.iter().map(|(name, parameter)| {
        let other = match parameter.unit.as_str() {
            "rad" => arc_seconds(parameter.value).into(),
            _ => Cell::Text(String::new()),
        };
        vec![
            words::parameter_name(name, &parameter.unit).into(),
            Cell::Number(words::with_interval(parameter)),
            other,
            name.as_str().into(),
        ]
    });
    body.table(
        "Size, with the interval that holds the true value in 95 of 100 cases",
        &["Parameter", "Value", "In other units", "In twin and JSON"],
        rows.collect(),
    );
}

fn figure(body: &mut Body, plot: &FindingPlot) {
    let (x, y) = (axis_of(&plot.x_label), axis_of(&plot.y_label));
    let scale = [unit_factor(&plot.x_label), unit_factor(&plot.y_label)];
    let mut drawn = Xy::new(x, y)
        .series(series("without it", &plot.before, scale).colour(Colour::BEFORE))
        .series(series("with it", &plot.after, scale).colour(Colour::AFTER));
    if !plot.model.is_empty() {
        let [x, y] = super::curves::columns(&plot.model, scale);
        let model = crate::report::plot::Series::dashed("what it makes", &x, &y);
        drawn = drawn.series(model.colour(Colour::Green));
    }
    body.figure(
        drawn,
        "How far edges come from where the twin has them, in the coordinate where this shows: with everything else found taken out \
         (orange), and with this too (blue).",
    );
}

fn look_alikes(body: &mut Body, finding: &Finding) {
    let names: Vec<String> = finding
        .look_alikes
        .iter()
        .copied()
        .map(words::named)
        .collect();
    let mut paragraphs = Vec::new();
    if !names.is_empty() {
        paragraphs.push(format!(
            "These recordings would look much the same with {} in its place.",
            words::list(&names)
        ));
    }
    if let Some(next) = &finding.next_recording {
        paragraphs.push(format!("Record next: {}", words::next(next)));
    }
    let paragraphs: Vec<&str> = paragraphs.iter().map(String::as_str).collect();
    if !paragraphs.is_empty() {
        body.section("", &paragraphs);
    }
}
