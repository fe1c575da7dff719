//! Marks that are shifted: thresholds, plays, run-out, and defects of the disc.

use super::*;
use crate::twin::{
    Backlash, Bearing, Channel, Flank, Hysteresis, LocalDefect, ThresholdDrift, ThresholdRipple,
};

const STEP: f64 = TAU / 10_000.0;

/// The paper's disc with its errors, turning forward or back.
fn real(r_min: f64, turns: f64) -> Twin {
    Twin {
        errors: Twin::paper().errors,
        ..plain(r_min, turns)
    }
}

/// Swings to and fro over most of a turn.
fn swinging() -> Twin {
    let step = |t_s, r_min| Step { t_s, r_min };
    let mut twin = real(60.0, 1.0);
    twin.shaft.stiffness_n_m_s = 9.9e-3;
    twin.duration = Duration::Seconds(4.0);
    twin.drive = Drive::Steps(vec![
        step(0.0, 60.0),
        step(0.8, -50.0),
        step(1.9, 70.0),
        step(2.6, -60.0),
    ]);
    twin
}

/// How far each edge is beyond its place on the disc, rad, in the order of the recording.
fn beyond(twin: &Twin) -> Vec<(Event, f64)> {
    let simulation = Simulation::new(twin).unwrap();
    let errors = simulation.true_errors();
    let mut events = Vec::new();
    for event in simulation {
        let Some(k) = event.truth.edge else { continue };
        let place = f64::from(k) * STEP - errors[k as usize];
        let off = event.truth.angle_rad - place;
        events.push((event, off - (off / TAU).round() * TAU));
    }
    events
}

fn rises(class: Class) -> bool {
    class.bit_and_rise().1
}

fn one_level_a_row(twin: &Twin) {
    let rows: Vec<Event> = Simulation::new(twin).unwrap().collect();
    assert!(rows.windows(2).all(|w| w[0].row.ticks <= w[1].row.ticks));
    for pair in rows.windows(2) {
        let changed = pair[0].row.levels.0 ^ pair[1].row.levels.0;
        assert_eq!(changed.count_ones(), 1, "{pair:?}");
    }
}

#[test]
fn the_level_of_the_very_time_of_each_edge_shifts_it() {
    for r_min in [40.0, -40.0] {
        let mut twin = real(r_min, 3.0);
        twin.ripple = Twin::paper().ripple;
        twin.threshold_ripple = vec![ThresholdRipple {
            f_hz: 730.0,
            phase_rad: 0.4,
            angle_rad: 2e-4,
            channel: None,
        }];
        twin.threshold_drift = vec![ThresholdDrift {
            angle_rad: -1e-4,
            tau_s: 0.7,
            from_s: 1.1,
            channel: Some(Channel::B),
        }];
        let edges = beyond(&twin);
        assert!((29_990..=30_010).contains(&edges.len()));
        for (event, off) in edges {
            let t = event.truth.time_s;
            let mut shift = 2e-4 * (TAU * 730.0 * t + 0.4).sin();
            if matches!(event.truth.class, Class::BRise | Class::BFall) {
                shift -= 1e-4 * (1.0 - (-(t - 1.1).max(0.0) / 0.7).exp());
            }
            let expected = if rises(event.truth.class) {
                shift
            } else {
                -shift
            };
            assert!((off - expected).abs() < 1e-12, "{event:?}: {off:e}");
        }
        one_level_a_row(&twin);
    }
}

#[test]
fn a_shift_by_a_threshold_is_a_width_error_of_twice_its_size() {
    let mut settled = real(60.0, 2.0);
    settled.threshold_drift = vec![ThresholdDrift {
        angle_rad: 1e-4,
        tau_s: 1e-6,
        from_s: 0.0,
        channel: None,
    }];
    let mean = |falls: bool| {
        let edges = beyond(&settled);
        let late: Vec<f64> = edges
            .iter()
            .filter(|(event, _)| event.truth.time_s > 0.01 && rises(event.truth.class) != falls)
            .map(|edge| edge.1)
            .collect();
        late.iter().sum::<f64>() / late.len() as f64
    };
    // e is grid less angle: e(fall) - e(rise) is xi.
    assert!((mean(false) - mean(true) - 2e-4).abs() < 1e-12);
}

#[test]
fn hysteresis_makes_every_edge_late_by_half_of_it_either_way() {
    for (channel, gap) in [(None, 3e-4), (Some(Channel::A), 3e-4), (None, 40.0 * STEP)] {
        let mut twin = swinging();
        twin.hysteresis = Some(Hysteresis {
            angle_rad: gap,
            channel,
        });
        let (mut there, mut back) = (0, 0);
        let edges = beyond(&twin);
        for pair in edges.windows(2) {
            let (event, off) = pair[1];
            let way = event.truth.angle_rad - pair[0].0.truth.angle_rad;
            let on = channel.is_none() || matches!(event.truth.class, Class::ARise | Class::AFall);
            // The disc's own error goes with its edge, so only edges of one direction in a row tell it.
            if way.abs() > 5.0 * STEP {
                continue;
            }
            let half = if on { 0.5 * gap } else { 0.0 };
            let (forward, reverse) = ((off - half).abs(), (off + half).abs());
            assert!(forward.min(reverse) < 1e-12, "{event:?}: {off:e}");
            if on && forward < 1e-12 {
                there += 1;
                assert!(way > -5.0 * STEP);
            } else {
                back += 1;
            }
        }
        assert!(there > 3000 && back > 3000, "{there} {back}");
        one_level_a_row(&twin);
    }
}

#[test]
fn the_disc_stands_after_a_reversal_until_the_gap_is_crossed() {
    let mut twin = swinging();
    let gap = 25.0 * STEP;
    twin.backlash = Some(Backlash { gap_rad: gap });
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    let mut reversals = 0;
    for pair in events.windows(2) {
        // The same mark twice: the shaft turned round in between.
        if pair[0].truth.class == pair[1].truth.class && pair[0].truth.edge == pair[1].truth.edge {
            let way = pair[1].truth.angle_rad - pair[0].truth.angle_rad;
            assert!((way.abs() - gap).abs() < 1e-12, "{pair:?}");
            reversals += 1;
        }
    }
    assert_eq!(reversals, 3);
    // It begins behind by half the gap, as it turns forward.
    let first = events
        .iter()
        .find(|event| event.truth.edge == Some(4))
        .unwrap();
    let errors = Simulation::new(&twin).unwrap().true_errors();
    let place = 4.0 * STEP - errors[4];
    assert!((first.truth.angle_rad - place - 0.5 * gap).abs() < 1e-12);
    // Hysteresis of the gap looks the same.
    let mut alike = swinging();
    alike.hysteresis = Some(Hysteresis {
        angle_rad: gap,
        channel: None,
    });
    assert!(Simulation::new(&alike).unwrap().eq(events));
}

#[test]
fn run_out_at_an_order_that_is_not_whole_moves_on_from_turn_to_turn() {
    for r_min in [60.0, -60.0] {
        let mut twin = real(r_min, 5.0);
        twin.bearing = vec![Bearing {
            order: 3.57,
            phase_rad: 0.2,
            torque_n_m: None,
            speed_fraction: None,
            runout_rad: Some(2e-3),
        }];
        for (event, off) in beyond(&twin) {
            let expected = -2e-3 * (3.57 * event.truth.angle_rad + 0.2).sin();
            assert!((off - expected).abs() < 1e-12, "{event:?}: {off:e}");
        }
        one_level_a_row(&twin);
    }
}

#[test]
fn a_defect_is_a_bump_on_the_disc_and_adds_to_a_list_too() {
    let defect = LocalDefect {
        angle_rad: -0.001,
        width_rad: 3e-3,
        error_rad: 2e-4,
        channel: Some(Channel::B),
        edge: Some(Flank::Fall),
    };
    let plain = Twin::paper();
    let before = Simulation::new(&plain).unwrap().true_errors();
    let mut listed = plain.clone();
    listed.errors = twin::Errors {
        list_rad: before.clone(),
        ..twin::Errors::default()
    };
    for mut twin in [plain, listed] {
        twin.local_defect = vec![defect];
        let after = Simulation::new(&twin).unwrap().true_errors();
        for (k, (a, b)) in after.iter().zip(&before).enumerate() {
            let way = (k as f64 * STEP + 0.001 + TAU / 2.0) % TAU - TAU / 2.0;
            let bump = if k % 4 == 3 {
                2e-4 * (-0.5 * (way / 3e-3).powi(2)).exp()
            } else {
                0.0
            };
            assert!((a - b - bump).abs() < 1e-15, "edge {k}");
        }
    }
}
