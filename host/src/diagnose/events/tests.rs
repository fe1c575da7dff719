//! Events in recordings that the simulator makes.

mod none;

use std::collections::HashMap;

use quadcal::edge::Levels;

use super::{Event, events, undeclared};
use crate::diagnose::track::Track;
use crate::mechanism::Mechanism::{self, ExtraEdges, IndexSlip, LostEdges};
use crate::recording::Row;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::{Class, Simulation};
use crate::twin::{self, Drive, Duration, Encoder, Noise, Twin};

fn sensors() -> [Encoder; 4] {
    let quadrature = |index| Encoder::Quadrature { lines: 250, index };
    [
        quadrature(true),
        quadrature(false),
        Encoder::Hall { pole_pairs: 7 },
        Encoder::Wheel {
            teeth: 30,
            missing: 0,
            gaps: Vec::new(),
        },
    ]
}

fn plan(encoder: &Encoder) -> SensorPlan {
    let (kind, lines) = match *encoder {
        Encoder::Quadrature { lines, index } => {
            let index_state = index.then_some(Levels(Levels::A));
            (SensorKind::Quadrature { index_state }, lines)
        }
        Encoder::Hall { pole_pairs } => (SensorKind::Hall, pole_pairs),
        Encoder::Wheel { teeth, missing, .. } => {
            let missing = u16::try_from(missing).unwrap();
            let both_edges = true;
            (
                SensorKind::Wheel {
                    both_edges,
                    missing,
                },
                teeth,
            )
        }
    };
    SensorPlan { kind, lines }
}

/// A shaft that wanders, with a disc that is not perfect.
fn rig(encoder: &Encoder, seed: u64) -> Twin {
    let step = std::f64::consts::TAU / plan(encoder).shape().unwrap().edges() as f64;
    Twin {
        seed,
        encoder: encoder.clone(),
        duration: Duration::Turns(5.0),
        drive: Drive::Constant { r_min: 60.0 },
        ripple: Vec::new(),
        errors: twin::Errors {
            position: Some(twin::Position::Normal {
                rms_rad: 0.03 * step,
                per: twin::Per::Edge,
            }),
            width_a_rad: 0.2 * step,
            ..twin::Errors::default()
        },
        noise: Some(Noise::SpeedWander {
            rms_fraction: 0.005,
            correlation_rad: Some(1.0),
            hold_s: None,
        }),
        ..Twin::paper()
    }
}

fn track(twin: &Twin) -> Track {
    let rows: Vec<Row> = Simulation::new(twin)
        .unwrap()
        .map(|event| event.row)
        .collect();
    let rows = rows.into_iter().map(Ok::<_, PlanError>);
    Track::of(plan(&twin.encoder), twin.timer.clock_hz, rows).unwrap()
}

/// Places by time in ticks.
fn places(track: &Track) -> HashMap<i64, i64> {
    let marks = track.stretches.iter().flat_map(|stretch| &stretch.marks);
    marks
        .map(|mark| ((mark.time_s / track.tick_s).round() as i64, mark.place))
        .collect()
}

/// Every edge is where it is without the faults, or left out; few are.
fn holds_its_places(disturbed: &Track, clean: &Track, left_out_most: usize) {
    let (found, right) = (places(disturbed), places(clean));
    for (ticks, place) in &found {
        // A whole tick may be rounded to either.
        let near = (-1..=1).filter_map(|off| right.get(&(ticks + off)));
        assert!(
            near.clone().any(|right| right == place),
            "{ticks}: {place}, {near:?}"
        );
    }
    let left_out = right.len() - found.len();
    assert!(
        left_out <= left_out_most,
        "{left_out} of {} left out",
        right.len()
    );
    assert_eq!(disturbed.stretches.len(), clean.stretches.len());
}

fn all_of(events: &[Event], mechanism: Mechanism) {
    assert!(
        events.iter().all(|e| e.mechanism == mechanism),
        "{events:?}"
    );
}

#[test]
fn lost_edges_are_counted_through_whatever_the_sensor() {
    for encoder in &sensors() {
        for seed in 1..=4 {
            let clean = rig(encoder, seed);
            let edges = u64::from(plan(encoder).shape().unwrap().edges());
            let lost: Vec<u64> = (1..5)
                .map(|n| n * edges + seed * (37 + 11 * n) % 29 - 15)
                .collect();
            let mut lossy = clean.clone();
            lossy.faults.lost_edges.clone_from(&lost);
            let disturbed = track(&lossy);
            let found = events(&disturbed);
            all_of(&found, LostEdges);
            assert_eq!(found.len(), lost.len(), "{encoder:?} {seed}: {found:?}");
            let truth: Vec<_> = (Simulation::new(&clean).unwrap())
                .filter(|event| event.truth.edge.is_some())
                .collect();
            for (event, edge) in found.iter().zip(&lost) {
                let edge = usize::try_from(*edge).unwrap();
                let (at, before) = (truth[edge].truth.time_s, truth[edge - 1].truth.time_s);
                let off = (event.time_s - at).abs() / (at - before);
                assert!(off < 0.7, "{encoder:?} {seed}: {off} edges off");
                let changed = truth[edge].row.levels.0 ^ truth[edge - 1].row.levels.0;
                if changed.count_ones() == 1 {
                    let channel = usize::try_from(changed.trailing_zeros()).unwrap();
                    assert_eq!(event.channel, Some(channel), "{encoder:?} {seed}");
                }
            }
            // One channel's next edge shows no change and is lost too; its neighbours may be left out.
            holds_its_places(&disturbed, &track(&clean), 3 * lost.len());
        }
    }
}

#[test]
fn several_edges_lost_in_a_row_are_one_event_though_levels_agree() {
    for lost in 2..=4_u64 {
        for seed in 1..=4 {
            let clean = rig(&sensors()[1], seed);
            let mut lossy = clean.clone();
            lossy.faults.lost_edges = (0..lost).map(|n| 1700 + 13 * seed + n).collect();
            let disturbed = track(&lossy);
            let found = events(&disturbed);
            let sizes: Vec<i32> = found.iter().map(|event| event.edges).collect();
            // After three, the fourth shows the levels of before: it is no change, and lost as well.
            let missing = if lost == 3 { 4 } else { lost };
            assert_eq!(sizes, [i32::try_from(missing).unwrap()], "{lost} {seed}");
            holds_its_places(&disturbed, &track(&clean), 4);
        }
    }
}

#[test]
fn short_pulses_are_taken_out_whatever_the_sensor() {
    for encoder in &sensors() {
        let edges = f64::from(plan(encoder).shape().unwrap().edges());
        for seed in 1..=4 {
            let clean = rig(encoder, seed);
            let mut glitchy = clean.clone();
            // Far enough apart to be events of their own.
            glitchy.faults.glitch_probability = (0.7 / edges).min(0.005);
            glitchy.faults.glitch_width_s = 0.08 / edges;
            let rows = Simulation::new(&glitchy).unwrap();
            let pulses = rows.filter(|e| e.truth.class == Class::Glitch).count() / 2;
            let disturbed = track(&glitchy);
            let found = events(&disturbed);
            all_of(&found, ExtraEdges);
            assert_eq!(found.len(), pulses, "{encoder:?} {seed}: {found:?}");
            holds_its_places(&disturbed, &track(&clean), 2 * pulses);
        }
    }
}

#[test]
fn an_index_that_slips_moves_no_edge() {
    for (seed, (at_s, edges)) in (1..).zip([(1.6, 1), (2.4, -1), (2.9, 3), (3.3, -10), (1.2, 8)]) {
        for r_min in [60.0, -60.0] {
            let clean = Twin {
                drive: Drive::Constant { r_min },
                ..rig(&sensors()[0], seed)
            };
            let mut slipping = clean.clone();
            slipping.index_slip = vec![twin::IndexSlip { at_s, edges }];
            let disturbed = track(&slipping);
            let found = events(&disturbed);
            all_of(&found, IndexSlip);
            assert_eq!(found.len(), 1, "{seed}: {found:?}");
            assert_eq!(found[0].edges, edges);
            let [from_s, to_s] = found[0].between_s;
            assert!(
                from_s <= at_s && at_s <= to_s && to_s - from_s < 1.1,
                "{found:?}"
            );
            holds_its_places(&disturbed, &track(&clean), 0);
        }
    }
}

#[test]
fn an_index_that_slips_and_edges_lost_and_pulses_are_told_apart_in_one_recording() {
    for seed in 1..=4 {
        let clean = rig(&sensors()[0], seed);
        let mut disturbed = clean.clone();
        disturbed.faults.lost_edges = vec![1503, 3001 + seed];
        disturbed.faults.glitch_probability = 1e-3;
        disturbed.faults.glitch_width_s = 8e-5;
        disturbed.index_slip = vec![twin::IndexSlip {
            at_s: 2.5,
            edges: 4,
        }];
        let disturbed = track(&disturbed);
        let found = events(&disturbed);
        let count = |m| found.iter().filter(|e| e.mechanism == m).count();
        assert_eq!((count(LostEdges), count(IndexSlip)), (2, 1), "{found:?}");
        holds_its_places(&disturbed, &track(&clean), 40);
    }
}

#[test]
fn what_the_twin_declares_is_no_event() {
    let slip = "[[index_slip]]\nat_s = 0.2\nedges = 3\n";
    let lost = "[faults]\nlost_edges = [700, 701, 1500]\n";
    let often =
        "[faults]\nlost_probability = 2e-3\nglitch_probability = 1e-3\nglitch_width_s = 1e-6\n";
    for more in [slip, lost, often] {
        let twin = |more: &str| {
            let text = format!(
                "seed = 4\nduration = {{ turns = 20 }}\n[encoder.quadrature]\nlines = 100\nindex = true\n\
                 [shaft]\ninertia_kg_m2 = 1e-4\n[drive.constant]\nr_min = 600\n{more}\
                 [timer]\nclock_hz = 84000000\n"
            );
            Twin::parse(&text, "rig").unwrap()
        };
        let disturbed = track(&twin(more));
        assert!(!events(&disturbed).is_empty(), "{more}");
        assert_eq!(undeclared(&disturbed, &twin(more)), [], "{more}");
        assert_eq!(
            undeclared(&disturbed, &twin("")),
            events(&disturbed),
            "{more}"
        );
    }
}
