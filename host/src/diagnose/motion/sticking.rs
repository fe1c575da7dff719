//! A twin whose own motion sticks and slips, held against its recordings slip by slip.
//!
//! Torque noise makes the instants of breaking away those of another run altogether, so the twin's course says nothing of a recording's
//! edges. What the slips have in common does: their law, found from the recording and from runs of the twin in the same way, with
//! standard errors from how the slips scatter, is compared number by number by B. L. Welch's t (Biometrika 34, 1947), and what the
//! twin's own law leaves of the recording's slips by [`super::scatter`].

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::MotionFinding;
use super::agreement::{Agreement, agreement};
use super::rests::{SLIPS_LEAST, whole_slips};
use super::scatter::{normal, upper};
use super::slip_law::Law;
use super::stick_slip::{Left, Seen, again, cycle_after_cycle, dampings, of_all};
use crate::diagnose::run::{DiagnoseError, Recorded};
use crate::mechanism::Mechanism;
use crate::twin::{Drive, Duration, Twin};

/// Runs of the twin that a recording is compared with.
const RUNS: u64 = 4;
/// Probability below which slips are none of the twin's: one diagnosis in many tests a few numbers.
const CHANCE: f64 = 1e-6;
/// Turns that a shaft which does not stick has to make for anything else to be told.
const TURNS_LEAST: f64 = 3.0;
/// Part by which the drive's speed may be another.
const SPEED: f64 = 0.1;

/// What a rig whose twins stick and slip is against them.
#[derive(Clone, Debug)]
pub enum Sticking {
    /// It sticks and slips as they do.
    Alike(Agreement),
    /// It sticks and slips in another way.
    Otherwise(MotionFinding, Agreement),
    /// It does not stick.
    Not(MotionFinding),
}

/// Compares recordings with twins that stick and slip; none where the twins do not.
///
/// # Errors
/// [`DiagnoseError`] where a recording is too short to say, or its drive is another.
pub fn against(rig: &[Recorded]) -> Result<Option<Sticking>, DiagnoseError> {
    let constant = |one: &Recorded| matches!(one.twin.drive, Drive::Constant { .. });
    if rig.is_empty()
        || !rig
            .iter()
            .all(|one| one.twin.stick_slip.is_some() && constant(one))
    {
        return Ok(None);
    }
    let runs: Option<Vec<Vec<Seen>>> = rig.par_iter().map(runs).collect();
    let Some(runs) = runs else {
        return Ok(None);
    };
    let each = rig
        .par_iter()
        .map(|one| cycle_after_cycle(one, [damping(&one.twin); 2]));
    let seen: Vec<Option<Seen>> = each.collect();
    for ((one, seen), runs) in rig.iter().zip(&seen).zip(&runs) {
        if seen.is_none() {
            short(one, runs)?;
        }
    }
    let found: Vec<(usize, Seen)> = seen
        .into_iter()
        .enumerate()
        .filter_map(|(at, seen)| Some((at, seen?)))
        .collect();
    if found.len() < rig.len() {
        return not(rig, &runs).map(Some);
    }
    let mut given = Vec::new();
    for ((one, (_, seen)), runs) in rig.iter().zip(&found).zip(&runs) {
        given.push(law_of(one, seen, runs)?);
    }
    let alike = agreement(rig, &given, None, Some(&given));
    let differs = found
        .iter()
        .zip(&runs)
        .any(|((_, seen), runs)| differs(seen, runs));
    if !differs && alike.fit.whiteness_p.is_none_or(|p| p > CHANCE) {
        return Ok(Some(Sticking::Alike(alike)));
    }
    let Some((mut finding, best)) = of_all(rig, &found) else {
        return Ok(None);
    };
    let Left::Cycles { law, early } = &best.left else {
        return Ok(None);
    };
    let agreement = agreement(rig, &vec![*law; rig.len()], early.as_ref(), Some(&given));
    finding.delta_bic = evidence(&agreement);
    finding.text = format!(
        "{} The twin sticks and slips otherwise: {}.",
        finding.text,
        usual(&runs[0])
    );
    Ok(Some(Sticking::Otherwise(finding, agreement)))
}

/// What runs of a recording's twin show; none where it does not stick again and again.
fn runs(one: &Recorded) -> Option<Vec<Seen>> {
    // What turns on has its three turns; a twin of less may only be too short to stick often.
    let longer: &[f64] = if one.track.turns() < TURNS_LEAST {
        &[1.0, 4.0, 16.0]
    } else {
        &[1.0]
    };
    longer.iter().find_map(|factor| {
        let twin = Twin {
            duration: match one.twin.duration {
                Duration::Turns(turns) => Duration::Turns(factor * turns),
                Duration::Seconds(seconds) => Duration::Seconds(factor * seconds),
            },
            ..one.twin.clone()
        };
        let each = (1..=RUNS).into_par_iter().map(|seed| {
            let run = again(one, &twin, seed)?;
            cycle_after_cycle(&run, [damping(&twin); 2])
        });
        each.collect()
    })
}

/// The damping of a twin with a spring, whose drive pulls towards the speed beside it if it is stiff.
fn damping(twin: &Twin) -> (bool, f64) {
    dampings(twin)[1]
}

/// Whether a recording has slips, but too few to say anything.
fn short(one: &Recorded, runs: &[Seen]) -> Result<(), DiagnoseError> {
    let slips = whole_slips(one);
    let (begin, end) = (
        one.track.stretches.first().and_then(|s| s.marks.first()),
        one.track.end_s(),
    );
    let seconds = end
        .zip(begin)
        .map_or(0.0, |(end, begin)| end - begin.time_s);
    let period_s = runs.iter().map(|run| run.period_s).fold(0.0, f64::max);
    let needed = SLIPS_LEAST + 2;
    if seconds < needed as f64 * period_s || (1..SLIPS_LEAST).contains(&slips) {
        return Err(DiagnoseError::FewSlips {
            file: one.file.clone(),
            twin: one.twin.name.clone(),
            slips,
            needed,
            seconds: (needed + 1) as f64 * period_s,
        });
    }
    Ok(())
}

/// Some recording does not stick as its twin does.
fn not(rig: &[Recorded], runs: &[Vec<Seen>]) -> Result<Sticking, DiagnoseError> {
    let usual = usual(&runs[0]);
    let other = |one: &Recorded, why: String| DiagnoseError::OtherMotion {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        why,
    };
    for one in rig {
        let slips = whole_slips(one);
        if slips >= SLIPS_LEAST {
            let why = format!(
                "the twin sticks and slips, {usual}; the recording stands {} times, but not as a spring behind friction",
                slips + 1
            );
            return Err(other(one, why));
        }
        if one.track.turns() < TURNS_LEAST {
            let why = format!(
                "the twin sticks and slips, {usual}; the recording turns on, {:.2} turns of it",
                one.track.turns()
            );
            return Err(other(one, why));
        }
    }
    let even = |one: &Recorded| {
        let mut twin = one.twin.clone();
        twin.stick_slip = None;
        twin.shaft.stribeck_n_m = 0.0;
        twin
    };
    Ok(Sticking::Not(MotionFinding {
        mechanism: Mechanism::StickSlip,
        parameters: vec![("stribeck_n_m", 0.0, f64::INFINITY)],
        delta_bic: rig
            .iter()
            .map(|one| one.track.turns() * one.track.edges as f64)
            .sum(),
        text: format!(
            "The twin sticks and slips, {usual}, and the recording turns on evenly: friction that falls with speed, or the spring, is less."
        ),
        twins: rig.iter().map(even).collect(),
    }))
}

/// How runs stick and slip, in words.
fn usual(runs: &[Seen]) -> String {
    let period_s = runs.iter().map(|run| run.period_s).sum::<f64>() / runs.len().max(1) as f64;
    format!("one slip every {period_s:.3} s")
}

/// The law of a twin, pulled at the speed of its recording.
fn law_of(one: &Recorded, seen: &Seen, runs: &[Seen]) -> Result<Law, DiagnoseError> {
    let law = |seen: &Seen| match &seen.left {
        Left::Cycles { law, .. } => Some(*law),
        Left::Once(_) => None,
    };
    let pull = |seen: &Seen| law(seen).map_or(0.0, |law| law.pull_rad_s);
    let own = runs.iter().map(pull).sum::<f64>() / runs.len() as f64;
    let here = pull(seen);
    if (here / own - 1.0).abs() > SPEED {
        let r_min = |speed: f64| speed * 60.0 / TAU;
        return Err(DiagnoseError::OtherMotion {
            file: one.file.clone(),
            twin: one.twin.name.clone(),
            why: format!(
                "slips go on at {:.4} r/min on the whole, those of the twin at {:.4}",
                r_min(here),
                r_min(own)
            ),
        });
    }
    // As the slips of runs show it: torque noise breaks the shaft loose a little early, and their law is not quite the twin's.
    let logs = std::array::from_fn(|i| {
        let each = runs.iter().filter_map(law).map(|law| law.logs[i]);
        each.sum::<f64>() / runs.len() as f64
    });
    Ok(Law {
        logs,
        errors: [0.0; 3],
        pull_rad_s: here,
        damping: damping(&one.twin).1,
    })
}

/// Whether some number of a recording's slips is none of the twin's.
fn differs(seen: &Seen, runs: &[Seen]) -> bool {
    let count = runs.len() as f64;
    let numbers = |seen: &Seen| [seen.spring.ln(), seen.drop.ln(), seen.over_rad_s.ln()];
    (0..3).any(|i| {
        let own: Vec<f64> = runs.iter().map(|run| numbers(run)[i]).collect();
        let mean = own.iter().sum::<f64>() / count;
        let scatter = own.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let told = runs.iter().map(|run| run.errors[i].powi(2)).sum::<f64>() / count;
        let error = seen.errors[i].hypot((scatter.max(told) / count).sqrt());
        let off = (numbers(seen)[i] - mean).abs();
        // What is worked out no better than this is no difference.
        let deviations = normal(off / error.max(LEAST[i]), seen.slips as f64 - 1.0);
        2.0 * upper(deviations) < CHANCE
    })
}

/// Parts of spring, drop and speed that no recording tells.
const LEAST: [f64; 3] = [1e-5, 1e-5, 1e-3];

/// Schwarz's criterion of the twins' laws less that of the one found.
fn evidence(agreement: &Agreement) -> f64 {
    let fit = &agreement.fit;
    let squares =
        |rms: Option<f64>| rms.map_or(0.0, |rms| rms * rms + fit.floor_rad.unwrap_or(0.0).powi(2));
    let edges = agreement.edges as f64;
    let gain = (squares(fit.rms_before_rad) / squares(fit.rms_after_rad)).ln();
    if gain.is_finite() {
        edges * gain - 3.0 * edges.ln()
    } else {
        0.0
    }
}
