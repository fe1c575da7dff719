//! Where discs without an index stand when recordings begin, one against the other.
//!
//! The twin says at which angle its shaft starts, and between two edges that is sure to half a step. A disc whose errors are larger
//! than that is out by lines; then it fits none of the other recordings. What the recordings show of it says by how many. Where the
//! twin does not say, the errors of the disc's lines do: they are as good as an index where they show clearly.

use std::iter;
use std::ops::Range;

use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::prepare::seen;
use super::run::Recorded;
use super::seen::Seen;
use crate::twin::Errors;

/// Lines to either side that a start may be out by.
const LINES: i64 = 4;
/// Part of the difference that the right number of lines leaves at the most.
const LEFT: f64 = 0.25;
/// What goes round less often than once in so many lines may be the shaft's motion.
const SLOW: usize = 8;
/// Evidence for a start that nobody gave, as Schwarz's criterion counts it.
const SURE: f64 = 50.0;

/// Counts the places of recordings without an index from where their twins start, and one like the other.
pub fn counted(rig: &mut [Recorded]) {
    for one in rig.iter_mut().filter(|one| !one.track.anchored) {
        one.track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    if rig.iter().any(|one| one.track.anchored) {
        return;
    }
    if rig.iter().any(|one| one.start_rad().is_none()) {
        found(rig);
    } else if rig.len() > 1 {
        corrected(rig);
    }
}

/// Starts that are out by a few lines are put right.
fn corrected(rig: &mut [Recorded]) {
    let all = rig.par_iter().map(|one| {
        let seen = seen(one).ok()?;
        shown(&seen, 0..seen.len())
    });
    let shown: Vec<Option<Vec<f64>>> = all.collect();
    let Some(Some(first)) = shown.first() else {
        return;
    };
    for (one, other) in rig.iter_mut().zip(&shown).skip(1) {
        if let Some(other) = other.as_ref().filter(|other| other.len() == first.len()) {
            one.track.origin += one.track.classes * lines(first, other, one.track.classes);
        }
    }
}

/// Starts that nobody knows are found by the disc: the twin's, else as one recording shows it. Where one of them can't be, all stay as
/// they are.
fn found(rig: &mut [Recorded]) {
    let shown: Option<Vec<Vec<f64>>> = rig.par_iter().map(clearly_shown).collect();
    let (Some(shown), Ok(given)) = (shown, seen(&rig[0])) else {
        return;
    };
    let first = rig
        .iter()
        .position(|one| one.start_rad().is_some())
        .unwrap_or(0);
    // A disc that one recording alone shows begins wherever it likes.
    let by_first = (rig.len() > 1).then_some((Some(first), &shown[first]));
    let mut models = iter::once((None, &given.errors)).chain(by_first);
    let lines = models.find_map(|(own, model)| {
        let each = rig.iter().zip(&shown).enumerate();
        let each = each.map(|(at, (one, shown))| {
            if one.start_rad().is_some() || own == Some(at) {
                Some(0)
            } else {
                same_disc(model, shown, one.track.classes)
            }
        });
        each.collect::<Option<Vec<i64>>>()
    });
    for (one, lines) in rig.iter_mut().zip(lines.into_iter().flatten()) {
        if one.start_rad().is_none() {
            one.track.origin += lines * one.track.classes;
            one.twin.shaft.initial_angle_rad = one.track.start_rad().unwrap_or(0.0);
        }
    }
}

/// The disc as a recording shows it in both of its halves; none where they differ, as noise does.
fn clearly_shown(one: &Recorded) -> Option<Vec<f64>> {
    let seen = seen(&without_disc(one)).ok()?;
    let half = seen.len() / 2;
    let (early, late) = (shown(&seen, 0..half)?, shown(&seen, half..seen.len())?);
    let stays = same_disc(&early, &late, one.track.classes) == Some(0);
    stays.then(|| shown(&seen, 0..seen.len()))?
}

/// A recording beside a twin that knows nothing of what belongs to places of its turn.
fn without_disc(one: &Recorded) -> Recorded {
    let mut bare = one.clone();
    let twin = &mut bare.twin;
    twin.errors = Errors::default();
    twin.ripple.clear();
    twin.gear_mesh.clear();
    twin.bearing.clear();
    bare
}

/// The mean angle of each edge of the disc, among some of a recording's, less that of all; none where edges are missing.
fn shown(seen: &Seen, among: Range<usize>) -> Option<Vec<f64>> {
    let edges = usize::try_from(seen.edges).ok()?;
    let (mut sums, mut counts) = (vec![0.0; edges], vec![0.0; edges]);
    for at in among {
        sums[seen.edge(at)] += seen.angles[at];
        counts[seen.edge(at)] += 1.0;
    }
    if counts.contains(&0.0) {
        return None;
    }
    let means = sums.iter().zip(&counts).map(|(sum, count)| sum / count);
    let means: Vec<f64> = means.collect();
    let all = means.iter().sum::<f64>() / edges as f64;
    Some(means.iter().map(|mean| mean - all).collect())
}

/// Lines by which a disc has to go on to be like another; 0 unless that is clearly so.
fn lines(first: &[f64], other: &[f64], classes: i64) -> i64 {
    let edges = first.len() as i64;
    let apart = |lines: i64| -> f64 {
        let each = first.iter().enumerate().map(|(edge, first)| {
            let there = (edge as i64 - lines * classes).rem_euclid(edges) as usize;
            (first - other[there]).powi(2)
        });
        each.sum()
    };
    let best = (-LINES..=LINES).min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
    best.filter(|best| apart(*best) < LEFT * apart(0))
        .unwrap_or(0)
}

/// Lines by which a disc has to go on to be a model's; none unless one number of lines is clearly better than all others. What the shaft
/// does once a turn and a few times is left out: it is not the same at every speed.
fn same_disc(model: &[f64], other: &[f64], classes: i64) -> Option<i64> {
    let edges = model.len();
    let classes = usize::try_from(classes).ok()?;
    let lines = edges / classes;
    if other.len() != edges || lines < 2 {
        return None;
    }
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(edges);
    let spectrum = |row: &[f64]| {
        let mut output = forward.make_output_vec();
        let _ = forward.process(&mut row.to_vec(), &mut output);
        output
    };
    let (model, other) = (spectrum(model), spectrum(other));
    let kept = |order: usize| {
        let within = order % lines;
        SLOW * within.min(lines - within) > lines && 2 * order < edges
    };
    let orders: Vec<usize> = (0..model.len()).filter(|order| kept(*order)).collect();
    let squares = |row: &[Complex<f64>]| orders.iter().map(|m| row[*m].norm_sqr()).sum::<f64>();
    let most = (squares(&model) * squares(&other)).sqrt();
    let mut product = vec![Complex::default(); model.len()];
    for order in &orders {
        product[*order] = model[*order] * other[*order].conj() / most;
    }
    let inverse = planner.plan_fft_inverse(edges);
    let mut alike = inverse.make_output_vec();
    inverse.process(&mut product, &mut alike).ok()?;
    // Twice the logarithm of the likelihood that they are alike, by the correlation of so many numbers; both sides of the spectrum count.
    let numbers = 2.0 * orders.len() as f64;
    let score = |line: &usize| {
        let alike = (0.5 * alike[line * classes]).clamp(0.0, 1.0 - f64::EPSILON);
        -numbers * (-alike * alike).ln_1p()
    };
    let best = (0..lines).max_by(|a, b| score(a).total_cmp(&score(b)))?;
    let second = (0..lines)
        .filter(|line| *line != best)
        .map(|line| score(&line));
    let clear = score(&best) - second.fold(0.0, f64::max) > SURE;
    clear.then_some(best as i64)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::lines;
    use crate::diagnose::track::Track;
    use crate::sensor::{PlanError, SensorKind, SensorPlan};
    use crate::sim::Simulation;
    use crate::twin::Twin;

    #[test]
    fn a_wheel_that_starts_on_a_tooth_is_counted_from_its_fall() {
        for start in [0.5, 1.5, 2.5, 37.5] {
            let angle = start * TAU / 60.0;
            let text = format!(
                "duration = {{ turns = 4.0 }}\n[encoder.wheel]\nteeth = 30\n[drive.constant]\nr_min = 60.0\n\
                 [timer]\nclock_hz = 100000000\n\
                 [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\ninitial_angle_rad = {angle:e}\n"
            );
            let twin = Twin::parse(&text, "wheel").unwrap();
            let rows = Simulation::new(&twin).unwrap();
            let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
            let kind = SensorKind::Wheel {
                both_edges: true,
                missing: 0,
            };
            let plan = SensorPlan { kind, lines: 30 };
            let mut track = Track::of(plan, twin.timer.clock_hz, rows).unwrap();
            track.starts_at(twin.shaft.initial_angle_rad);
            let first = track.stretches[0].marks[0].place + track.origin;
            assert_eq!(first, start.ceil() as i64, "from {start}");
        }
    }

    fn wavy(edge: usize) -> f64 {
        let turn = std::f64::consts::TAU * edge as f64 / 60.0;
        (2.0 * turn).sin() + 0.4 * (7.0 * turn).cos()
    }

    #[test]
    fn a_disc_that_started_two_lines_back_is_moved_on() {
        let first: Vec<f64> = (0..60).map(wavy).collect();
        let other: Vec<f64> = (0..60).map(|edge| wavy(edge + 4)).collect();
        assert_eq!(lines(&first, &other, 2), 2);
    }

    #[test]
    fn discs_that_do_not_fit_anyhow_stay() {
        let first: Vec<f64> = (0..60).map(wavy).collect();
        let other: Vec<f64> = (0..60).map(|edge| wavy(37 * edge % 60)).collect();
        assert_eq!(lines(&first, &other, 2), 0);
    }
}
