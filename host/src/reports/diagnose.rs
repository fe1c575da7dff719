//! The report and the text of a diagnosis.

mod behind;
mod cells;
#[cfg(test)]
pub(crate) mod example;
mod fit;
mod map;
pub mod recordings;
mod shape;
mod sure;
#[cfg(test)]
mod tests;
mod told;
pub mod words;

use crate::diagnose::diagnosis::Answer;
use crate::diagnose::diagnosis::{Diagnosis, Finding, RecordingFacts, Verdict};
use crate::report::{Body, Footer, Level, Report, Tile};

pub use cells::cell;
use map::Strongest;

/// The page of an answer.
#[must_use]
pub fn report(answer: &Answer, footer: Footer) -> Report {
    let diagnosis = &answer.diagnosis;
    let mut report = Report::new("Diagnosis", subtitle(diagnosis));
    report
        .verdict(level(diagnosis), words::headline(diagnosis), tiles(answer))
        .action(action(answer));
    let body = report.body();
    map::section(body, answer);
    findings(body, answer);
    fit::section(body, answer);
    report.details("The numbers behind it", behind::numbers(answer));
    report.details("Recordings", behind::recordings(diagnosis));
    report.footer(footer);
    report
}

/// What `quadcal diagnose` prints of an answer: names and values, one a line; a name may be empty, where a line goes on with the one above.
#[must_use]
pub fn text(answer: &Answer) -> Vec<(String, String)> {
    let diagnosis = &answer.diagnosis;
    let mut lines = Vec::new();
    let mut add = |name: &str, value: String| lines.push((name.to_owned(), value));
    let verdict = diagnosis.verdict;
    add(
        "Verdict",
        format!(
            "{}: {}",
            words::verdict_id(verdict),
            words::meaning(verdict)
        ),
    );
    if !diagnosis.summary.trim().is_empty() {
        add("", words::headline(diagnosis));
    }
    add("What to do", action(answer));
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        let told = told::told(answer, index, finding);
        add(&format!("Finding {}", index + 1), told.title);
        for (name, texts) in told.facts {
            for (at, text) in texts.into_iter().enumerate() {
                let name = match at {
                    0 => format!("  {}", name.to_lowercase()),
                    _ => String::new(),
                };
                add(&name, text);
            }
        }
    }
    let found = fit::fell(answer);
    for (at, part) in fit::parts(&diagnosis.fit).iter().enumerate() {
        let name = match at {
            0 => "Residual, RMS".to_owned(),
            _ => format!("  {}", part.name.to_lowercase()),
        };
        add(&name, fit::line(part, found));
    }
    if let Some(shares) = fit::correlated(&diagnosis.fit, found) {
        add("  still foretold by edges before", shares);
    }
    let map = &answer.map;
    let mut strongest = Strongest::of(map, &map.before).map(|cell| cell.words());
    if let (true, Some(text), Some(after)) = (found, &mut strongest, Strongest::of(map, &map.after))
    {
        *text = format!("{text}; after: {}; noise gives about 1", after.words());
    }
    if let Some(text) = strongest {
        add("Strongest mismatch", text);
    }
    for (at, text) in behind::beside(answer).into_iter().enumerate() {
        add(if at == 0 { "Also" } else { "" }, text);
    }
    for recording in &diagnosis.recordings {
        add("Recording", behind::recording(recording));
    }
    lines
}

/// The one line to act on.
fn action(answer: &Answer) -> String {
    let diagnosis = &answer.diagnosis;
    let mut recordings = diagnosis.recordings.iter();
    if let Some(other) = recordings.find_map(RecordingFacts::other_speed) {
        return format!("Check that the twin belongs to the recording: {other}.");
    }
    if let Some(next) = &diagnosis.next_recording {
        return format!("Record next: {}", words::next(next));
    }
    let left = Strongest::of(&answer.map, &answer.map.after)
        .filter(|cell| map::worth(diagnosis).is_some_and(|worth| cell.gain >= worth));
    let count = diagnosis.findings.len();
    let write = match count {
        0 => String::new(),
        1 => "Write the finding into the twin (--write-twin) and go on with that. ".to_owned(),
        count => {
            format!("Write the {count} findings into the twin (--write-twin) and go on with that. ")
        }
    };
    let rest = match (diagnosis.verdict, left) {
        // What rounding to ticks makes has a gain as well, and is nothing to be explained.
        (Verdict::Complete, _) if answer.learned_disc_rms_rad.is_some() => {
            "Write the disc that was learned into the twin (--write-twin), or use it as it is."
                .to_owned()
        }
        (Verdict::Complete, _) => "Use the twin as it is.".to_owned(),
        (_, Some(cell)) => format!("Still to be explained: {}.", cell.words()),
        (Verdict::Explained, None) => String::new(),
        (_, None) if count > 0 => match open(&diagnosis.findings) {
            Some(finding) => {
                format!(
                    "First tell what finding {finding} is: its card says what else it could be."
                )
            }
            None => String::new(),
        },
        (_, None) => {
            "Record the same rig at another speed, to see what the residual keeps step with."
                .to_owned()
        }
    };
    format!("{write}{rest}").trim_end().to_owned()
}

/// The first finding that may be something else, by its number.
fn open(findings: &[Finding]) -> Option<usize> {
    let alike = |finding: &Finding| !finding.look_alikes.is_empty();
    findings.iter().position(alike).map(|at| at + 1)
}

fn tiles(answer: &Answer) -> Vec<Tile> {
    let diagnosis = &answer.diagnosis;
    let fit = &diagnosis.fit;
    let found = fit::fell(answer);
    let verdict = Tile::new(
        "Verdict",
        words::verdict_id(diagnosis.verdict),
        "",
        words::meaning(diagnosis.verdict),
    );
    let name = if found { "Residual before" } else { "Residual" };
    let after = fit.rms_after_rad.filter(|_| found);
    let residuals = [
        (name, fit.rms_before_rad, "RMS, the twin as given"),
        ("Residual after", after, "RMS, with what was found"),
        (
            "Noise",
            fit.floor_rad,
            "RMS that noise alone would leave, as found here",
        ),
    ];
    let tile =
        |(name, rms, note): (&str, Option<f64>, &str)| Some(Tile::si(name, rms?, "rad", note));
    let mut tiles = vec![verdict];
    tiles.extend(residuals.into_iter().filter_map(tile));
    tiles
}

/// A card for each finding.
fn findings(body: &mut Body, answer: &Answer) {
    let all = &answer.diagnosis.findings;
    if all.is_empty() {
        return;
    }
    body.section("Findings", &[]);
    for (index, finding) in all.iter().enumerate() {
        let told = told::told(answer, index, finding);
        body.card(
            format!("{}. {}", index + 1, told.title),
            told.facts,
            shape::plot(answer, index),
            Body::new(),
        );
    }
}

fn subtitle(diagnosis: &Diagnosis) -> String {
    let recordings = diagnosis.recordings.iter();
    let files: Vec<String> = recordings.clone().map(|facts| facts.file.clone()).collect();
    let mut twins: Vec<String> = recordings.map(|facts| facts.twin.clone()).collect();
    twins.dedup();
    format!("{} against {}", words::list(&files), words::list(&twins))
}

fn level(diagnosis: &Diagnosis) -> Level {
    match diagnosis.verdict {
        Verdict::Complete | Verdict::Explained => Level::Good,
        Verdict::Partly | Verdict::Ambiguous => Level::Warn,
        Verdict::Unknown => Level::Bad,
    }
}
