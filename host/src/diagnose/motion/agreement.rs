//! How well a shaft that sticks and slips agrees with its twin.
//!
//! Torque noise moves the phase of the limit cycle, so edges are compared slip by slip: each slip's instant of breaking away and its
//! place of rest are its own, all else is the law's. A twin that does not stick goes on steadily through each slip. The floor is what
//! slips differ by among each other, and what they have in common says whether the law leaves more than that ([`super::scatter`]).

use super::cycles::cycles;
use super::scatter::Scatter;
use super::slip_fit::{Cycle, FREE, off, placed};
use super::slip_law::Law;
use crate::diagnose::board::{FITTED, PARTS};
use crate::diagnose::diagnosis::{Fit, HeldOut};
use crate::diagnose::run::Recorded;
use crate::diagnose::shown::{FindingPlot, Line, RecordingPlot};
use crate::mechanism::Mechanism;

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
    /// Edges that were compared.
    pub edges: usize,
}

/// One slip compared.
struct Compared {
    /// Times of its edges, s from the recording's clock zero.
    times_s: Vec<f64>,
    /// Time of its breaking away, s.
    from_s: f64,
    /// Way from its first edge to its last, rad.
    way_rad: f64,
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Part of a slip's way to which its law is worked out.
const ACCURACY: f64 = 1e-5;

/// Compares all recordings with laws, one for each, that were found from all slips, and later slips with that from the earlier ones.
/// `given` are the laws of the twins as they were, where they stick.
#[must_use]
pub fn agreement(
    rig: &[Recorded],
    laws: &[Law],
    early: Option<&Law>,
    given: Option<&[Law]>,
) -> Agreement {
    let part = FITTED as f64 / PARTS as f64;
    let mut all: Vec<Vec<Compared>> = Vec::new();
    let mut late = Vec::new();
    for (at, (one, law)) in rig.iter().zip(laws).enumerate() {
        let given = given.and_then(|given| given.get(at));
        all.push(compared(one, law, given, 0.0));
        let early = early.map(|early| compared(one, early, given, part));
        late.extend(early.into_iter().flatten());
    }
    let before = |one: &Compared| squares(&one.before);
    let after = |one: &Compared| squares(&one.after);
    let every = || all.iter().flatten();
    let rows = || every().map(|one| one.after.as_slice());
    let accuracy_rad = ACCURACY * usual_way(every());
    let scatter = Scatter::of(rows(), accuracy_rad);
    let floor = scatter.map(|scatter| scatter.floor_rad());
    let held_out = HeldOut {
        rms_before_rad: rms(late.iter(), before),
        rms_after_rad: rms(late.iter(), after),
        floor_rad: floor,
        reducible_removed: None,
    };
    let earlier = every().map(|one| one.before.as_slice());
    let fit = Fit {
        rms_before_rad: rms(every(), before),
        rms_after_rad: rms(every(), after),
        floor_rad: floor,
        whiteness_p_before: scatter.and_then(|scatter| scatter.p(earlier)),
        whiteness_p: scatter.and_then(|scatter| scatter.p(rows())),
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
        edges: every().map(|one| one.after.len()).sum(),
    }
}

/// Way of the usual slip, rad.
fn usual_way<'a>(slips: impl Iterator<Item = &'a Compared>) -> f64 {
    let mut ways: Vec<f64> = slips.map(|one| one.way_rad).collect();
    ways.sort_by(f64::total_cmp);
    ways.get(ways.len() / 2).copied().unwrap_or(0.0)
}

/// A slide that breaks away once: nothing is left to judge it on.
#[must_use]
pub fn once(times_s: &[f64], before: &[f64], after: &[f64]) -> Agreement {
    let slide = Compared {
        times_s: times_s.to_vec(),
        from_s: times_s.first().copied().unwrap_or(0.0),
        way_rad: 0.0,
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
        edges: slide.after.len(),
    }
}

/// Slips from a share of the recording on.
fn compared(one: &Recorded, law: &Law, given: Option<&Law>, from: f64) -> Vec<Compared> {
    let Some(slips) = slips(one) else {
        return Vec::new();
    };
    let cycles = cycles(one, &slips).unwrap_or_default();
    let from = (from * cycles.len() as f64).ceil() as usize;
    let later = cycles.iter().skip(from);
    later.filter_map(|cycle| slip(cycle, law, given)).collect()
}

/// What a law leaves of a slip, rad, and when it breaks away, s from the first edge.
fn left(cycle: &Cycle, law: &Law) -> Option<(Vec<f64>, f64)> {
    let fitted = placed(cycle, law.logs, law.pull_rad_s, law.damping)?;
    let at: [f64; FREE] = fitted.at;
    let left = off(cycle, &at, law.pull_rad_s, law.damping)?;
    Some((left.iter().map(|left| -left).collect(), at[3]))
}

fn slip(cycle: &Cycle, law: &Law, given: Option<&Law>) -> Option<Compared> {
    let (after, from_s) = left(cycle, law)?;
    let steady = || {
        let each = cycle.ways.iter().zip(&cycle.times_s);
        let each = each.map(|(way, time)| way - law.pull_rad_s * time);
        level(&each.collect::<Vec<f64>>())
    };
    Some(Compared {
        times_s: cycle
            .times_s
            .iter()
            .map(|time| cycle.start_s + time)
            .collect(),
        from_s: cycle.start_s + from_s,
        way_rad: cycle.ways.last().copied().unwrap_or(0.0),
        before: match given {
            Some(given) => left(cycle, given)?.0,
            None => steady(),
        },
        after,
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
