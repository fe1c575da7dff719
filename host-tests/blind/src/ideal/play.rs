//! What a play shows in a run that reverses.

use super::passed::Passed;
use super::project;
use crate::effect::Effect;
use crate::rig::Rig;
use crate::turning::Course;

/// Whether an effect is a play and a drive reverses, so that the play shows.
#[must_use]
pub fn shows_play(effect: &Effect, rigs: &[Rig]) -> bool {
    effect.play_rad() != 0.0 && rigs.iter().any(|rig| rig.profile.reverses())
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
    use crate::encoder::Encoder;
    use crate::rig::{Order, Profile};
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

    /// Mean and RMS of the errors, in standard deviations, with which a play is estimated from noisy runs.
    fn errors(rig: &Rig, size: f64) -> (f64, f64) {
        let rigs = std::slice::from_ref(rig);
        let step = rig.encoder.step_rad();
        // The course without noise, by a disc with many more lines.
        let encoder = Encoder::Quadrature {
            lines: 8000,
            index: true,
        };
        let fine = Rig {
            encoder,
            disc_rad: vec![0.0; encoder.edges()],
            turns: 1.1 * rig.turns,
            ..rig.clone()
        };
        let marks = turn(&fine, &[], None).crossings;
        let marks: Vec<_> = marks.iter().filter(|c| c.class.is_some()).collect();
        let expected = |time: f64| {
            let after = marks.partition_point(|c| c.time_s < time);
            let (from, to) = (marks[after - 1], marks[after]);
            let h = to.time_s - from.time_s;
            let x = (time - from.time_s) / h;
            let way = (to.place - from.place) as f64 * encoder.step_rad();
            from.place as f64 * encoder.step_rad()
                + way * x * x * (3.0 - 2.0 * x)
                + h * x * (1.0 - x) * (from.speed * (1.0 - x) - to.speed * x)
        };
        let (count, mut sum, mut squares) = (400, 0.0, 0.0);
        for seed in 0..count {
            let (distance, course) = seen(rig, size, Some(seed));
            let effects = [Effect::Hysteresis { angle_rad: size }];
            let run = Passed::recorded(rig, &course, &effects);
            let edges = course.crossings.iter().filter(|c| c.class.is_some());
            // The first edges may come before the fine disc's.
            let off = (edges.clone())
                .map(|c| expected(c.time_s.max(marks[1].time_s)) - c.place as f64 * step);
            let signal = edges.map(|c| 0.5 * size * c.speed.signum());
            let left = |values: Vec<f64>| project::residual(rigs, &[&run], &[values]);
            let (off, signal) = (left(off.collect()), left(signal.collect()));
            let dot: f64 = off.iter().zip(&signal).map(|(a, b)| a * b).sum();
            let error = dot / distance - distance;
            sum += error;
            squares += error * error;
        }
        (sum / count as f64, (squares / count as f64).sqrt())
    }

    #[test]
    fn estimates_from_noisy_runs_scatter_as_it_says() {
        // The speed forgets within a quarter of the time between the edges beside the turn.
        let mut stiff = reversing();
        stiff.stiffness = 40.0 * stiff.inertia;
        stiff.noise_psd = 2.0 * 40.0 * (0.03 * stiff.inertia).powi(2);
        // Ripples pull at the turn half as much as the drive does.
        let mut rippled = reversing();
        rippled.stiffness = 5.0 * rippled.inertia;
        rippled.noise_psd = 2.0 * 5.0 * (0.003 * rippled.inertia).powi(2);
        rippled.ripples = vec![Order {
            order: 18.0,
            phase_rad: 1.0,
            torque_n_m: 10.0 * rippled.inertia,
        }];
        for rig in [stiff, rippled] {
            let (mean, rms) = errors(&rig, 0.5 * rig.encoder.step_rad());
            // Three and a half standard errors.
            assert!(
                mean.abs() < 0.175 && (rms - 1.0).abs() < 0.125,
                "{mean} {rms} {:?}",
                rig.ripples
            );
        }
    }
}
