use std::f64::consts::TAU;

use super::Effect;
use crate::capture::{arrivals, rows};
use crate::encoder::Class;
use crate::rig::{Profile, Rig};
use crate::testing::plain;
use crate::turning::turn;

/// How late each edge comes, rad at the rig's speed, with its time, grid angle through all turns and class.
fn late(rig: &Rig, effect: &Effect) -> Vec<(f64, f64, f64, Class)> {
    let effects = std::slice::from_ref(effect);
    let course = turn(rig, effects, None);
    let times = arrivals(&course, rig, effects);
    let step = rig.encoder.step_rad();
    let speed = rig.profile.start();
    let mut all = Vec::new();
    for (crossing, time) in course.crossings.iter().zip(times) {
        if let Some(class) = crossing.class {
            let grid = crossing.place as f64 * step;
            let late = (time - (grid - rig.start_rad) / speed) * speed;
            all.push((late, time, grid, class));
        }
    }
    assert!(all.len() > 1900);
    all
}

/// Whether every edge comes as late as a closed form of time, grid angle and class says.
fn holds(effect: &Effect, expected: impl Fn(f64, f64, Class) -> f64) {
    for (late, time, grid, class) in late(&plain(), effect) {
        let right = expected(time, grid, class);
        assert!((late - right).abs() < 1e-9, "{late:e} {right:e} at {grid}");
    }
}

const fn by_level(class: Class) -> f64 {
    if class.rises { 1.0 } else { -1.0 }
}

#[test]
fn effects_on_the_angle_have_their_sign_and_size() {
    let (amplitude_rad, phase_rad) = (1e-3, 0.7);
    let round = Effect::Eccentricity {
        amplitude_rad,
        phase_rad,
    };
    holds(&round, |_, grid, _| -1e-3 * (grid - 0.7).sin());
    let tilt = Effect::DiscTilt {
        amplitude_rad,
        phase_rad,
    };
    holds(&tilt, |_, grid, _| -1e-3 * (2.0 * grid - 0.7).sin());
    let width = Effect::WidthError {
        rad: [1e-3, -2e-3, 0.0],
    };
    holds(&width, |_, _, class| match (class.rises, class.channel) {
        (true, _) => 0.0,
        (false, 0) => -1e-3,
        (false, _) => 2e-3,
    });
    let quadrature = Effect::QuadratureError { rad: 1e-3 };
    holds(&quadrature, |_, _, class| -1e-3 * class.channel as f64);
    let runout = Effect::BearingRunout {
        order: 3.4,
        phase_rad,
        runout_rad: 1e-3,
    };
    // The angle in the sine is the shaft's own at the crossing: one step of the fixed point is enough here.
    for (late, time, _, _) in self::late(&plain(), &runout) {
        let theta = 0.001 + 10.0 * time;
        assert!((late + 1e-3 * (3.4 * theta + 0.7).sin()).abs() < 1e-9);
    }
}

#[test]
fn a_defect_is_a_bump_of_one_class_at_its_place() {
    let defect = Effect::LocalDefect {
        angle_rad: 6.25,
        width_rad: 0.1,
        error_rad: 2e-3,
        channel: Some(1),
        rises: Some(true),
    };
    holds(&defect, |_, grid, class| {
        let away = (grid - 6.25 + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        let touched = class.channel == 1 && class.rises;
        let bump = (-0.5 * (away / 0.1).powi(2)).exp();
        if touched { -2e-3 * bump } else { 0.0 }
    });
}

#[test]
fn levels_move_rises_and_falls_apart() {
    let ripple = Effect::ThresholdRipple {
        f_hz: 50.0,
        phase_rad: 0.3,
        angle_rad: 1e-3,
        channel: Some(0),
    };
    holds(&ripple, |time, _, class| {
        let wave = 1e-3 * (TAU * 50.0 * time + 0.3).sin();
        if class.channel == 0 {
            by_level(class) * wave
        } else {
            0.0
        }
    });
    let drift = Effect::ThresholdDrift {
        angle_rad: 1e-3,
        tau_s: 0.5,
        from_s: 1.0,
    };
    holds(&drift, |time, _, class| {
        let since = (time - 1.0).max(0.0);
        by_level(class) * 1e-3 * (1.0 - (-since / 0.5).exp())
    });
}

#[test]
fn delays_come_on_top_of_the_time() {
    let delay = Effect::EdgeDelay {
        rise_s: [2e-6, 4e-6, 0.0],
        fall_s: [0.0, 1e-6, 0.0],
    };
    holds(&delay, |_, _, class| {
        let seconds = match (class.rises, class.channel) {
            (true, 0) => 2e-6,
            (true, _) => 4e-6,
            (false, 0) => 0.0,
            (false, _) => 1e-6,
        };
        10.0 * seconds
    });
    let skew = Effect::ChannelSkew {
        channel_s: [0.0, 3e-6, 0.0],
    };
    holds(&skew, |_, _, class| 3e-5 * class.channel as f64);
    let task = Effect::CaptureTask {
        task_hz: 400.0,
        busy_s: 2e-4,
        phase_s: 1e-3,
    };
    let mut blocked = 0;
    for (late, time, _, _) in late(&plain(), &task) {
        let since = (time - 1e-3).rem_euclid(1.0 / 400.0);
        assert!((-1e-9..2.001e-3).contains(&late));
        if late > 1e-9 {
            blocked += 1;
            assert!((since - 2e-4).abs() < 1e-9);
        } else {
            assert!(since > 2e-4 - 1e-9);
        }
    }
    assert!((100..240).contains(&blocked), "8 % of 2000: {blocked}");
}

#[test]
fn play_delays_every_edge_in_its_direction() {
    let mut rig = plain();
    rig.profile = Profile::Ramp {
        from: 10.0,
        to: -10.0,
        over_s: 2.0,
    };
    for effect in [
        Effect::Hysteresis { angle_rad: 4e-3 },
        Effect::Backlash { gap_rad: 4e-3 },
    ] {
        let course = turn(&rig, &[effect], None);
        let step = rig.encoder.step_rad();
        let mut seen = [0, 0];
        for crossing in course.crossings.iter().filter(|c| c.class.is_some()) {
            let t = crossing.time_s;
            let way = |t: f64| 10.0 * t - 2.5 * t.min(2.0).powi(2) * 2.0;
            let theta = if t < 2.0 {
                rig.start_rad + way(t)
            } else {
                rig.start_rad - 10.0 * (t - 2.0)
            };
            let late = theta - crossing.place as f64 * step;
            let expected = if crossing.forward { 2e-3 } else { -2e-3 };
            assert!((late - expected).abs() < 1e-9, "{late} at {t}");
            seen[usize::from(crossing.forward)] += 1;
        }
        assert!(seen[0] > 200 && seen[1] > 200);
    }
}

#[test]
fn noise_of_stamps_has_its_size() {
    let rig = plain();
    let course = turn(&rig, &[], None);
    let clock = rig.clock_hz as f64;
    let moments = |effect: Effect| {
        let (rows, _) = rows(&course, &rig, &[effect], 3);
        let errors: Vec<f64> = (rows.iter().zip(&course.crossings))
            .map(|(row, crossing)| (row.0 as f64 + 0.5) / clock - crossing.time_s)
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let square = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>();
        (mean, (square / errors.len() as f64).sqrt())
    };
    let (mean, rms) = moments(Effect::TimestampJitter { jitter_s: 1e-6 });
    assert!(
        mean.abs() < 1e-7 && (rms / 1e-6 - 1.0).abs() < 0.06,
        "{mean} {rms}"
    );
    let (mean, rms) = moments(Effect::CaptureLatency { mean_s: 1e-6 });
    assert!((mean / 1e-6 - 1.0).abs() < 0.1 && (rms / 1e-6 - 1.0).abs() < 0.12);
}

#[test]
fn lost_edges_glitches_and_index_slips_are_there() {
    let rig = plain();
    let course = turn(&rig, &[], None);
    let all = course.crossings.len();
    let made = |effect: Effect| rows(&course, &rig, &[effect], 3);
    let (lost, at) = made(Effect::LostEdges { count: 4, seed: 2 });
    assert_eq!((lost.len(), at.len()), (all - 4, 4));
    let (extra, _) = made(Effect::ExtraEdges { count: 4, seed: 2 });
    assert_eq!(extra.len(), all + 8);
    for rows in [&lost, &extra] {
        assert!(rows.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }
    // A glitch leaves the level as it was.
    assert_eq!(extra.last().map(|row| row.1), lost.last().map(|row| row.1));
    let slip = Effect::IndexSlip {
        at_s: 1.5,
        edges: 3,
    };
    let slipped = turn(&rig, &[slip], None);
    let index = |course: &crate::turning::Course| -> Vec<f64> {
        let index = course.crossings.iter().filter(|c| c.bit == 8 && c.high);
        index.map(|c| c.time_s).collect()
    };
    for (before, after) in index(&course).iter().zip(index(&slipped)) {
        let moved = (after - before) * 10.0 / rig.encoder.step_rad();
        let expected = if after > 1.5 { 3.0 } else { 0.0 };
        assert!((moved - expected).abs() < 1e-6, "{moved}");
    }
}
