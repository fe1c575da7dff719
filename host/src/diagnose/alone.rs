//! A diagnosis of what stands for itself: a motion beside which nothing else can be told.

use super::beside::put_lost;
use super::diagnosis::{Diagnosis, Finding, RecordingFacts};
use super::motion::MotionFinding;
use super::motion::agreement::Agreement;
use super::run::{Diagnosed, Recorded};
use super::shown::Shown;
use super::tell;
use super::verdict::{Rest, more_than_noise, names, order, verdict};

/// The diagnosis of a motion; `findings` are all there are, the motion among them.
#[must_use]
pub fn alone(
    rig: &[Recorded],
    motion: MotionFinding,
    agreement: Agreement,
    mut findings: Vec<Finding>,
) -> Diagnosed {
    for finding in &mut findings {
        if finding.mechanism == motion.mechanism {
            finding.evidence.held_out_rms_ratio = agreement.held_out_ratio;
        }
    }
    let verdict = verdict(&findings);
    order(&mut findings, verdict);
    let mut twins = motion.twins;
    for (twin, one) in twins.iter_mut().zip(rig) {
        put_lost(twin, &one.track);
    }
    let rest = match Rest::of(&agreement.fit, true) {
        Rest::More(p) => format!("; {}", more_than_noise(p)),
        Rest::Noise | Rest::Hidden => String::new(),
    };
    Diagnosed {
        diagnosis: Diagnosis {
            version: 1,
            verdict,
            summary: format!(
                "The twin lacked: {}{rest}. Beside a shaft that does not turn evenly nothing smaller is looked for.",
                names(&findings)
            ),
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
        stamp_rms_s: None,
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    }
}
