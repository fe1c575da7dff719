//! Where discs without an index stand when recordings begin, one against the other.
//!
//! The twin says at which angle its shaft starts, and between two edges that is sure to half a step. A disc whose errors are larger
//! than that is out by lines; then it fits none of the other recordings. What the recordings show of it says by how many.

use rayon::prelude::*;

use super::prepare::seen;
use super::run::Recorded;
use super::seen::Seen;

/// Lines to either side that a start may be out by.
const LINES: i64 = 4;
/// Part of the difference that the right number of lines leaves at the most.
const LEFT: f64 = 0.25;

/// Counts the places of recordings without an index from where their twins start, and one like the other.
pub fn counted(rig: &mut [Recorded]) {
    for one in rig.iter_mut().filter(|one| !one.track.anchored) {
        one.track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    let known = |one: &Recorded| !one.track.anchored && one.twin.shaft.initial_angle_rad != 0.0;
    if rig.len() < 2 || !rig.iter().all(known) {
        return;
    }
    let shown: Vec<Option<Vec<f64>>> = rig
        .par_iter()
        .map(|one| seen(one).ok().and_then(|seen| shown(&seen)))
        .collect();
    let Some(Some(first)) = shown.first() else {
        return;
    };
    for (one, other) in rig.iter_mut().zip(&shown).skip(1) {
        if let Some(other) = other.as_ref().filter(|other| other.len() == first.len()) {
            one.track.origin += one.track.classes * lines(first, other, one.track.classes);
        }
    }
}

/// The mean angle of each edge of the disc less that of all; none where edges are missing.
fn shown(seen: &Seen) -> Option<Vec<f64>> {
    let edges = usize::try_from(seen.edges).ok()?;
    let (mut sums, mut counts) = (vec![0.0; edges], vec![0.0; edges]);
    for (at, angle) in seen.angles.iter().enumerate() {
        sums[seen.edge(at)] += angle;
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
