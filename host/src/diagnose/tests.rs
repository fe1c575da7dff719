//! What is left of a recording whose twin knows all.

mod class_errors;
mod disc_parts;
mod drawn;
mod inertia;
mod late_fall;
mod reversal;
mod run_down;
mod second_mass;
mod slow_changes;
mod speed_loop;
mod stamps;
mod starts;
mod task;
mod two_speeds;
mod unknown_disc;
mod where_it_shows;

use quadcal::edge::Levels;

use super::basis::Basis;
use super::disc;
use super::prepare;
use super::repeats::repeats;
use super::run::Recorded;
use super::ties::{self, Tie};
use super::track::Track;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::{Encoder, Twin};

/// A recording of one twin held against another.
fn recorded(truth: &Twin, told: &Twin) -> Recorded {
    let (kind, lines) = match truth.encoder {
        Encoder::Hall { pole_pairs } => (SensorKind::Hall, pole_pairs),
        Encoder::Quadrature { lines, index } => {
            let index_state = index.then_some(Levels(Levels::A));
            (SensorKind::Quadrature { index_state }, lines)
        }
        Encoder::Wheel { teeth, .. } => {
            let kind = SensorKind::Wheel {
                both_edges: true,
                missing: 0,
            };
            (kind, teeth)
        }
    };
    let plan = SensorPlan { kind, lines };
    let rows = Simulation::new(truth).unwrap();
    let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
    Recorded {
        file: String::new(),
        plan,
        track: Track::of(plan, truth.timer.clock_hz, rows).unwrap(),
        twin: told.clone(),
    }
}

fn twin(text: &str) -> Twin {
    Twin::parse(text, "rig").unwrap()
}

/// Mean square of the white residual and the greatest of it.
fn left(truth: &Twin, told: &Twin) -> (f64, f64) {
    let board = prepare::board(&[recorded(truth, told)]).unwrap();
    let white = &board.benches[0].white;
    let mean = white.iter().map(|w| w * w).sum::<f64>() / white.len() as f64;
    (mean, white.iter().fold(0.0, |most, w| most.max(w.abs())))
}

/// Ripple that turns by a good part of a cycle from edge to edge, and swings the shaft by more than a linear model allows.
#[test]
fn a_strong_ripple_between_a_hall_sensors_few_edges_is_taken_off_whole() {
    let rig = twin(
        "duration = { turns = 60 }\nseed = 5\n[encoder.hall]\npole_pairs = 2\n[shaft]\n\
         inertia_kg_m2 = 1.4e-3\nviscous_n_m_s = 1.5e-4\ncoulomb_n_m = 5e-4\n\
         [drive.run_down]\nr_min = 660\noff_s = 0.5\n\
         [[ripple]]\norder = 10\ntorque_n_m = 0.13\nphase_rad = 1\n\
         [[ripple]]\norder = 15\ntorque_n_m = 0.4\nphase_rad = 2\n\
         [noise.white]\npsd_n2_m2_s = 1e-8\n[timer]\nclock_hz = 84000000\njitter_s = 2e-7\n",
    );
    let (mean, most) = left(&rig, &rig);
    assert!((mean - 1.0).abs() < 0.2 && most < 4.5, "{mean} {most}");
}

const STEADY: &str = "duration = { turns = 40 }\nseed = 3\n[encoder.quadrature]\nlines = 60\nindex = false\n\
                      [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
                      [drive.constant]\nr_min = 240\n[noise.white]\npsd_n2_m2_s = 1e-12\n\
                      [timer]\nclock_hz = 84000000\njitter_s = 1e-7\n";

/// Stamps don't say whether a loop saw an edge: with the push it did not give nothing changes, with the one it gave it is taken off.
#[test]
fn a_push_that_stamps_leave_open_is_settled_by_the_edges_after_it() {
    let rig = twin(STEADY);
    let mut bench = prepare::board(&[recorded(&rig, &rig)])
        .unwrap()
        .benches
        .remove(0);
    let at_s = bench.seen.times_s[bench.seen.len() / 2];
    let tie = Tie {
        at_s,
        until_s: at_s + 2e-3,
        apart_s: 1e-8,
        push: 40.0,
        after: 0.0,
        turned: false,
    };
    let before = bench.seen.angles.clone();
    bench.seen.ties = vec![tie];
    assert!(!ties::decide(&mut bench));
    assert_eq!(bench.seen.angles, before);

    let load = Basis::Load {
        from_s: tie.at_s,
        until_s: tie.until_s,
    };
    let column = load.columns(&bench.seen, &bench.law).remove(0);
    let size = tie.push * bench.law.inertia;
    let swung = column.iter().map(|value| size * value);
    let most = swung
        .clone()
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    for (angle, value) in bench.seen.angles.iter_mut().zip(swung) {
        *angle += value;
    }
    bench.set_noise(bench.noise);
    bench.seen.ties = vec![tie];
    assert!(ties::decide(&mut bench));
    let off = bench.seen.angles.iter().zip(&before);
    let off = off.fold(0.0, |most: f64, (now, before)| {
        most.max((now - before).abs())
    });
    assert!(off < 0.02 * most, "{off} of {most}");
}

#[test]
fn a_discs_own_pattern_comes_again_and_noise_that_is_more_than_declared_does_not() {
    let told = twin(STEADY);
    let line = twin(&format!(
        "{STEADY}[errors.position.normal]\nrms_rad = 1e-4\n"
    ));
    let noisy = twin(&STEADY.replace("jitter_s = 1e-7", "jitter_s = 4e-7"));
    let shares = |truth: &Twin| {
        let board = prepare::board(&[recorded(truth, &told)]).unwrap();
        let model = board.fit(board.nuisances()).unwrap();
        let pattern = disc::pattern(&board, &model, false).unwrap();
        let shares = disc::comes_again(&board, &model.left, pattern.white_rad);
        (pattern.score, shares)
    };
    let (score, own) = shares(&line);
    assert!(score > 1000.0, "{score}");
    assert!(
        own.iter().all(|(share, _)| (share - 1.0).abs() < 0.1),
        "{own:?}"
    );
    let (_, none) = shares(&noisy);
    assert!(none.iter().all(|(share, _)| share.abs() < 0.35), "{none:?}");
}

#[test]
fn of_what_has_no_name_a_disc_comes_again_each_turn_and_noise_does_not() {
    let told = twin(STEADY);
    let share = |truth: &str| {
        let board = prepare::board(&[recorded(&twin(truth), &told)]).unwrap();
        repeats(&board, &board.white()).unwrap()
    };
    let disc = share(&format!(
        "{STEADY}[errors.position.normal]\nrms_rad = 1e-4\n"
    ));
    assert!((disc.share - 1.0).abs() < 0.05, "{disc:?}");
    let noise = share(&STEADY.replace("jitter_s = 1e-7", "jitter_s = 4e-7"));
    assert!(noise.share < 0.05, "{noise:?}");
}
