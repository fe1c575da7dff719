//! The report of a diagnosis.

mod compared;
mod curves;
#[cfg(test)]
pub(crate) mod example;
mod findings;
pub mod recordings;
#[cfg(test)]
mod tests;
pub mod words;

use crate::diagnose::diagnosis::{Diagnosis, Verdict};
use crate::diagnose::run::Diagnosed;
use crate::diagnose::verdict::{NO_NOISE, Rest};
use crate::report::plot::{Axis, Bars};
use crate::report::{Body, Cell, Colour, Footer, Level, Report, Tile};

/// The page of a diagnosis.
#[must_use]
pub fn report(diagnosed: &Diagnosed, footer: Footer) -> Report {
    let Diagnosed {
        diagnosis, shown, ..
    } = diagnosed;
    let mut report = Report::new("Diagnosis", subtitle(diagnosis));
    report.verdict(
        level(diagnosis),
        words::headline(diagnosis),
        tiles(diagnosis),
    );
    let body = report.body();
    findings::overview(body, &diagnosis.findings);
    if let Some(next) = &diagnosis.next_recording {
        let text = words::next(next);
        body.section("The recording to make next", &[&text]);
    }
    findings::sections(body, diagnosis, shown);
    agreement(body, diagnosis);
    recordings::sections(body, diagnosis, &shown.recordings);
    report.details("Details", details(diagnosis));
    report.footer(footer);
    report
}

pub(super) fn subtitle(diagnosis: &Diagnosis) -> String {
    let recordings = diagnosis.recordings.iter();
    let files: Vec<String> = recordings.clone().map(|facts| facts.file.clone()).collect();
    let mut twins: Vec<String> = recordings.map(|facts| facts.twin.clone()).collect();
    twins.dedup();
    format!("{} against {}", words::list(&files), words::list(&twins))
}

pub(super) fn level(diagnosis: &Diagnosis) -> Level {
    match diagnosis.verdict {
        Verdict::Complete | Verdict::Explained => {
            match Rest::of(&diagnosis.fit, !diagnosis.findings.is_empty()) {
                Rest::More(_) => Level::Warn,
                Rest::Noise | Rest::Hidden => Level::Good,
            }
        }
        Verdict::Partly | Verdict::Ambiguous => Level::Warn,
        Verdict::Unknown => Level::Bad,
    }
}

fn tiles(diagnosis: &Diagnosis) -> Vec<Tile> {
    let fit = &diagnosis.fit;
    let found = words::mended(diagnosis);
    let given = match words::by_slips(fit) {
        true => "RMS within a slip, the twin as given",
        false => "RMS over two turns, the twin as given",
    };
    let name = if found { "Residual before" } else { "Residual" };
    let after = fit.rms_after_rad.filter(|_| found);
    let residuals = [
        (name, fit.rms_before_rad, given),
        (
            "Residual after",
            after,
            "RMS, with the findings in the twin",
        ),
        ("Noise", fit.floor_rad, "RMS, no twin can do better"),
    ];
    let mut tiles = vec![Tile::new(
        "Verdict",
        words::verdict_id(diagnosis.verdict),
        "",
        words::meaning(diagnosis.verdict),
    )];
    tiles.extend(
        residuals
            .into_iter()
            .filter_map(|(name, rms, note)| Some(Tile::si(name, rms?, "rad", note))),
    );
    if let Some(percent) = words::removed(diagnosis) {
        tiles.push(Tile::new(
            "Foretold",
            format!("{percent:.1}"),
            "%",
            "of what the findings can explain at best, on turns not fitted on",
        ));
    }
    tiles
}

fn agreement(body: &mut Body, diagnosis: &Diagnosis) {
    let (fit, held) = (&diagnosis.fit, &diagnosis.fit.held_out);
    let found = words::mended(diagnosis);
    let mut text = String::new();
    let names = ["with the twin as given", "with the findings"];
    if let Some(noise) = words::is_noise(fit, found, names) {
        text = format!(
            "Probability that noise alone leaves a residual like this: {noise}. Under {NO_NOISE} something is left that is no noise. "
        );
    }
    if found && held.rms_after_rad.is_some() {
        text += &format!(
            "Parameters were fitted on the earlier {0} and judged on the last ones of each recording, held out. ",
            words::judged_on(fit)
        );
    }
    text += match words::by_slips(fit) {
        true => {
            "The residual is how far the edges of each slip stand away from the twin's course, the slip's own instant and place taken \
             off, as noise moves both; the twin as given goes on steadily."
        }
        false => {
            "The residual is how far edges stand away from the twin's course, less the mean of a turn to either side: what comes \
             again each turn keeps its size in it, slow wander is out of it."
        }
    };
    body.section("How well it fits", &[&text]);
    let bars = |before: Option<f64>, after: Option<f64>, floor: Option<f64>| {
        let bars = Bars::new(Axis::new("Residual, RMS", "rad"));
        let after = after.filter(|_| found);
        let all = [
            ("twin as given", before, Colour::BEFORE),
            ("with the findings", after, Colour::AFTER),
            ("noise alone", floor, Colour::Grey),
        ];
        all.into_iter()
            .fold(bars, |bars, (name, rms, colour)| match rms {
                Some(rms) => bars.bar(name, rms, colour),
                None => bars,
            })
    };
    let every = bars(fit.rms_before_rad, fit.rms_after_rad, fit.floor_rad);
    let all = match words::by_slips(fit) {
        true => "All slips.",
        false => "All turns.",
    };
    if held.rms_after_rad.is_none() {
        body.figure(every, all);
        return;
    }
    body.figure_pair(
        (every, all),
        (
            bars(held.rms_before_rad, held.rms_after_rad, held.floor_rad),
            match words::by_slips(fit) {
                true => "Slips held out.",
                false => "Turns held out.",
            },
        ),
    );
    if !found || words::by_slips(fit) {
        return;
    }
    let [slow, edges] = words::bands(fit)
        .map(|(_, band)| bars(band.rms_before_rad, band.rms_after_rad, band.floor_rad));
    body.figure_pair(
        (
            slow,
            "What is slower than two turns, beside a straight line in time.",
        ),
        (
            edges,
            "How far each edge comes from where the edges before it let it expect.",
        ),
    );
}

fn details(diagnosis: &Diagnosis) -> Body {
    let mut body = Body::new();
    recordings::table(&mut body, &diagnosis.recordings);
    for facts in &diagnosis.recordings {
        if !facts.disturbed_s.is_empty() {
            let text = format!(
                "The count of {} was disturbed at {}.",
                facts.file,
                times(&facts.disturbed_s)
            );
            body.section("", &[&text]);
        }
    }
    let rows = diagnosis.findings.iter().map(|finding| {
        let place = &finding.place;
        let numbers = |values: &[f64]| {
            let all: Vec<String> = values.iter().map(|v| format!("{v:.4}")).collect();
            let short = |text: &String| text.trim_end_matches('0').trim_end_matches('.').to_owned();
            Cell::Text(all.iter().map(short).collect::<Vec<_>>().join(", "))
        };
        vec![
            finding.mechanism.id().into(),
            numbers(&place.orders),
            numbers(&place.frequencies_hz),
            numbers(&place.angles_deg),
            place.times_s.len().to_string().into(),
            place.edge_classes.join(", ").into(),
            place.channels.join(", ").into(),
            place.directions.join(", ").into(),
        ]
    });
    if !diagnosis.findings.is_empty() {
        body.table(
            "Where the findings show",
            &[
                "Mechanism",
                "Orders",
                "Hz",
                "Degrees",
                "Instants",
                "Edges",
                "Channels",
                "Directions",
            ],
            rows.collect(),
        );
    }
    body
}

/// The first of some instants.
fn times(instants: &[f64]) -> String {
    const LISTED: usize = 10;
    let first: Vec<String> = instants
        .iter()
        .take(LISTED)
        .map(|t| format!("{t:.4} s"))
        .collect();
    match instants.len().saturating_sub(LISTED) {
        0 => words::list(&first),
        more => format!("{} and {more} more (--json lists all)", first.join(", ")),
    }
}
