//! Recordings of real Hall motors: what the core learns from one half holds on the other.
#![allow(clippy::cast_precision_loss, clippy::result_large_err, missing_docs)]

use std::path::{Path, PathBuf};

use quadcal_host::calibrate::{CalibrateOptions, Calibration, calibrate};
use quadcal_host::recording::{ReadOptions, open};
use quadcal_host::survey::Survey;
use quadcal_host_tests::accuracy::{rms, table_rad};

fn recording(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../host/recordings")
        .join(name)
}

fn first_half(path: &Path) -> (Calibration, u64) {
    let options = ReadOptions::default();
    let rows = open(path, &options).unwrap();
    let survey = Survey::of(rows.header.clone(), rows).unwrap();
    let middle = survey.first.midpoint(survey.last);
    let half = CalibrateOptions {
        until: Some(middle),
        ..CalibrateOptions::default()
    };
    (calibrate(|| open(path, &options), &half).unwrap(), middle)
}

/// Times of all edges: every row after the first, which is the level at the start.
fn edge_times(path: &Path) -> Vec<u64> {
    open(path, &ReadOptions::default())
        .unwrap()
        .skip(1)
        .map(|row| row.unwrap().ticks)
        .collect()
}

/// An interval over the mean of the whole turn around it.
struct Relative {
    slot: usize,
    time: u64,
    /// The turn's duration, ticks.
    turn: f64,
    share: f64,
}

fn relative(times: &[u64], edges: usize) -> Vec<Relative> {
    (edges..times.len() - edges)
        .map(|k| {
            let turn = (times[k + edges / 2] - times[k - edges / 2]) as f64;
            Relative {
                slot: k % edges,
                time: times[k],
                turn,
                share: (times[k] - times[k - 1]) as f64 * edges as f64 / turn,
            }
        })
        .collect()
}

#[test]
fn a_spindle_s_table_scatters_no_more_on_the_other_half_than_the_best_fixed_pattern_in_f64() {
    let path = recording("hall-spindle.csv");
    let (calibration, middle) = first_half(&path);
    let edges = calibration.solution.shape().edges() as usize;
    assert_eq!(edges, 12);
    let all = relative(&edge_times(&path), edges);
    let (first, second): (Vec<_>, Vec<_>) = all
        .into_iter()
        .partition(|interval| interval.time <= middle);

    // Least squares on the first half: the mean of every slot.
    let mut best = vec![(0.0, 0.0); edges];
    for Relative { slot, share, .. } in &first {
        best[*slot] = (best[*slot].0 + share, best[*slot].1 + 1.0);
    }
    let best: Vec<f64> = best.iter().map(|(sum, count)| sum / count).collect();

    let error = table_rad(&calibration.solution);
    let step = std::f64::consts::TAU / edges as f64;
    let delays = calibration.solution.class_delays().unwrap();
    let late = |edge: usize| f64::from(delays.of_class[edge % 6].0) / 256.0;
    // The first edge that the decoder counts is edge 1 or the like; the pattern tells which.
    let ours = |shift: usize, slot: usize, turn: f64| {
        let (here, before) = ((slot + shift) % edges, (slot + shift + edges - 1) % edges);
        let delay = (late(here) - late(before)) * edges as f64 / turn;
        1.0 - (error[here] - error[before]) / step + delay
    };
    let scatter = |predicted: &dyn Fn(usize, f64) -> f64| {
        rms(&second
            .iter()
            .map(|interval| interval.share - predicted(interval.slot, interval.turn))
            .collect::<Vec<_>>())
    };
    let mine = (0..edges)
        .map(|shift| scatter(&|slot, turn| ours(shift, slot, turn)))
        .fold(f64::INFINITY, f64::min);
    let (raw, theirs) = (scatter(&|_, _| 1.0), scatter(&|slot, _| best[slot]));
    println!(
        "interval scatter, second half: raw {raw:.5}, best fixed pattern {theirs:.5}, quadcal {mine:.5}"
    );
    assert!(mine <= theirs, "{mine} {theirs}");
    assert!(mine < 0.5 * raw);
}

#[test]
fn the_turn_of_each_hall_motor_is_found() {
    for (name, pole_pairs) in [("hall-spindle.csv", 2), ("hall-hub-motor.csv", 15)] {
        let (calibration, _) = first_half(&recording(name));
        assert_eq!(calibration.plan.lines, pole_pairs, "{name}");
    }
}
