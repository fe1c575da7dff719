//! How well a shaft that sticks and slips agrees with its twin.
//!
//! Torque noise moves the phase of the limit cycle, so edges are compared slip by slip: each slip's instant of breaking away and its
//! place of rest are its own, all else is the law's. The twin as given goes on steadily through each slip. The floor is what the same
//! comparison leaves of a run of the mended twin itself, with the noise that it declares, and slips of that run say whether what the
//! recording's slips leave is noise: the logarithms of their mean squares are held against each other (B. L. Welch, Biometrika 34, 1947).

use super::cycles::cycles;
use super::slip_fit::{Cycle, FREE, off, placed};
use super::slip_law::Law;
use crate::diagnose::board::{FITTED, PARTS};
use crate::diagnose::diagnosis::{Fit, HeldOut};
use crate::diagnose::run::Recorded;
use crate::diagnose::shown::{FindingPlot, Line, RecordingPlot};
use crate::diagnose::track::Track;
use crate::mechanism::Mechanism;
use crate::sensor::PlanError;
use crate::sim::Simulation;
use crate::twin::Twin;

use super::rests::slips;

/// Agreement of all recordings of a rig with their twins, before and after.
#[derive(Clone, Debug, Default)]
pub struct Agreement {
    /// In numbers.
    pub fit: Fit,
    /// The usual slip.
    pub plot: Option<FindingPlot>,
    /// Every recording's slips along time.
    pub recordings: Vec<RecordingPlot>,
    /// RMS on slips that were not fitted over what it was.
    pub held_out_ratio: Option<f64>,
}

/// One slip compared.
struct Compared {
    /// Times of its edges, s from the recording's clock zero.
    times_s: Vec<f64>,
    /// Time of its breaking away, s.
    from_s: f64,
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Compares all recordings with the law that was found from all slips, and later slips with that from the earlier ones.
#[must_use]
pub fn agreement(rig: &[Recorded], twins: &[Twin], law: &Law, early: Option<&Law>) -> Agreement {
    let part = FITTED as f64 / PARTS as f64;
    let mut all: Vec<Vec<Compared>> = Vec::new();
    let (mut late, mut noise) = (Vec::new(), Vec::new());
    for (one, twin) in rig.iter().zip(twins) {
        all.push(compared(one, law, 0.0));
        late.extend(
            early
                .into_iter()
                .flat_map(|early| compared(one, early, part)),
        );
        noise.extend(
            again(one, twin)
                .iter()
                .flat_map(|run| compared(run, law, 0.0)),
        );
    }
    let before = |one: &Compared| squares(&one.before);
    let after = |one: &Compared| squares(&one.after);
    let every = || all.iter().flatten();
    let floor = rms(noise.iter(), after);
    let held_out = HeldOut {
        rms_before_rad: rms(late.iter(), before),
        rms_after_rad: rms(late.iter(), after),
        floor_rad: floor,
        reducible_removed: None,
    };
    let fit = Fit {
        rms_before_rad: rms(every(), before),
        rms_after_rad: rms(every(), after),
        floor_rad: floor,
        whiteness_p_before: as_noise(every().map(before), noise.iter().map(after)),
        whiteness_p: as_noise(every().map(after), noise.iter().map(after)),
        held_out: HeldOut {
            reducible_removed: removed(&held_out),
            ..held_out
        },
        ..Fit::default()
    };
    let ratio = held_out.rms_after_rad.zip(held_out.rms_before_rad);
    Agreement {
        plot: usual(every().collect()),
        recordings: all.iter().map(|slips| along(slips)).collect(),
        held_out_ratio: ratio
            .map(|(after, before)| after / before)
            .filter(|ratio| ratio.is_finite()),
        fit,
    }
}

/// A slide that breaks away once: nothing is left to judge it on.
#[must_use]
pub fn once(times_s: &[f64], before: &[f64], after: &[f64]) -> Agreement {
    let slide = Compared {
        times_s: times_s.to_vec(),
        from_s: times_s.first().copied().unwrap_or(0.0),
        before: level(before),
        after: level(after),
    };
    Agreement {
        fit: Fit {
            rms_before_rad: rms([&slide].into_iter(), |one| squares(&one.before)),
            rms_after_rad: rms([&slide].into_iter(), |one| squares(&one.after)),
            ..Fit::default()
        },
        recordings: vec![along(std::slice::from_ref(&slide))],
        plot: usual(vec![&slide]),
        held_out_ratio: None,
    }
}

/// Slips from a share of the recording on.
fn compared(one: &Recorded, law: &Law, from: f64) -> Vec<Compared> {
    let Some(slips) = slips(one) else {
        return Vec::new();
    };
    let cycles = cycles(one, &slips).unwrap_or_default();
    let from = (from * cycles.len() as f64).ceil() as usize;
    let later = cycles.iter().skip(from);
    later.filter_map(|cycle| slip(cycle, law)).collect()
}

fn slip(cycle: &Cycle, law: &Law) -> Option<Compared> {
    let fitted = placed(cycle, law.logs, law.pull_rad_s, law.damping)?;
    let at: [f64; FREE] = fitted.at;
    let left = off(cycle, &at, law.pull_rad_s, law.damping)?;
    let steady = cycle.ways.iter().zip(&cycle.times_s);
    let steady: Vec<f64> = steady
        .map(|(way, time)| way - law.pull_rad_s * time)
        .collect();
    Some(Compared {
        times_s: cycle
            .times_s
            .iter()
            .map(|time| cycle.start_s + time)
            .collect(),
        from_s: cycle.start_s + at[3],
        before: level(&steady),
        after: left.iter().map(|left| -left).collect(),
    })
}

/// A run of the mended twin with other noise, read as its recording was; none where it can't be run.
fn again(one: &Recorded, twin: &Twin) -> Option<Recorded> {
    let other = Twin {
        seed: twin.seed.wrapping_add(1),
        ..twin.clone()
    };
    let rows = Simulation::new(&other)
        .ok()?
        .map(|event| Ok::<_, PlanError>(event.row));
    // Errors that the twin draws are those of its seed.
    Some(Recorded {
        file: one.file.clone(),
        plan: one.plan,
        track: Track::of(one.plan, twin.timer.clock_hz, rows).ok()?,
        twin: other,
    })
}

fn level(row: &[f64]) -> Vec<f64> {
    let mean = row.iter().sum::<f64>() / row.len().max(1) as f64;
    row.iter().map(|value| value - mean).collect()
}

/// Sum of squares of a slip and how many edges it has.
fn squares(row: &[f64]) -> (f64, f64) {
    (row.iter().map(|x| x * x).sum(), row.len() as f64)
}

fn rms<'a>(
    slips: impl Iterator<Item = &'a Compared>,
    part: impl Fn(&Compared) -> (f64, f64),
) -> Option<f64> {
    let (sum, count) = slips
        .map(part)
        .fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
    (count > 0.0).then(|| (sum / count).sqrt())
}

/// Share of the squares above the floor that went.
fn removed(held: &HeldOut) -> Option<f64> {
    let square = |value: Option<f64>| value.map(|rms| rms * rms);
    let (before, after) = (square(held.rms_before_rad)?, square(held.rms_after_rad)?);
    let floor = square(held.floor_rad)?;
    let share = (before - after.max(floor)) / (before - floor);
    (before > floor).then(|| share.clamp(0.0, 1.0))
}

/// Probability that slips of noise alone leave as much as these; none where there are too few.
fn as_noise(
    slips: impl Iterator<Item = (f64, f64)>,
    noise: impl Iterator<Item = (f64, f64)>,
) -> Option<f64> {
    let (mean, error2) = logs(slips)?;
    let (usual, its_error2) = logs(noise)?;
    let deviations = (mean - usual) / (error2 + its_error2).sqrt();
    let p = 0.5 * libm::erfc(deviations / std::f64::consts::SQRT_2);
    p.is_finite().then_some(p)
}

/// Mean of the logarithms of the mean squares, and its squared error.
fn logs(slips: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let all: Vec<f64> = slips.map(|(sum, count)| (sum / count).ln()).collect();
    let count = all.len() as f64;
    if all.len() < 3 {
        return None;
    }
    let mean = all.iter().sum::<f64>() / count;
    let scatter = all.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // Few slips know their own scatter badly.
    let widened = (1.0 + 1.5 / (count - 1.0)).powi(2);
    Some((mean, widened * scatter / count))
}

/// The slip of usual length, from its breaking away on.
fn usual(mut slips: Vec<&Compared>) -> Option<FindingPlot> {
    slips.sort_by_key(|slip| slip.times_s.len());
    let slip = slips.get(slips.len() / 2)?;
    let since = |row: &[f64]| -> Line {
        let each = slip.times_s.iter().zip(row);
        each.map(|(time, off)| (time - slip.from_s, 1e6 * off))
            .collect()
    };
    let made: Vec<f64> = slip
        .before
        .iter()
        .zip(&slip.after)
        .map(|(b, a)| b - a)
        .collect();
    Some(FindingPlot {
        mechanism: Mechanism::StickSlip,
        x_label: "time since the shaft broke away, s".to_owned(),
        y_label: "edges off the twin's course, urad".to_owned(),
        before: since(&slip.before),
        after: since(&slip.after),
        model: since(&made),
    })
}

/// Slips one after another, urad; thinned to what a plot shows.
fn along(slips: &[Compared]) -> RecordingPlot {
    const POINTS: usize = 4_000;
    let edges: usize = slips.iter().map(|slip| slip.times_s.len()).sum();
    let each = edges.div_ceil(POINTS).max(1);
    let line = |row: &dyn Fn(&Compared) -> Vec<f64>| -> Line {
        let rows = slips
            .iter()
            .flat_map(|slip| slip.times_s.iter().copied().zip(row(slip)));
        rows.step_by(each)
            .map(|(time, off)| (time, 1e6 * off))
            .collect()
    };
    RecordingPlot {
        before: line(&|slip| slip.before.clone()),
        after: line(&|slip| slip.after.clone()),
        ..RecordingPlot::default()
    }
}
