//! The spread of recordings whose twins lack a known error.

use super::*;
use crate::diagnose::prepare;
use crate::diagnose::run::Recorded;
use crate::diagnose::track::Track;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::Twin;

/// A shaft that wanders little.
const RIG: &str = "[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
                   [noise.white]\npsd_n2_m2_s = 1e-15\n[timer]\nclock_hz = 84000000\njitter_s = 1e-7\n";

fn twin(text: &str) -> Twin {
    Twin::parse(&format!("{text}{RIG}"), "rig").unwrap()
}

fn board(truth: &Twin, told: &Twin, kind: SensorKind, lines: u32) -> Board {
    let plan = SensorPlan { kind, lines };
    let rows = Simulation::new(truth).unwrap();
    let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
    let one = Recorded {
        file: String::new(),
        plan,
        track: Track::of(plan, truth.timer.clock_hz, rows).unwrap(),
        twin: told.clone(),
    };
    prepare::board(&[one]).unwrap()
}

/// Before, floor: turn by turn and slow.
fn spreads(board: &Board) -> [f64; 4] {
    let (was, noise) = (
        spread(board, &board.white(), 0..PARTS),
        floor(board, 0..PARTS),
    );
    [
        was.fast_rad(),
        noise.fast_rad(),
        was.slow_rad(),
        noise.slow_rad(),
    ]
}

const QUADRATURE: SensorKind = SensorKind::Quadrature { index_state: None };

#[test]
fn an_error_once_a_turn_has_its_whole_size_and_without_it_there_is_the_floor() {
    let disc = "[encoder.quadrature]\nlines = 50\n[errors]\n";
    let ecc = "eccentricity = { amplitude_rad = 1e-3, phase_rad = 0.7 }\n";
    for drive in [
        "[drive.constant]\nr_min = 120\n",
        "[drive.constant]\nr_min = -120\n",
        "[drive.ramp]\nfrom_r_min = 60\nto_r_min = 240\nover_s = 20\n",
        "[drive.ramp]\nfrom_r_min = 150\nto_r_min = -150\nover_s = 20\n",
    ] {
        for length in ["duration = { turns = 30 }\n", "duration = { turns = 5 }\n"] {
            let told = twin(&format!("{length}{disc}{drive}"));
            let truth = twin(&format!("{length}{disc}{ecc}{drive}"));
            let [was, noise, ..] = spreads(&board(&truth, &told, QUADRATURE, 50));
            let expected = 1e-3 / 2_f64.sqrt();
            assert!((was / expected - 1.0).abs() < 0.05, "{was} {drive}");
            let [alone, ..] = spreads(&board(&told, &told, QUADRATURE, 50));
            assert!(noise < 0.1 * was, "{noise} {drive}");
            // A few turns of a shaft that wanders slowly are a small sample of it.
            assert!(
                (0.5..2.0).contains(&(alone / noise)),
                "{alone} {noise} {drive}"
            );
        }
    }
}

#[test]
fn three_hall_sensors_show_widths_in_full() {
    let hall = "duration = { turns = 40 }\n[encoder.hall]\npole_pairs = 2\n";
    let drive = "[drive.constant]\nr_min = 300\n";
    let told = twin(&format!("{hall}{drive}"));
    let truth = twin(&format!(
        "{hall}[errors]\nwidth_a_rad = 0.02\nwidth_b_rad = 0.02\nwidth_c_rad = 0.02\n{drive}"
    ));
    let [was, noise, ..] = spreads(&board(&truth, &told, SensorKind::Hall, 2));
    // Half of the edges are ahead by so much, about their mean.
    assert!((was / 0.01 - 1.0).abs() < 0.02, "{was}");
    assert!(noise < 1e-3, "{noise}");
}

#[test]
fn a_slow_push_shows_in_what_is_slow_and_hardly_turn_by_turn() {
    let disc = "duration = { turns = 60 }\n[encoder.quadrature]\nlines = 50\n";
    let drive = "[drive.constant]\nr_min = 120\n";
    let told = twin(&format!("{disc}{drive}"));
    let truth = twin(&format!(
        "{disc}{drive}[[load_step]]\ntorque_n_m = -2e-5\nfrom_s = 12\n"
    ));
    let [was, noise, slow, slow_noise] = spreads(&board(&truth, &told, QUADRATURE, 50));
    assert!(slow > 30.0 * slow_noise, "{slow} {slow_noise}");
    assert!(was / noise < 0.1 * slow / slow_noise, "{was} {noise}");
}
