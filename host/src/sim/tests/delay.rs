//! Delays of edges and channels at capture.

use super::*;
use crate::twin::{ChannelSkew, EdgeDelay, RiseFall};

/// Wide enough that no delay here reaches from edge to edge.
fn coarse(r_min: f64, turns: f64) -> Twin {
    let mut twin = plain(r_min, turns);
    twin.encoder = Encoder::Quadrature {
        lines: 25,
        index: false,
    };
    twin.timer.clock_hz = 1_000_000_000;
    twin
}

const fn rise_fall(rise_s: f64, fall_s: f64) -> RiseFall {
    RiseFall { rise_s, fall_s }
}

fn delayed(twin: &Twin) -> Twin {
    Twin {
        edge_delay: Some(EdgeDelay {
            a: rise_fall(3e-6, 1e-6),
            b: rise_fall(2e-6, 2.5e-6),
            ..EdgeDelay::default()
        }),
        channel_skew: Some(ChannelSkew {
            b_s: 4e-6,
            ..ChannelSkew::default()
        }),
        ..twin.clone()
    }
}

/// Mean angle by which a class seems to come late, rad, against a steady shaft; classes A rise, B rise, A fall, B fall.
fn apparent_rad(twin: &Twin, r_min: f64) -> [f64; 4] {
    let mut sums = [(0.0, 0.0); 4];
    for event in Simulation::new(twin).unwrap() {
        let Some(edge) = event.truth.edge else {
            continue;
        };
        let seen = event.row.ticks as f64 / 1e9 * r_min * RAD_S;
        let sum = &mut sums[edge as usize % 4];
        *sum = (sum.0 + seen - event.truth.angle_rad, sum.1 + 1.0);
    }
    sums.map(|(sum, count)| sum / count)
}

#[test]
fn apparent_xi_and_p_grow_by_speed_times_delay() {
    for r_min in [60.0, 1200.0] {
        let twin = delayed(&coarse(r_min, 4.0));
        let [a_rise, b_rise, a_fall, b_fall] = apparent_rad(&twin, r_min);
        let speed = r_min * RAD_S;
        // A tick of 1 ns rounds by up to as much.
        let near = |found: f64, delay_s: f64| (found - speed * delay_s).abs() < speed * 1e-9;
        assert!(near(a_fall - a_rise, 1e-6 - 3e-6));
        assert!(near(b_fall - b_rise, 2.5e-6 - 2e-6));
        assert!(near(b_rise - a_rise, 4e-6 + 2e-6 - 3e-6));
    }
}

#[test]
fn in_reverse_a_rising_mark_has_the_delay_of_a_fall() {
    let there = apparent_rad(&delayed(&coarse(600.0, 4.0)), 600.0);
    let back = apparent_rad(&delayed(&coarse(-600.0, 4.0)), -600.0);
    let [a_rise, b_rise, a_fall, b_fall] = there;
    for (found, expected) in back.into_iter().zip([a_fall, b_fall, a_rise, b_rise]) {
        // Forward later is further, in reverse less far.
        assert!((found + expected).abs() < 600.0 * RAD_S * 1e-9);
    }
}

#[test]
fn a_hall_sensor_s_third_channel_has_its_own_delay_and_an_index_none() {
    let mut hall = coarse(600.0, 4.0);
    hall.encoder = Encoder::Hall { pole_pairs: 2 };
    hall.channel_skew = Some(ChannelSkew {
        c_s: 7e-6,
        ..ChannelSkew::default()
    });
    let mut indexed = delayed(&coarse(600.0, 4.0));
    indexed.encoder = Encoder::Quadrature {
        lines: 25,
        index: true,
    };
    for (twin, late_s) in [(hall, 7e-6), (indexed, 0.0)] {
        let bits = Simulation::new(&twin).unwrap().filter(|event| {
            matches!(
                event.truth.class,
                Class::CRise | Class::CFall | Class::IndexRise | Class::IndexFall
            )
        });
        let mut seen = 0;
        for event in bits {
            let late = event.row.ticks as f64 / 1e9 - event.truth.time_s;
            assert!((late - late_s).abs() < 2e-9, "{late:e}");
            seen += 1;
        }
        assert!(seen >= 7);
    }
}

#[test]
fn an_edge_delayed_past_another_comes_after_it_and_every_row_changes_one_level() {
    // B is captured two and a half steps late.
    let mut twin = coarse(6000.0, 20.0);
    let step_s = 60.0 / 6000.0 / 100.0;
    twin.channel_skew = Some(ChannelSkew {
        b_s: 2.5 * step_s,
        ..ChannelSkew::default()
    });
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    assert!(events.len() >= 1998, "{}", events.len());
    assert!(events.windows(2).all(|w| w[0].row.ticks <= w[1].row.ticks));
    assert!(
        events
            .windows(2)
            .any(|w| w[0].truth.time_s > w[1].truth.time_s)
    );
    let mut changes = [0_u32; 2];
    for pair in events.windows(2) {
        let changed = pair[0].row.levels.0 ^ pair[1].row.levels.0;
        assert_eq!(changed.count_ones(), 1);
        changes[usize::from(changed == Levels::B)] += 1;
    }
    assert!(changes[0].abs_diff(changes[1]) <= 3, "{changes:?}");
}

#[test]
fn a_pulse_shorter_than_the_difference_of_its_delays_is_not_seen() {
    let mut twin = coarse(6000.0, 20.0);
    let step_s = 60.0 / 6000.0 / 100.0;
    // A is high for two steps: its rise comes after its fall.
    twin.edge_delay = Some(EdgeDelay {
        a: rise_fall(2.5 * step_s, 0.0),
        ..EdgeDelay::default()
    });
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    assert!((990..=1010).contains(&events.len()), "{}", events.len());
    // A rise may still be on its way when the recording ends, or A be high when it begins.
    let middle = &events[4..events.len() - 4];
    assert!(
        middle
            .iter()
            .all(|event| matches!(event.truth.class, Class::BRise | Class::BFall))
    );
}

#[test]
fn no_delay_is_no_change() {
    let twin = Twin {
        noise: wander(0.01),
        duration: Duration::Turns(0.3),
        ..Twin::paper()
    };
    let zero = Twin {
        edge_delay: Some(EdgeDelay::default()),
        channel_skew: Some(ChannelSkew::default()),
        ..twin.clone()
    };
    assert!(
        Simulation::new(&twin)
            .unwrap()
            .eq(Simulation::new(&zero).unwrap())
    );
}

#[test]
fn the_speed_loop_sees_the_edges_as_captured() {
    let mut twin = coarse(600.0, 4.0);
    twin.drive = speed_loop(600.0, 100.0);
    let run = |twin: &Twin| -> Vec<Event> { Simulation::new(twin).unwrap().collect() };
    let (plain, late) = (run(&twin), run(&delayed(&twin)));
    // The loop takes delays for speed ripple, and so makes some.
    let ripple = |events: &[Event]| {
        let speeds = events.windows(2).map(|w| {
            (w[1].truth.angle_rad - w[0].truth.angle_rad).abs()
                / (w[1].truth.time_s - w[0].truth.time_s).abs()
        });
        speeds
            .map(|w| (w / (600.0 * RAD_S) - 1.0).abs())
            .fold(0.0, f64::max)
    };
    assert!(ripple(&plain) < 1e-4, "{}", ripple(&plain));
    assert!(ripple(&late) > 1e-3, "{}", ripple(&late));
}
