//! The index slips against the disc.

use super::*;
use crate::twin::IndexSlip;

const STEP: f64 = TAU / 10_000.0;

fn slipping(r_min: f64, slips: &[(f64, i32)]) -> Vec<Event> {
    let mut twin = plain(r_min, 4.0);
    twin.index_slip = slips
        .iter()
        .map(|&(at_s, edges)| IndexSlip { at_s, edges })
        .collect();
    Simulation::new(&twin).unwrap().collect()
}

fn index(events: &[Event], class: Class) -> Vec<f64> {
    events
        .iter()
        .filter(|event| event.truth.class == class)
        .map(|event| event.truth.angle_rad / STEP)
        .collect()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-8, "{found:?}");
    }
}

#[test]
fn it_is_further_along_the_disc_from_then_on() {
    // 60 r/min: a turn a second.
    let events = slipping(60.0, &[(2.5, -3), (1.5, 7)]);
    near(
        &index(&events, Class::IndexRise),
        &[9_999.5, 20_006.5, 30_003.5],
    );
    let back = slipping(-60.0, &[(1.5, 7)]);
    near(
        &index(&back, Class::IndexFall),
        &[-9_999.5, -19_992.5, -29_992.5, -39_992.5],
    );
    let straight = slipping(60.0, &[]);
    let ticks = |events: &[Event]| -> Vec<u64> {
        let edges = events.iter().filter(|event| event.truth.edge.is_some());
        edges.map(|event| event.row.ticks).collect()
    };
    // Edges at whole ticks may be rounded to either.
    let both = ticks(&events).into_iter().zip(ticks(&straight));
    let apart: Vec<u64> = both.map(|(a, b)| a.abs_diff(b)).collect();
    assert!(apart.len() >= 39_999 && apart.iter().all(|apart| *apart <= 1));
}

#[test]
fn a_slip_under_the_head_changes_the_level_at_once() {
    // At 1 s the head is on edge 0, in the middle of the pulse, which goes on ahead and comes again.
    let events = slipping(60.0, &[(1.00001, 40)]);
    near(&index(&events, Class::IndexRise)[..2], &[9_999.5, 10_039.5]);
    let falls = index(&events, Class::IndexFall);
    near(&falls[1..3], &[10_000.1, 10_040.5]);
    // Half a step before edge 10 the pulse comes under the head.
    let events = slipping(60.0, &[(1.001, 10)]);
    near(&index(&events, Class::IndexRise)[..2], &[9_999.5, 10_010.0]);
    for pair in events.windows(2) {
        let changed = pair[0].row.levels.0 ^ pair[1].row.levels.0;
        assert_eq!(changed.count_ones(), 1, "{pair:?}");
    }
}
