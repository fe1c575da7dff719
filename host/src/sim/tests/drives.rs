//! Profiles of ramps and holds, torques, and twins without an inertia.

use super::motion::largest_angle_difference;
use super::*;
use crate::twin::{Gap, SpeedProfile, TorquePoint, TorqueProfile};

fn profile(points: &[(f64, f64)]) -> Drive {
    let point = |&(t_s, r_min)| Step { t_s, r_min };
    Drive::Profile(SpeedProfile::new(points.iter().map(point).collect()))
}

fn torque(start_r_min: f64, points: &[(f64, f64)]) -> Drive {
    let point = |&(t_s, torque_n_m)| TorquePoint { t_s, torque_n_m };
    let points = points.iter().map(point).collect();
    Drive::Torque(TorqueProfile::new(start_r_min, points))
}

fn driven(drive: Drive, seconds: f64) -> Twin {
    let mut twin = plain(60.0, 1.0);
    twin.drive = drive;
    twin.duration = Duration::Seconds(seconds);
    twin
}

fn truths(twin: &Twin) -> Vec<Truth> {
    let events = Simulation::new(twin).unwrap();
    events.map(|event| event.truth).collect()
}

#[test]
fn a_profile_goes_in_straight_lines_through_its_points() {
    let points = [
        (0.5, 0.0),
        (1.5, 60.0),
        (2.5, 60.0),
        (4.5, -60.0),
        (4.5, -120.0),
    ];
    let mut twin = driven(profile(&points), 5.0);
    // Friction is balanced, the turn of the direction included.
    twin.shaft.coulomb_n_m = 1e-3;
    twin.shaft.viscous_n_m_s = 1e-4;
    let way = |t: f64| {
        let ramp = |from: f64, over: f64| (t - from).clamp(0.0, over).powi(2) / (2.0 * over);
        let hold = |from: f64, until: f64| (t - from).clamp(0.0, until - from);
        let up = ramp(0.5, 1.0);
        let down = hold(2.5, 4.5) - 2.0 * ramp(2.5, 2.0);
        TAU * (up + hold(1.5, 2.5) + down)
    };
    let truths = truths(&twin);
    let (slow, fast): (Vec<Truth>, Vec<Truth>) = truths.iter().partition(|t| t.time_s < 4.5);
    assert!(slow.len() > 20_000, "{}", slow.len());
    for truth in slow {
        let off = truth.angle_rad - way(truth.time_s);
        assert!(off.abs() < 1e-9, "{truth:?}: {off:e}");
    }
    // After the jump the shaft comes after with J / b.
    let last = fast.last().unwrap();
    let law = |t: f64| {
        let tau = twin.shaft.inertia_kg_m2 / twin.shaft.viscous_n_m_s;
        -2.0 * TAU * t + TAU * tau * (1.0 - (-t / tau).exp())
    };
    let off = last.angle_rad - way(4.5) - law(last.time_s - 4.5);
    assert!(off.abs() < 1e-6, "{off:e}");
}

#[test]
fn a_profile_of_two_points_is_the_ramp() {
    let ramp = Drive::Ramp {
        from_r_min: -30.0,
        to_r_min: 90.0,
        over_s: 2.0,
    };
    let mut one = driven(ramp, 3.0);
    one.shaft.coulomb_n_m = 1e-3;
    let two = Twin {
        drive: profile(&[(0.0, -30.0), (2.0, 90.0)]),
        ..one.clone()
    };
    assert_eq!(truths(&one), truths(&two));
}

#[test]
fn a_torque_speeds_the_shaft_up_by_the_law_of_motion() {
    let mut twin = driven(
        torque(0.0, &[(0.2, 0.0), (0.2, 2e-3), (1.2, 2e-3), (2.2, -2e-3)]),
        3.0,
    );
    twin.shaft = twin::Shaft {
        inertia_kg_m2: 1e-4,
        ..twin::Shaft::default()
    };
    // 20 rad/s^2 for 1 s, then falling in a straight line to -20 over 1 s, and on.
    let angle = |t: f64| {
        let (a, b, c) = (t - 0.2, t - 1.2, t - 2.2);
        match t {
            _ if a < 0.0 => 0.0,
            _ if b < 0.0 => 10.0 * a * a,
            _ if c < 0.0 => 10.0 + 20.0 * b + 10.0 * b * b - 20.0 / 3.0 * b.powi(3),
            _ => 10.0 + 20.0 + 10.0 - 20.0 / 3.0 + 20.0 * c - 10.0 * c * c,
        }
    };
    let truths = truths(&twin);
    assert!(truths.len() > 50_000, "{}", truths.len());
    for truth in truths {
        let off = truth.angle_rad - angle(truth.time_s);
        assert!(off.abs() < 1e-9, "{truth:?}: {off:e}");
    }
}

#[test]
fn a_torque_under_friction_holds_the_shaft_up_to_it_and_settles_at_its_speed() {
    let mut twin = driven(
        torque(0.0, &[(0.0, 0.9e-3), (0.5, 0.9e-3), (0.5, 3e-3)]),
        4.0,
    );
    twin.shaft.coulomb_n_m = 1e-3;
    twin.shaft.viscous_n_m_s = 1e-3;
    for drag in [0.0, 1e-9] {
        twin.shaft.drag_n_m_s2 = drag;
        let truths = truths(&twin);
        assert!(truths[1].time_s > 0.5, "{drag}");
        let (a, b) = (truths[truths.len() - 501], truths[truths.len() - 1]);
        let speed = (b.angle_rad - a.angle_rad) / (b.time_s - a.time_s);
        assert!((speed - 2.0).abs() < 1e-3, "{speed}");
    }
}

#[test]
fn ten_times_finer_steps_move_no_edge_of_a_profile_or_torque() {
    let ripple = Twin::paper().ripple;
    let swing = profile(&[(0.1, -120.0), (0.6, -60.0), (0.8, -60.0), (1.2, -90.0)]);
    let push = torque(100.0, &[(0.0, 3e-3), (1.0, 1e-3), (2.0, 3e-3)]);
    for (drive, seconds) in [(swing, 6.0), (push, 4.0)] {
        let mut twin = driven(drive, seconds);
        twin.ripple = ripple.clone();
        twin.shaft.coulomb_n_m = 1e-4;
        let off = largest_angle_difference(&twin, 100.0);
        assert!(off < 1e-10, "{off:e}");
    }
}

#[test]
fn without_an_inertia_the_motion_is_that_of_any_inertia() {
    let mut twin = plain(60.0, 2.0);
    twin.ripple = vec![Ripple {
        order: 5.0,
        phase_rad: 0.3,
        torque_n_m: None,
        speed_fraction: Some(0.01),
    }];
    twin.noise = wander(1e-3);
    twin.shaft = twin::Shaft::default();
    let mut heavy = twin.clone();
    heavy.shaft.inertia_kg_m2 = 1.0;
    assert_eq!(truths(&twin), truths(&heavy));
    heavy.shaft.inertia_kg_m2 = 37.0;
    for (a, b) in truths(&twin).iter().zip(truths(&heavy)) {
        assert!((a.time_s - b.time_s).abs() < 1e-9);
    }
}

#[test]
fn teeth_in_gaps_give_no_edge_and_the_others_are_where_they_were() {
    let gaps = |gaps: &[(u32, u32)]| {
        let mut twin = plain(-60.0, 3.0);
        let gap = |&(at, missing)| Gap { at, missing };
        twin.encoder = Encoder::Wheel {
            teeth: 36,
            missing: 0,
            gaps: gaps.iter().map(gap).collect(),
        };
        twin.errors.position = Some(Position::Normal {
            rms_rad: 1e-3,
            per: Per::Line,
        });
        twin
    };
    let (whole, two) = (gaps(&[]), gaps(&[(20, 1), (12, 2)]));
    let gone = [24, 25, 26, 27, 40, 41];
    let mut expected = truths(&whole);
    expected.retain(|truth| !gone.contains(&truth.edge.unwrap()));
    assert_eq!(truths(&two), expected);
    let errors = true_errors(&two).unwrap();
    for (k, (one, other)) in errors.iter().zip(true_errors(&whole).unwrap()).enumerate() {
        let is = if gone.contains(&(k as u32)) {
            0.0
        } else {
            other
        };
        assert_eq!(*one, is, "{k}");
    }
}

#[test]
fn a_loop_sees_the_way_over_a_gap() {
    let mut twin = plain(60.0, 5.0);
    twin.encoder = Encoder::Wheel {
        teeth: 36,
        missing: 0,
        gaps: vec![Gap { at: 12, missing: 2 }, Gap { at: 20, missing: 1 }],
    };
    twin.drive = speed_loop(60.0, 1.0);
    let last = *truths(&twin).last().unwrap();
    assert!((last.time_s - 5.0).abs() < 0.05, "{last:?}");
}

#[test]
fn torques_that_run_away_with_the_shaft_end_the_run_and_say_so() {
    let mut twin = driven(torque(0.0, &[(0.0, 1e6)]), 10.0);
    twin.shaft.viscous_n_m_s = 0.0;
    let mut simulation = Simulation::new(&twin).unwrap();
    let edges = simulation.by_ref().count();
    let shown = simulation.ended().unwrap_err().to_string();
    assert!(edges < 1_000_000, "{edges}");
    assert!(
        shown.contains("faster than 10000000 r/min") && !shown.contains('\n'),
        "{shown}"
    );
    let mut calm = Simulation::new(&plain(60.0, 1.0)).unwrap();
    assert!(calm.by_ref().count() > 0 && calm.ended().is_ok());
}
