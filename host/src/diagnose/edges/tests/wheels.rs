//! Simulated wheels with gaps: how they are found, and where their edges are.

use std::f64::consts::TAU;

use super::simulated::{CLOCK_HZ, Draw, rig, rows, run, wrong};
use super::*;
use crate::effect::{Carrier, Effect, On, Site};
use crate::sim::Event;
use crate::twin::{DeclaredEffect, Drive, Encoder, Ripple, SpeedProfile, Step};

fn gapped(draw: &mut Draw) -> Vec<bool> {
    loop {
        let places = 12 + draw.below(49);
        let mut present = vec![true; places];
        for _ in 0..=draw.below(3) {
            let start = draw.below(places);
            for place in start..=start + draw.below(2) {
                present[place % places] = false;
            }
        }
        let rotated = |by: usize| (0..places).all(|n| present[n] == present[(n + by) % places]);
        if !(1..places).any(rotated) {
            return present;
        }
    }
}

/// A wheel whose speed swings by a fraction twice a turn, without one tooth of one turn.
fn swinging(seed: u64, present: &[bool], swing: f64, lost_turn: i64) -> Vec<Event> {
    swinging_at(2.0, seed, present, swing, lost_turn)
}

/// The same of a swing that comes so often a turn.
fn swinging_at(order: f64, seed: u64, present: &[bool], swing: f64, lost_turn: i64) -> Vec<Event> {
    let places = present.len();
    let encoder = Encoder::Wheel {
        gaps: Vec::new(),
        teeth: places as u32,
        missing: 0,
    };
    let mut twin = rig(seed, encoder, 600.0, 12.0);
    twin.ripple.push(Ripple {
        order,
        phase_rad: seed as f64,
        torque_n_m: None,
        speed_fraction: Some(swing),
    });
    twin.errors.position = Some(crate::twin::Position::Uniform {
        amplitude_rad: 0.03 * TAU / places as f64,
        per: crate::twin::Per::Edge,
    });
    let lost = present.iter().rposition(|&there| there);
    let mut events = run(&twin);
    events.retain(|event| {
        let Some(k) = event.truth.edge else {
            return true;
        };
        let tooth = k as usize / 2;
        let turn = (event.truth.angle_rad / TAU).floor() as i64;
        present[tooth] && !(turn == lost_turn && Some(tooth) == lost)
    });
    events
}

#[test]
fn wheels_of_any_gaps_are_placed_in_a_swinging_speed_and_a_lost_tooth_is_named() {
    for seed in 0..20 {
        let present = gapped(&mut Draw(seed));
        let events_seen = swinging(seed, &present, 0.3, 5);
        let sensor = Sensor::Wheel {
            present: present.clone(),
            both_edges: true,
        };
        let edges = place(&sensor, CLOCK_HZ, &rows(&events_seen)).unwrap();
        assert!(edges.anchored, "seed {seed}");
        let turn = i64::from(edges.grid_edges);
        assert_eq!(wrong(&edges, &events_seen, turn), 0, "seed {seed}");
        // The first row is a level and no edge; an edge of a tooth whose other one is outside is left out.
        assert!(edges.len() + 3 >= events_seen.len(), "seed {seed}");
        let lost: i32 = edges.events.iter().map(|event| event.edges).sum();
        let kinds = edges.events.iter().map(|event| event.kind);
        assert!(
            kinds.eq([CountKind::Lost]),
            "seed {seed}: {:?}",
            edges.events
        );
        assert_eq!(lost, 2, "seed {seed}");
    }
}

#[test]
fn wheels_of_any_gaps_are_found() {
    for seed in 0..20 {
        let present = gapped(&mut Draw(seed));
        let events = swinging(seed, &present, 0.1, i64::MAX);
        let found = find_wheel(&rows(&events), true).unwrap();
        let places = present.len();
        let same = |by: usize| (0..places).all(|n| found.present[n] == present[(n + by) % places]);
        assert!(
            found.present.len() == places && (0..places).any(same),
            "seed {seed}: {present:?} but {found:?}"
        );
        let sensor = Sensor::Wheel {
            present: found.present,
            both_edges: true,
        };
        let edges = place(&sensor, CLOCK_HZ, &rows(&events)).unwrap();
        assert!(!edges.inverted, "seed {seed}");
    }
}

#[test]
fn two_turns_of_a_wheel_on_a_four_stroke_engine_are_two() {
    // What the gap leaves of the speed repeats after two turns alone.
    for seed in 0..8 {
        let present = teeth(&[vec![1; 57], vec![3]].concat());
        let events = swinging_at(1.5, seed, &present, 0.1, i64::MAX);
        let found = find_wheel(&rows(&events), true).unwrap();
        assert_eq!(found.present, present, "seed {seed}");
    }
}

#[test]
fn gaps_may_be_high() {
    let present = teeth(&[1, 1, 1, 1, 1, 1, 1, 3]);
    let mut events = swinging(3, &present, 0.1, i64::MAX);
    for event in &mut events {
        event.row.levels.0 ^= Levels::A;
    }
    let found = find_wheel(&rows(&events), true).unwrap();
    assert_eq!(found.present, present);
    let sensor = Sensor::Wheel {
        present,
        both_edges: true,
    };
    let edges = place(&sensor, CLOCK_HZ, &rows(&events)).unwrap();
    assert!(edges.inverted && edges.anchored);
    // A tooth that is low falls at edge 2i + 1 and rises at 2i + 2.
    assert_eq!(wrong_by_one(&edges, &events), 0);
}

/// As [`wrong`], of places that are one more than those of teeth that are high.
fn wrong_by_one(edges: &Edges, events: &[Event]) -> usize {
    let mut shifted = edges.clone();
    shifted.place.iter_mut().for_each(|place| *place -= 1);
    wrong(&shifted, events, i64::from(edges.grid_edges))
}

#[test]
fn a_swing_of_the_speed_is_no_stop() {
    for seed in 0..5 {
        let present = vec![true; 36];
        let events = swinging(seed, &present, 0.3, -1);
        let sensor = Sensor::Wheel {
            present,
            both_edges: true,
        };
        let edges = place(&sensor, CLOCK_HZ, &rows(&events)).unwrap();
        let mut twin = rig(
            seed,
            Encoder::Quadrature {
                lines: 1,
                index: false,
            },
            600.0,
            1.0,
        );
        twin.drive = Drive::Unknown;
        assert_eq!(turned(edges.clone(), &twin).unwrap(), edges);
    }
}

#[test]
fn edges_off_their_places_beside_a_gap_are_no_stop_of_a_slow_wheel() {
    for seed in 0..5 {
        let encoder = Encoder::Wheel {
            gaps: Vec::new(),
            teeth: 60,
            missing: 2,
        };
        let mut twin = rig(seed, encoder, 200.0, 40.0);
        let points = [(0.0, 200.0), (4.0, 200.0), (6.0, 1800.0), (9.0, 1800.0)];
        let points = points.map(|(t_s, r_min)| Step { t_s, r_min });
        twin.drive = Drive::Profile(SpeedProfile::new(points.to_vec()));
        // The first rise after the gap comes a third of a tooth early, as a pick-up coil has it.
        let rises = On {
            channel: None,
            rises: Some(true),
        };
        let shift = Effect::new(Site::Disc(rises), Carrier::Bump(0.0, 0.01));
        twin.effect.extend(DeclaredEffect::of(&shift, &[0.035]));
        let present: Vec<bool> = (0..60).map(|tooth| tooth < 58).collect();
        let sensor = Sensor::Wheel {
            present,
            both_edges: true,
        };
        let edges = place(&sensor, CLOCK_HZ, &rows(&run(&twin))).unwrap();
        twin.drive = Drive::Unknown;
        assert_eq!(turned(edges.clone(), &twin).unwrap(), edges, "{seed}");
    }
}
