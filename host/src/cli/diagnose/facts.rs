//! What `quadcal diagnose` prints.

use crate::cli::output::Facts;
use crate::diagnose::diagnosis::{Diagnosis, Finding, Fit, RecordingFacts};
use crate::report::si;
use crate::reports::diagnose::recordings::speed;
use crate::reports::diagnose::words;

/// The result as text for people.
pub(super) fn facts(diagnosis: &Diagnosis) -> Facts {
    let mut facts = Facts::default();
    let verdict = diagnosis.verdict;
    facts.push(
        "Verdict",
        format!(
            "{}: {}",
            words::verdict_id(verdict),
            words::meaning(verdict)
        ),
    );
    if !diagnosis.summary.trim().is_empty() {
        facts.push("", words::headline(diagnosis));
    }
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        finding_facts(&mut facts, index + 1, finding);
        // That of the whole diagnosis comes below.
        let next = finding.next_recording.as_ref();
        if let Some(next) = next.filter(|next| diagnosis.next_recording.as_ref() != Some(*next)) {
            facts.push("  record next", words::next(next));
        }
    }
    fit_facts(&mut facts, diagnosis, &diagnosis.fit);
    if let Some(next) = &diagnosis.next_recording {
        facts.push("Record next", words::next(next));
    }
    for recording in &diagnosis.recordings {
        facts.push("Recording", read(recording));
    }
    facts
}

fn finding_facts(facts: &mut Facts, number: usize, finding: &Finding) {
    facts.push(
        format!("Finding {number}"),
        format!(
            "{}, confidence {}",
            words::named(finding.mechanism),
            words::confidence(finding)
        ),
    );
    facts.push("  where", &finding.text);
    for (name, parameter) in &finding.parameters {
        facts.push(format!("  {name}"), words::with_interval(parameter));
    }
    for (index, (against, result)) in words::evidence(&finding.evidence).iter().enumerate() {
        let name = if index == 0 { "  evidence" } else { "" };
        facts.push(name, format!("{against}: {result}"));
    }
    if !finding.look_alikes.is_empty() {
        let names = finding.look_alikes.iter().copied().map(words::named);
        let names: Vec<String> = names.collect();
        facts.push("  looks the same", words::list(&names));
    }
}

fn fit_facts(facts: &mut Facts, diagnosis: &Diagnosis, fit: &Fit) {
    let found = words::mended(diagnosis);
    let rms = |before: Option<f64>, after: Option<f64>, floor: Option<f64>| {
        let mut text = si(before?, "rad");
        if found {
            text += &format!(" before, {} after", si(after?, "rad"));
        }
        if let Some(floor) = floor {
            text += &format!(", noise alone {}", si(floor, "rad"));
        }
        Some(text)
    };
    let held = &fit.held_out;
    if let Some(text) = rms(fit.rms_before_rad, fit.rms_after_rad, fit.floor_rad) {
        facts.push(words::residual(fit), text);
    }
    if let Some(mut text) = rms(held.rms_before_rad, held.rms_after_rad, held.floor_rad) {
        if let Some(percent) = words::removed(diagnosis) {
            text += &format!("; {percent:.1} % foretold of what the findings can explain there");
        }
        facts.push(
            format!("  on {} not fitted on", words::judged_on(fit)),
            text,
        );
    }
    for (name, band) in words::bands(fit).into_iter().filter(|_| found) {
        let text = rms(band.rms_before_rad, band.rms_after_rad, band.floor_rad);
        if let Some(text) = text.filter(|_| words::changes(band)) {
            facts.push(format!("  {name}"), text);
        }
    }
    if let Some(text) = words::is_noise(fit, found, ["before", "after"]) {
        facts.push("  is noise, probability", text);
    }
}

#[allow(clippy::cast_precision_loss)]
fn read(recording: &RecordingFacts) -> String {
    let mut text = format!(
        "{} against {}: {} edges in {:.1} turns, {} at {}; {}angles from {}",
        recording.file,
        recording.twin,
        recording.edges,
        recording.turns,
        si(recording.seconds, "s"),
        speed(recording.speed_r_min),
        recording
            .stamp_rms_s
            .map_or_else(String::new, |stamp| format!(
                "time stamps to {}, ",
                si(stamp, "s")
            )),
        match recording.start_rad {
            _ if recording.anchored => "the index".to_owned(),
            Some(start) => format!("its start at {:.1} degrees", start.to_degrees()),
            None => "the first edge".to_owned(),
        }
    );
    if !recording.disturbed_s.is_empty() {
        let times = recording.disturbed_s.len();
        let plural = if times == 1 { "" } else { "s" };
        text += &format!("; count disturbed at {times} instant{plural}");
    }
    text
}

#[cfg(test)]
mod tests;
