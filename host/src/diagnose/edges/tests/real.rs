//! Recordings of real machines. Those that are not shipped are looked for in the folder that `QUADCAL_RECORDINGS` names.

use std::path::PathBuf;

use super::*;
use crate::recording::{self, ReadOptions};

/// A recording's clock and rows, with channel A read from the first channel of a logic analyser.
fn read(path: PathBuf, analyser: bool) -> (u64, Vec<Row>) {
    let map = analyser.then(|| "a=Channel 0".parse().unwrap());
    let options = ReadOptions {
        map: map.into_iter().collect(),
        ..ReadOptions::default()
    };
    let recording = recording::open(&path, &options).unwrap();
    let clock_hz = recording.header.clock_hz;
    (clock_hz, recording.map(Result::unwrap).collect())
}

fn shipped(name: &str) -> (u64, Vec<Row>) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("recordings");
    read(folder.join(name), false)
}

/// None, said in a line, where the folder is not given.
fn kept(name: &str) -> Option<(u64, Vec<Row>)> {
    let Some(folder) = std::env::var_os("QUADCAL_RECORDINGS") else {
        println!("skipped: QUADCAL_RECORDINGS names no folder with {name}");
        return None;
    };
    let analyser = !name.starts_with("flywheel");
    Some(read(PathBuf::from(folder).join(name), analyser))
}

fn wheel(steps: &[usize], both_edges: bool) -> Sensor {
    Sensor::Wheel {
        present: teeth(steps),
        both_edges,
    }
}

/// Steps of the V6's wheel from behind its longest gap on.
fn v6() -> Vec<usize> {
    let ones = |n: usize| vec![1; n];
    [ones(10), vec![2], ones(10), vec![2], ones(9), vec![3]].concat()
}

fn turns(edges: &Edges) -> f64 {
    let way = edges.place[edges.len() - 1] - edges.place[0];
    way as f64 / f64::from(edges.grid_edges)
}

#[test]
fn hall_recordings_keep_all_edges_and_turns() {
    for (name, pole_pairs, count, whole, reverse) in [
        ("hall-spindle.csv", 2, 28_699, 2_391, 1),
        ("hall-hub-motor.csv", 15, 2_843, 31, 0),
        ("hall-spindle-sweep.csv", 2, 23_466, 1_955, 1),
        ("hall-speed-cycle.csv", 2, 10_621, 883, 8),
    ] {
        let (clock_hz, rows) = shipped(name);
        let edges = place(&Sensor::Hall { pole_pairs }, clock_hz, &rows).unwrap();
        assert_eq!(edges.len(), count, "{name}");
        assert_eq!(turns(&edges).floor(), f64::from(whole), "{name}");
        assert_eq!(edges.events, [], "{name}");
        let back = edges.forward.iter().filter(|&&forward| !forward).count();
        assert_eq!(back, reverse, "{name}");
        let fresh = edges.fresh.iter().filter(|&&fresh| fresh).count();
        assert_eq!(fresh, 1, "{name}");
    }
}

#[test]
fn a_running_36_2_1_wheel_is_found_with_both_gaps_and_loses_nothing() {
    let Some((clock_hz, rows)) = kept("wheel-36-2-1-running.csv") else {
        return;
    };
    let found = find_wheel(&rows, true).unwrap();
    let steps = [vec![1; 16], vec![2], vec![1; 15], vec![3]].concat();
    assert_eq!(found.present, teeth(&steps));
    assert!(found.confidence > 0.9, "{}", found.confidence);
    let sensor = Sensor::Wheel {
        present: found.present,
        both_edges: true,
    };
    let edges = place(&sensor, clock_hz, &rows).unwrap();
    assert!(edges.anchored);
    assert_eq!((&edges.events[..], &edges.unused[..]), (&[][..], &[][..]));
}

#[test]
fn a_60_2_wheel_is_followed_from_bounces_over_cranking_to_running() {
    let Some((clock_hz, rows)) = kept("wheel-60-2-cranking.csv") else {
        return;
    };
    let steps = [vec![1; 57], vec![3]].concat();
    let found = find_wheel(&rows, true).unwrap();
    assert_eq!(found.present, teeth(&steps));
    let edges = place(&wheel(&steps, true), clock_hz, &rows).unwrap();
    assert!(edges.anchored);
    assert_eq!(edges.events, []);
    let bounces = edges.unused.iter().find(|s| s.why == Unused::Bounces);
    let bounces = bounces.unwrap();
    assert!((1.5..1.6).contains(&bounces.from_s), "{bounces:?}");
    assert!((2.77..2.78).contains(&bounces.until_s), "{bounces:?}");
    assert!(edges.time_s[0] < 2.8, "starts at {}", edges.time_s[0]);
    assert_eq!(edges.fresh.iter().filter(|&&fresh| fresh).count(), 1);
}

#[test]
fn the_v6_wheel_is_found_with_plugs_out_and_followed_with_plugs_in() {
    let (Some((_, out)), Some((clock_hz, plugs_in))) = (
        kept("crank-v6-plugs-out.csv"),
        kept("crank-v6-plugs-in.csv"),
    ) else {
        return;
    };
    let found = find_wheel(&out, true).unwrap();
    assert_eq!(found.present, teeth(&v6()));
    let sensor = wheel(&v6(), true);
    let edges = place(&sensor, clock_hz, &out).unwrap();
    assert!(edges.anchored);
    assert_eq!((edges.len(), edges.events.len()), (497, 0));

    let edges = place(&sensor, clock_hz, &plugs_in).unwrap();
    assert!(edges.anchored);
    assert_eq!(edges.events, []);
    // It stops in a compression and rocks back.
    let rocking = edges.unused.last().unwrap();
    assert_eq!(rocking.why, Unused::OffPattern);
    assert!((7.59..7.66).contains(&rocking.from_s), "{rocking:?}");
    let last = edges.time_s[edges.len() - 1];
    assert!((7.58..7.60).contains(&last), "{last}");
    assert!(turns(&edges) > 12.5, "{}", turns(&edges));
}

#[test]
fn lost_pulses_of_three_magnets_are_told_from_swings_of_speed() {
    let Some((clock_hz, rows)) = kept("flywheel-lost-pulses.csv") else {
        return;
    };
    let edges = place(&wheel(&[1; 3], false), clock_hz, &rows).unwrap();
    let lost = events(&edges, CountKind::Lost, f64::INFINITY);
    assert!((230..=260).contains(&lost.len()), "{}", lost.len());
    let of = |n| lost.iter().filter(|event| event.edges == n).count();
    assert!((225..=245).contains(&of(1)), "{} single", of(1));
    assert!((11..=15).contains(&of(2)), "{} double", of(2));
    // Each stands between two edges that are as far apart as it says.
    for event in &lost {
        let next = edges.time_s.partition_point(|&t| t < event.time_s);
        let way = edges.place[next] - edges.place[next - 1];
        assert_eq!(way, i64::from(event.edges) + 1, "{event:?}");
        assert_eq!(event.place, edges.place[next - 1] + 1, "{event:?}");
    }
}

#[test]
fn six_magnets_are_found_and_none_is_lost() {
    let Some((clock_hz, rows)) = kept("flywheel-6-magnets.csv") else {
        return;
    };
    let found = find_wheel(&rows, false).unwrap();
    assert_eq!(found.present, [true; 6]);
    let edges = place(&wheel(&[1; 6], false), clock_hz, &rows).unwrap();
    assert_eq!((edges.len(), edges.events.len()), (rows.len(), 0));
    assert_eq!(turns(&edges), 10_500.0);
}
