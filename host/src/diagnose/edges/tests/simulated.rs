//! Simulated shafts, whose places are known.

use std::f64::consts::TAU;

use super::*;
use crate::sim::{Event, Simulation};
use crate::twin::{Drive, Duration, Encoder, Errors, Faults, SpeedProfile, Step, Twin};

pub(super) const CLOCK_HZ: u64 = 10_000_000;

/// Random numbers below `below`, of a seed (splitmix64).
pub(super) struct Draw(pub(super) u64);

impl Draw {
    pub(super) fn below(&mut self, below: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % below as u64) as usize
    }
}

pub(super) fn rig(seed: u64, encoder: Encoder, r_min: f64, turns: f64) -> Twin {
    let mut twin = Twin::paper();
    twin.seed = seed;
    twin.encoder = encoder;
    twin.errors = Errors::default();
    twin.ripple.clear();
    twin.drive = Drive::Constant { r_min };
    twin.duration = Duration::Turns(turns);
    twin.timer.clock_hz = CLOCK_HZ;
    twin
}

pub(super) fn run(twin: &Twin) -> Vec<Event> {
    Simulation::new(twin).unwrap().collect()
}

pub(super) fn rows(events: &[Event]) -> Vec<Row> {
    events.iter().map(|event| event.row).collect()
}

/// Number of edges whose place is not the true one, but for a shift of all by some multiple of `whole` edges: turns, or lines and pole
/// pairs where nothing tells them apart.
pub(super) fn wrong(edges: &Edges, events: &[Event], whole: i64) -> usize {
    let n = i64::from(edges.grid_edges);
    let mut true_places = std::collections::HashMap::new();
    for event in events {
        if let Some(k) = event.truth.edge {
            let turn = (event.truth.angle_rad / TAU - f64::from(k) / n as f64).round() as i64;
            let time_s = event.row.ticks as f64 * edges.tick_s;
            true_places.insert(time_s.to_bits(), turn * n + i64::from(k));
        }
    }
    let off: Vec<i64> = edges
        .time_s
        .iter()
        .zip(&edges.place)
        .map(|(time_s, place)| place - true_places.get(&time_s.to_bits()).unwrap_or(&i64::MAX))
        .collect();
    let shift = off[off.len() / 2];
    assert_eq!(shift % whole, 0, "shifted by {shift}");
    off.iter().filter(|&&off| off != shift).count()
}

/// A wheel of some gaps that no rotation maps on itself.

#[test]
fn one_pulse_and_three_edges_a_turn_are_placed() {
    for pulses in [1, 3] {
        let encoder = Encoder::Wheel {
            gaps: Vec::new(),
            teeth: pulses,
            missing: 0,
        };
        let events = run(&rig(1, encoder, 900.0, 40.0));
        let rises: Vec<Row> = rows(&events).into_iter().step_by(2).collect();
        let sensor = Sensor::Wheel {
            present: vec![true; pulses as usize],
            both_edges: false,
        };
        let edges = place(&sensor, CLOCK_HZ, &rises).unwrap();
        assert_eq!(edges.len(), rises.len());
        let on = edges.place.windows(2).all(|pair| pair[1] == pair[0] + 1);
        assert!(on && edges.events.is_empty() && edges.unused.is_empty());
    }
}

/// Forward, back and forward again.
fn to_and_fro(encoder: Encoder) -> Twin {
    let mut twin = rig(1, encoder, 60.0, 1.0);
    twin.duration = Duration::Seconds(3.0);
    twin.shaft.stiffness_n_m_s = 1e-3;
    let steps = [(0.0, 60.0), (1.0, -90.0), (2.0, 45.0)];
    twin.drive = Drive::Steps(
        steps
            .into_iter()
            .map(|(t_s, r_min)| Step { t_s, r_min })
            .collect(),
    );
    twin
}

#[test]
fn reversing_sensors_with_a_code_are_placed() {
    let hall = Encoder::Hall { pole_pairs: 7 };
    let quadrature = Encoder::Quadrature {
        lines: 500,
        index: true,
    };
    for (encoder, sensor, whole, classes) in [
        (hall, Sensor::Hall { pole_pairs: 7 }, 6, 6),
        (quadrature, indexed(500), 2_000, 4),
    ] {
        let events = run(&to_and_fro(encoder.clone()));
        let edges = place(&sensor, CLOCK_HZ, &rows(&events)).unwrap();
        assert_eq!(wrong(&edges, &events, whole), 0, "{encoder:?}");
        assert_eq!(edges.events, [], "{encoder:?}");
        assert!(edges.forward.contains(&false) && edges.forward.contains(&true));
        assert_eq!(edges.classes, classes, "{encoder:?}");
    }
}

fn indexed(lines: u32) -> Sensor {
    Sensor::Quadrature {
        lines,
        index: Some(Levels(Levels::A)),
    }
}

#[test]
fn lost_edges_and_glitches_of_a_quadrature_encoder_are_counted_through() {
    let encoder = Encoder::Quadrature {
        lines: 100,
        index: true,
    };
    let mut twin = rig(2, encoder, 60.0, 6.0);
    twin.faults = Faults {
        lost_edges: vec![
            300, 700, 701, 1_100, 1_101, 1_102, 1_500, 1_501, 1_502, 1_503,
        ],
        glitch_probability: 0.005,
        glitch_width_s: 2e-5,
        ..Faults::default()
    };
    let events = run(&twin);
    let edges = place(&indexed(100), CLOCK_HZ, &rows(&events)).unwrap();
    assert!(edges.anchored);
    assert_eq!(wrong(&edges, &events, 400), 0);
    let lost = super::events(&edges, CountKind::Lost, f64::INFINITY);
    let counts: Vec<i32> = lost.iter().map(|event| event.edges).collect();
    // With three lost, the fourth shows the levels that were there before, and no change.
    assert_eq!(counts, [1, 2, 4, 4]);
    let glitches = events
        .iter()
        .filter(|event| event.truth.class == crate::sim::Class::Glitch)
        .count();
    let extra = super::events(&edges, CountKind::Extra, f64::INFINITY);
    let rows: i32 = extra.iter().map(|event| event.edges).sum();
    assert_eq!((rows as usize, glitches > 10), (glitches, true));
}

#[test]
fn an_index_that_slips_is_an_event_and_moves_no_place() {
    let encoder = Encoder::Quadrature {
        lines: 100,
        index: true,
    };
    let mut twin = rig(2, encoder, 60.0, 6.0);
    twin.index_slip = vec![crate::twin::IndexSlip {
        at_s: 2.5,
        edges: 3,
    }];
    let events = run(&twin);
    let edges = place(&indexed(100), CLOCK_HZ, &rows(&events)).unwrap();
    assert_eq!(wrong(&edges, &events, 400), 0);
    let [slip] = edges.events[..] else {
        panic!("{:?}", edges.events);
    };
    assert_eq!((slip.kind, slip.edges), (CountKind::IndexSlip, 3));
    assert!((2.5..3.6).contains(&slip.time_s), "{slip:?}");
}

#[test]
fn an_index_in_which_the_shaft_turns_round_has_not_slipped() {
    let encoder = Encoder::Quadrature {
        lines: 60,
        index: true,
    };
    // Ten turns on, and back, from places within two lines before the index.
    for part in 0..32 {
        let mut twin = rig(4, encoder.clone(), 300.0, 1.0);
        twin.duration = Duration::Seconds(5.0);
        twin.shaft.initial_angle_rad = -TAU * f64::from(part) / (16.0 * 60.0);
        let (on, back) = (300.0, -300.0);
        let points = [(0.0, 0.0), (0.3, on), (2.0, on), (2.3, 0.0), (2.5, 0.0)]
            .into_iter()
            .chain([(2.8, back), (4.5, back), (4.8, 0.0)]);
        let points = points.map(|(t_s, r_min)| Step { t_s, r_min });
        twin.drive = Drive::Profile(SpeedProfile::new(points.collect()));
        let edges = place(&indexed(60), CLOCK_HZ, &rows(&run(&twin))).unwrap();
        assert_eq!(edges.events, [], "{part}");
    }
}

#[test]
fn one_channel_whose_drive_nobody_declared_is_used_between_stops() {
    for teeth in [12, 36, 103] {
        let encoder = Encoder::Wheel {
            gaps: Vec::new(),
            teeth,
            missing: 0,
        };
        let mut twin = rig(1, encoder, 60.0, 24.0);
        // It turns back after 5 s and goes on to the other side.
        twin.drive = Drive::Ramp {
            from_r_min: 120.0,
            to_r_min: -180.0,
            over_s: 12.5,
        };
        let events = run(&twin);
        let sensor = Sensor::Wheel {
            present: vec![true; teeth as usize],
            both_edges: true,
        };
        let edges = place(&sensor, CLOCK_HZ, &rows(&events)).unwrap();
        twin.drive = Drive::Unknown;
        let used = turned(edges.clone(), &twin).unwrap();
        let either = used.unused.iter();
        let either = either.filter(|stretch| stretch.why == Unused::EitherWay);
        assert_eq!(either.count(), 1, "{teeth}");
        // One side alone, and nearly all of it.
        let (first, last) = (used.time_s[0], used.time_s[used.time_s.len() - 1]);
        assert!(last < 5.0 || first > 5.0, "{teeth}: {first} to {last}");
        assert!(used.time_s.len() > edges.time_s.len() / 2, "{teeth}");
    }
}

#[test]
fn a_shaft_that_stands_still_for_a_while_and_goes_on_makes_no_pulse_too_many() {
    for lines in [60, 1250] {
        let encoder = Encoder::Quadrature {
            lines,
            index: false,
        };
        let mut twin = rig(1, encoder, 60.0, 4.0);
        let point = |(t_s, r_min)| Step { t_s, r_min };
        let points = [
            (0.0, -82.0),
            (1.0, -82.0),
            (2.0, 0.0),
            (2.6, 0.0),
            (3.6, -60.0),
        ];
        twin.drive = Drive::Profile(SpeedProfile::new(points.map(point).to_vec()));
        let edges = place(
            &Sensor::Quadrature { lines, index: None },
            CLOCK_HZ,
            &rows(&run(&twin)),
        );
        assert_eq!(edges.unwrap().events, [], "{lines}");
    }
}

/// Rows of a quadrature encoder whose shaft goes so many edges on, each so long after the one before, s.
fn stepped(steps: &[(i64, f64)]) -> Vec<Row> {
    let levels = [0, Levels::A, Levels::A | Levels::B, Levels::B];
    let (mut at, mut ticks) = (0_i64, 0_u64);
    let each = steps.iter().map(|&(by, after_s)| {
        at += by;
        ticks += (after_s * CLOCK_HZ as f64) as u64;
        Row {
            ticks,
            levels: Levels(levels[at.rem_euclid(4) as usize]),
        }
    });
    each.collect()
}

#[test]
fn a_shaft_that_rocks_about_an_edge_where_it_stands_makes_no_pulse_too_many() {
    let mut steps = Vec::new();
    let mut go = |by: i64, after_s: f64| steps.push((by, after_s));
    // It slows down as a drive with some lag has it.
    for edge in 0..400 {
        let uneven = if edge % 2 == 0 { 0.96 } else { 1.04 };
        go(1, 0.006 * uneven / (1.0 - 0.002 * f64::from(edge)));
    }
    for after_s in [0.033, 0.034, 0.041, 0.041, 0.052, 0.059, 0.101] {
        go(1, after_s);
    }
    let rocks = [
        (-1, 1.253),
        (1, 0.011),
        (-1, 0.17),
        (1, 0.04),
        (-1, 0.03),
        (1, 0.397),
        (-1, 1.811),
        (-1, 1.82),
        (1, 0.331),
        (-1, 1.215),
        (-1, 0.388),
        (1, 0.897),
        (-1, 0.647),
        (-1, 1.459),
        (-1, 0.477),
        (-1, 0.119),
        (-1, 0.078),
    ];
    rocks.into_iter().for_each(|(by, after_s)| go(by, after_s));
    (0..200).for_each(|edge| go(-1, 0.066 / (1.0 + f64::from(edge)).sqrt()));
    let sensor = Sensor::Quadrature {
        lines: 200,
        index: None,
    };
    let edges = place(&sensor, CLOCK_HZ, &stepped(&steps)).unwrap();
    assert_eq!(edges.events, []);
    // The first row only says where it is.
    assert_eq!(edges.place.len(), steps.len() - 1);
}

#[test]
fn edges_that_a_capture_held_from_before_are_not_used() {
    let mut steps = vec![(1, 1e-6); 7];
    steps.extend([(1, 5e-3); 100]);
    let sensor = Sensor::Quadrature {
        lines: 200,
        index: None,
    };
    let edges = place(&sensor, CLOCK_HZ, &stepped(&steps)).unwrap();
    assert_eq!((edges.len(), edges.events.len()), (100, 0));
    let [one] = edges.unused[..] else {
        panic!("{:?}", edges.unused);
    };
    assert_eq!((one.rows, one.why), (6, Unused::Bounces));
    // A shaft that starts from rest, or slows down to it, is used from its first edge on.
    let fall = |edge: i32| 0.01 * (f64::from(edge + 1).sqrt() - f64::from(edge).sqrt());
    let start: Vec<(i64, f64)> = (0..100).map(|edge| (1, fall(edge))).collect();
    let stop: Vec<(i64, f64)> = start.iter().rev().copied().collect();
    for steps in [start, stop] {
        let edges = place(&sensor, CLOCK_HZ, &stepped(&steps)).unwrap();
        assert_eq!((edges.len(), edges.unused.len()), (99, 0));
    }
}

#[test]
fn a_pulse_of_one_channel_that_is_missing_is_lost_and_no_reversal() {
    let twin = rig(
        3,
        Encoder::Quadrature {
            lines: 60,
            index: true,
        },
        600.0,
        6.0,
    );
    let sensor = indexed(60);
    let whole = rows(&run(&twin));
    let all = place(&sensor, CLOCK_HZ, &whole).unwrap();
    for channel in [Levels::A, Levels::B] {
        // A pulse of the channel, none of whose rows came: the others show its level as it was before.
        let high = |row: &Row| row.levels.0 & channel != 0;
        let rises = (400..)
            .find(|at| !high(&whole[at - 1]) && high(&whole[*at]))
            .unwrap();
        let falls = (rises..).find(|at| !high(&whole[*at])).unwrap();
        let mut rows = whole.clone();
        for row in &mut rows[rises..falls] {
            row.levels = Levels(row.levels.0 & !channel);
        }
        rows.remove(falls);
        rows.remove(rises);
        let edges = place(&sensor, CLOCK_HZ, &rows).unwrap();
        assert_eq!(edges.place.last(), all.place.last());
        let lost = super::events(&edges, CountKind::Lost, f64::INFINITY);
        assert_eq!(lost.iter().map(|event| event.edges).sum::<i32>(), 2);
        assert_eq!(edges.events.len(), lost.len(), "{:?}", edges.events);
        assert!(edges.forward.iter().all(|forward| *forward));
    }
}

#[test]
fn a_shaft_that_rocks_about_an_edge_and_then_turns_back_makes_no_pulse_too_many() {
    let mut steps = Vec::new();
    let mut go = |by: i64, after_s: f64| steps.push((by, after_s));
    // Braked evenly to a stop, and off again.
    let apart = |edge: u32| f64::from(edge + 1).sqrt() - f64::from(edge).sqrt();
    for edge in (1..300).rev() {
        let uneven = [0.98, 1.01, 1.03, 0.98][edge as usize % 4];
        go(1, 0.0168 * uneven * apart(edge));
    }
    // Each of these is a wait, and no speed.
    let waits = [(1, 0.3557), (-1, 0.3826), (-1, 0.5183)];
    waits.into_iter().for_each(|(by, after_s)| go(by, after_s));
    go(-1, 0.0158);
    (1..300).for_each(|edge| go(-1, 0.028 * apart(edge)));
    let sensor = Sensor::Quadrature {
        lines: 60,
        index: None,
    };
    let edges = place(&sensor, CLOCK_HZ, &stepped(&steps)).unwrap();
    assert!(edges.events.is_empty(), "{:?}", edges.events);
}

#[test]
fn a_slow_shaft_may_be_turned_back_as_hard_as_it_was_braked() {
    let mut steps = Vec::new();
    let mut go = |by: i64, after_s: f64| steps.push((by, after_s));
    let uneven = |edge: i32| [0.99, 1.0, 1.02, 0.99][edge as usize % 4];
    (0..400).for_each(|edge| go(1, 1e-3 * uneven(edge)));
    // Braked by 2,000 edges a second each second, until it creeps.
    let speed = |edge: i32| f64::from(4_000 * edge).sqrt();
    (3..250)
        .rev()
        .for_each(|edge| go(1, uneven(edge) / speed(edge)));
    // It creeps, ever slower, and is driven back within one interval: the edges look like a pulse too many beside lost ones.
    (0..60).for_each(|edge| go(1, 0.015 * 1.02_f64.powi(edge) * (0.9 + 0.1 * uneven(edge))));
    for after_s in [
        0.054, 0.0328, 0.0195, 0.0149, 0.0133, 0.0127, 0.0107, 0.0097, 0.0093,
    ] {
        go(-1, after_s);
    }
    (6..250).for_each(|edge| go(-1, uneven(edge) / speed(edge)));
    let sensor = Sensor::Quadrature {
        lines: 20,
        index: None,
    };
    let edges = place(&sensor, CLOCK_HZ, &stepped(&steps)).unwrap();
    assert!(edges.events.is_empty(), "{:?}", edges.events);
    let back = edges.forward.iter().filter(|forward| !**forward);
    assert_eq!(back.count(), 9 + 244);
}
