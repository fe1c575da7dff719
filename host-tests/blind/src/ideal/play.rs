//! What a play shows in a run that reverses.

use super::passed::Passed;
use super::project;
use crate::effect::Effect;
use crate::rig::{Profile, Rig};
use crate::turning::Course;

/// Whether an effect is a play and a drive reverses, so that the play shows.
#[must_use]
pub fn shows_play(effect: &Effect, rigs: &[Rig]) -> bool {
    let reverses =
        |rig: &Rig| matches!(rig.profile, Profile::Ramp { from, to, .. } if from * to < 0.0);
    effect.play_rad() != 0.0 && rigs.iter().any(reverses)
}

/// d' of the play of `effects` in runs as they were recorded, torque noise and all.
///
/// The signal is half the play, by direction, at the edges really passed: those that the play keeps from being passed say nothing,
/// and those near the turn, where the shaft's way is short and its noise small, nearly all. A play leaves the shaft's course as it
/// is, so nothing else differs.
#[must_use]
pub fn play(rigs: &[Rig], courses: &[Course], effects: &[Effect]) -> f64 {
    let half = 0.5 * effects.iter().map(Effect::play_rad).sum::<f64>();
    let signal = |course: &Course| -> Vec<f64> {
        let edges = course.crossings.iter().filter(|c| c.class.is_some());
        edges
            .map(|edge| if edge.forward { half } else { -half })
            .collect()
    };
    let signals: Vec<Vec<f64>> = courses.iter().map(signal).collect();
    let runs: Vec<Passed> = (rigs.iter().zip(courses))
        .map(|(rig, course)| Passed::recorded(rig, course, effects))
        .collect();
    let runs: Vec<&Passed> = runs.iter().collect();
    project::length(&project::residual(rigs, &runs, &signals))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::rig::Order;
    use crate::testing::plain;
    use crate::turning::turn;

    /// Turns round after 2.5 rad, at 20 rad/s^2.
    fn reversing() -> Rig {
        let profile = Profile::Ramp {
            from: 10.0,
            to: -10.0,
            over_s: 1.0,
        };
        Rig {
            profile,
            jitter_s: 1e-6,
            turns: 5.0 / std::f64::consts::TAU,
            ..plain()
        }
    }

    fn seen(rig: &Rig, play_rad: f64, seed: Option<u64>) -> (f64, Course) {
        let effects = [Effect::Hysteresis {
            angle_rad: play_rad,
        }];
        let course = turn(rig, &effects, seed);
        let rigs = std::slice::from_ref(rig);
        (play(rigs, std::slice::from_ref(&course), &effects), course)
    }

    #[test]
    fn with_white_stamps_alone_it_is_the_weighted_least_squares_of_the_edges_passed() {
        let rig = reversing();
        let size = 0.3 * rig.encoder.step_rad();
        let (distance, course) = seen(&rig, size, Some(3));
        let edges: Vec<_> = (course.crossings.iter())
            .filter(|c| c.class.is_some())
            .collect();
        let weight = |at: usize| 1.0 / (edges[at].speed * rig.stamp_rms_s());
        // Offset, speed, and speed as a share of the way: what no one knows beforehand.
        let columns = DMatrix::from_fn(edges.len(), 3, |at, column| {
            let angle = edges[at].place as f64 * rig.encoder.step_rad();
            weight(at) * [1.0, edges[at].time_s, angle][column]
        });
        let signal = DVector::from_fn(edges.len(), |at, _| {
            weight(at) * 0.5 * size * edges[at].speed.signum()
        });
        let q = columns.qr().q();
        let left = &signal - &q * (q.transpose() * &signal);
        let expected = left.norm();
        assert!(
            (distance / expected - 1.0).abs() < 1e-3,
            "{distance} {expected}"
        );
    }

    #[test]
    fn a_play_that_keeps_every_edge_after_the_turn_from_being_passed_says_nothing() {
        let mut rig = reversing();
        let step = rig.encoder.step_rad();
        // 2.5 rad on, and three steps back.
        rig.turns = (2.5 + 3.0 * step) / std::f64::consts::TAU;
        let (small, _) = seen(&rig, 0.5 * step, Some(3));
        let (large, course) = seen(&rig, 5.0 * step, Some(3));
        assert!(course.speeds.0 > 0.0, "{:?}", course.speeds);
        assert!(small > 100.0, "{small}");
        assert!(large < 1e-3, "{large}");
    }

    #[test]
    fn torque_noise_hides_it_by_the_way_it_turns_the_shaft_between_the_edges_beside_the_turn() {
        let mut rig = reversing();
        rig.jitter_s = 1e-9;
        rig.clock_hz = 1_000_000_000;
        let size = 0.3 * rig.encoder.step_rad();
        rig.noise_psd = 1e-3 * rig.inertia * rig.inertia;
        let (hidden, course) = seen(&rig, size, Some(4));
        let back = course.crossings.iter().position(|c| !c.forward).unwrap();
        let gap = course.crossings[back].time_s - course.crossings[back - 1].time_s;
        // A bridge of the angle with speeds known at both ends has an offset of variance q h^3 / 12 about the way between them; the
        // speeds must be had from edges on either side, that noise moves as well.
        let bound = size / (1e-3 * gap.powi(3) / 12.0).sqrt();
        assert!(hidden < bound && hidden > 0.1 * bound, "{hidden} {bound}");
    }

    #[test]
    fn estimates_from_noisy_runs_scatter_as_it_says() {
        let mut rig = reversing();
        // The speed forgets within a quarter of the time between the edges beside the turn.
        rig.stiffness = 40.0 * rig.inertia;
        rig.noise_psd = 2.0 * 40.0 * (0.03 * rig.inertia).powi(2);
        let size = 2.0 * rig.encoder.step_rad();
        let rigs = std::slice::from_ref(&rig);
        let (count, mut sum, mut squares) = (400, 0.0, 0.0);
        for seed in 0..count {
            let (distance, course) = seen(&rig, size, Some(seed));
            let run = Passed::recorded(&rig, &course, &[]);
            let edges = course.crossings.iter().filter(|c| c.class.is_some());
            let course_rad = |t: f64| rig.start_rad + 10.0 * t - 10.0 * t * t;
            let off = (edges.clone())
                .map(|c| course_rad(c.time_s) - c.place as f64 * rig.encoder.step_rad());
            let signal = edges.map(|c| 0.5 * size * c.speed.signum());
            let left = |values: Vec<f64>| project::residual(rigs, &[&run], &[values]);
            let (off, signal) = (left(off.collect()), left(signal.collect()));
            let dot: f64 = off.iter().zip(&signal).map(|(a, b)| a * b).sum();
            let error = dot / distance - distance;
            sum += error;
            squares += error * error;
        }
        let (mean, rms) = (sum / count as f64, (squares / count as f64).sqrt());
        // Three and a half standard errors.
        assert!(
            mean.abs() < 0.175 && (rms - 1.0).abs() < 0.125,
            "{mean} {rms}"
        );
    }

    #[test]
    fn a_ripple_that_holds_the_shaft_at_the_turn_keeps_noise_from_hiding_it() {
        let mut rig = reversing();
        rig.jitter_s = 1e-9;
        rig.noise_psd = 1e-2 * rig.inertia * rig.inertia;
        let size = 0.3 * rig.encoder.step_rad();
        let (free, course) = seen(&rig, size, Some(4));
        let turn = course.crossings.iter().position(|c| !c.forward).unwrap();
        let turn = course.crossings[turn].place as f64 * rig.encoder.step_rad();
        // A well about the turn, thirty times a second.
        let order = 20.0;
        rig.ripples = vec![Order {
            order,
            phase_rad: std::f64::consts::PI - order * turn,
            torque_n_m: 200.0_f64.powi(2) / order * rig.inertia,
        }];
        let passed = |rig: &Rig| Passed::recorded(rig, &course, &[]);
        let deviations = |rig: &Rig| -> f64 {
            let at = course.crossings.iter().filter(|c| c.class.is_some());
            let at = at.clone().position(|c| !c.forward).unwrap();
            passed(rig).whitener.deviations().nth(at).unwrap()
        };
        let held = deviations(&rig);
        rig.ripples.clear();
        assert!(held < 0.8 * deviations(&rig), "{held} {free}");
    }
}
