//! What a trial shows: a table of figures, confusion matrices, the wrong cases; as text, Markdown or JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use quadcal_host::diagnose::diagnosis::Verdict;
use serde::Serialize;

use super::figures::{Figure, figures};
use super::matrix::Matrix;
use super::score::{Score, verdict_name};
use super::truth::Kind;

/// A finished trial.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The command that makes it again.
    pub command: String,
    /// Version of `quadcal`.
    pub version: String,
    /// The figures.
    pub figures: Vec<Figure>,
    /// The cases, by name.
    pub cases: Vec<Score>,
}

impl Outcome {
    /// The outcome of scored cases.
    #[must_use]
    pub fn new(command: String, version: String, cases: Vec<Score>) -> Self {
        Self {
            command,
            version,
            figures: figures(&cases),
            cases,
        }
    }

    /// Whether every figure that has a target and any case reaches it.
    #[must_use]
    pub fn met(&self) -> bool {
        self.figures
            .iter()
            .all(|figure| figure.met() != Some(false))
    }

    /// Figures, verdicts and confusion matrices as plain text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!("{:<68}{:>9}{:>12}  to reach\n", "figure", "value", "of");
        for figure in &self.figures {
            let verdict = match figure.met() {
                Some(true) => " (reached)",
                Some(false) => " (MISSED)",
                None => "",
            };
            let _ = writeln!(
                text,
                "{:<68}{:>9}{:>12}  {}{verdict}",
                figure.name,
                figure.value_text(),
                figure.of_text(),
                figure.target_text()
            );
        }
        let _ = write!(text, "\n{}", self.verdicts());
        for matrix in Matrix::all(&self.cases) {
            let _ = write!(text, "\n{} the detectable size\n{matrix}", matrix.size);
        }
        if let Some(names) = self.not_compared() {
            let _ = writeln!(text, "\nintervals without a true value to hold: {names}");
        }
        text
    }

    /// The wrong cases, one a line, with what was said.
    #[must_use]
    pub fn misses(&self) -> String {
        let mut text = String::new();
        for score in &self.cases {
            if let Some(why) = score.wrong() {
                let _ = writeln!(
                    text,
                    "{}  {:<10}  {}{}  ->  {why}",
                    score.case,
                    score.kind.name(),
                    what(score),
                    if score.identifiable {
                        ""
                    } else {
                        " (not identifiable)"
                    }
                );
            }
        }
        text
    }

    /// The whole as a Markdown document.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# Blind trial\n\nWhat `quadcal diagnose` finds in cases whose truth it is not given; written by the command below. \
             A generator with physics of its own draws rig, effects, their sizes and noise; the size that the ideal detector needs (d' = 5) \
             is 1. *Identifiable* is an effect that the ideal detector tells from its look-alikes with d' = 5 or more, or that has none. \
             A run that fails counts as wrong.\n\n```sh\n{}\n```\n\nVersion: {}, {} cases.\n\n",
            self.command,
            self.version,
            self.cases.len()
        );
        text.push_str("| figure | value | of | to reach |\n|---|---|---|---|\n");
        for figure in &self.figures {
            let bold = if figure.target.is_some() { "**" } else { "" };
            let _ = writeln!(
                text,
                "| {} | {bold}{}{bold} | {} | {} |",
                figure.name,
                figure.value_text(),
                figure.of_text(),
                figure.target_text()
            );
        }
        let _ = write!(
            text,
            "\n## Verdicts\n\n```text\n{}```\n\n## Confusion matrices\n\n\
             One effect a case, under a larger pattern or a speed loop included; columns have the numbers of the rows. Where the twin \
             does not give the disc's pattern, what is named for that pattern is left out.\n",
            self.verdicts()
        );
        for matrix in Matrix::all(&self.cases) {
            let _ = write!(
                text,
                "\n{} the detectable size:\n\n```text\n{matrix}```\n",
                matrix.size
            );
        }
        text.push_str(
            "\n## Wrong answers\n\n| case | kind | missing | said |\n|---|---|---|---|\n",
        );
        for score in &self.cases {
            if let Some(why) = score.wrong() {
                let _ = writeln!(
                    text,
                    "| {} | {} | {} | {} |",
                    score.case,
                    score.kind.name(),
                    what(score),
                    why.replace('|', "/")
                );
            }
        }
        text
    }

    /// Verdicts by kind of case.
    fn verdicts(&self) -> String {
        const ALL: [Verdict; 5] = [
            Verdict::Complete,
            Verdict::Explained,
            Verdict::Partly,
            Verdict::Ambiguous,
            Verdict::Unknown,
        ];
        let mut counts: BTreeMap<Kind, [usize; 6]> = BTreeMap::new();
        for score in &self.cases {
            let at = ALL.iter().position(|&one| score.verdict == Some(one));
            counts.entry(score.kind).or_default()[at.unwrap_or(ALL.len())] += 1;
        }
        let mut text = format!("{:<12}", "verdict");
        for verdict in ALL {
            let _ = write!(text, "{:>11}", verdict_name(verdict));
        }
        text.push_str("     failed\n");
        for (kind, counts) in counts {
            let _ = write!(text, "{:<12}", kind.name());
            for count in counts {
                let _ = write!(text, "{count:>11}");
            }
            text.push('\n');
        }
        text
    }

    /// Parameters of right findings that the truth does not know, each once.
    fn not_compared(&self) -> Option<String> {
        let mut names: Vec<String> = (self.cases.iter().flat_map(|score| &score.parameters))
            .filter(|parameter| parameter.holds.is_none())
            .map(|parameter| format!("{}.{}", parameter.mechanism, parameter.name))
            .collect();
        names.sort();
        names.dedup();
        (!names.is_empty()).then(|| names.join(", "))
    }
}

/// What is missing in a case, with its size.
fn what(score: &Score) -> String {
    if score.truth.is_empty() {
        return "nothing".to_owned();
    }
    let each = score.truth.iter().zip(&score.times_ideal);
    let each: Vec<String> = each
        .map(|(what, times)| format!("{what} x {times:.3}"))
        .map(|text| text.trim_end_matches('0').trim_end_matches('.').to_owned())
        .collect();
    each.join(", ")
}
