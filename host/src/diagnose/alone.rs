//! A diagnosis of what stands for itself: a motion beside which nothing else can be told.

use super::beside::{plain, put_lost};
use super::diagnosis::{Diagnosis, Finding, Fit, RecordingFacts, Verdict};
use super::motion::MotionFinding;
use super::motion::agreement::Agreement;
use super::run::{Diagnosed, Recorded};
use super::shown::Shown;
use super::tell;
use super::verdict::{Rest, more_than_noise, names, order, verdict};
use crate::mechanism::Mechanism;

/// Probability below which what slips leave is no noise.
const CHANCE: f64 = 1e-6;

/// The diagnosis of a motion, or of one that the twins have themselves; `findings` are all there are, the motion among them.
#[must_use]
pub fn alone(
    rig: &[Recorded],
    motion: Option<MotionFinding>,
    agreement: Agreement,
    mut findings: Vec<Finding>,
) -> Diagnosed {
    for finding in &mut findings {
        if motion
            .as_ref()
            .is_some_and(|motion| motion.mechanism == finding.mechanism)
        {
            finding.evidence.held_out_rms_ratio = agreement.held_out_ratio;
        }
    }
    findings.extend(nameless(&agreement));
    let verdict = verdict(&findings);
    order(&mut findings, verdict);
    let given = || rig.iter().map(|one| one.twin.clone()).collect();
    let mut twins = motion.map_or_else(given, |motion| motion.twins);
    for (twin, one) in twins.iter_mut().zip(rig) {
        put_lost(twin, &one.track);
    }
    Diagnosed {
        diagnosis: Diagnosis {
            version: 1,
            verdict,
            summary: summary(verdict, &findings, &agreement.fit),
            recordings: rig.iter().map(facts).collect(),
            fit: agreement.fit,
            next_recording: None,
            findings,
        },
        shown: Shown {
            findings: agreement.plot.into_iter().collect(),
            recordings: agreement.recordings,
        },
        error_lists: vec![None; twins.len()],
        twins,
    }
}

/// The verdict in a sentence or two.
fn summary(verdict: Verdict, findings: &[Finding], fit: &Fit) -> String {
    const NOTHING: &str = "Beside a shaft that does not turn evenly nothing smaller is looked for.";
    let names = names(findings);
    let rest = match Rest::of(fit, !findings.is_empty()) {
        Rest::More(p) => format!("; {}", more_than_noise(p)),
        Rest::Noise | Rest::Hidden => String::new(),
    };
    match verdict {
        Verdict::Complete => {
            format!("The recording sticks and slips as the twin does, slip by slip. {NOTHING}")
        }
        Verdict::Explained | Verdict::Ambiguous => {
            format!("The twin lacked: {names}{rest}. {NOTHING}")
        }
        Verdict::Partly => format!(
            "The twin lacked: {names}; something that all slips have in common is left. {NOTHING}"
        ),
        Verdict::Unknown => {
            format!("Slips differ from those of the twin in a way that has no name. {NOTHING}")
        }
    }
}

/// What all slips have in common beside their law.
fn nameless(agreement: &Agreement) -> Option<Finding> {
    let fit = &agreement.fit;
    let p_value = fit.whiteness_p.filter(|p| *p < CHANCE)?;
    let (after, floor) = (fit.rms_after_rad?, fit.floor_rad?);
    let over = (after * after - floor * floor).max(0.0).sqrt();
    let text = format!(
        "all slips alike are off their law by {over:.3e} rad RMS, more than they differ by"
    );
    let delta_bic = agreement.edges as f64 * (after / floor).ln().max(0.0);
    let mut finding = plain(Mechanism::Unknown, text, delta_bic);
    finding.evidence.p_value = p_value;
    Some(finding)
}

fn facts(one: &Recorded) -> RecordingFacts {
    let stretches = &one.track.stretches;
    let edges: usize = stretches.iter().map(|s| s.marks.len()).sum();
    let first = stretches.iter().filter_map(|s| s.marks.first());
    let begin = first.map(|mark| mark.time_s).reduce(f64::min);
    let end = one.track.end_s();
    RecordingFacts {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        edges: edges as u64,
        turns: one.track.turns(),
        seconds: end.zip(begin).map_or(0.0, |(end, begin)| end - begin),
        speed_r_min: [one.twin.drive.nominal_rad_s() * tell::R_MIN; 2],
        anchored: one.track.anchored,
        start_rad: one.start_rad(),
        stamp_rms_s: None,
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    }
}
