//! The table of a calibration, exported as CSV, is a list of errors that a twin can name: edge for edge those of the twin it came from.

mod workshop;

use std::f64::consts::TAU;
use std::fs;

use quadcal_host::sim::true_errors;
use quadcal_host::twin::Twin;
use workshop::done;

/// RMS of what a list of errors leaves of the true ones, over theirs; a turn of the whole is no error.
fn left(listed: &[f64], truth: &[f64], real: impl Fn(u32) -> bool) -> f64 {
    let pairs: Vec<(f64, f64)> = (0_u32..)
        .zip(listed.iter().zip(truth))
        .filter(|(k, _)| real(*k))
        .map(|(_, (a, b))| (*a, *b))
        .collect();
    let scatter = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let mean = pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
        let sum: f64 = pairs.iter().map(|pair| (of(pair) - mean).powi(2)).sum();
        (sum / pairs.len() as f64).sqrt()
    };
    scatter(&|(a, b)| a - b) / scatter(&|(_, b)| *b)
}

fn rest(encoder: &str, errors: &str, turned: bool) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let rig = |errors: &str| {
        format!(
            "seed = 3\nduration = {{ turns = 40 }}\n{encoder}\n{errors}\n[drive.constant]\nr_min = {}\n[timer]\nclock_hz = 84e6\n",
            if turned { -600 } else { 600 }
        )
    };
    fs::write(at.join("rig.toml"), rig(errors)).unwrap();
    done(at, "simulate rig.toml -o rig.csv");
    done(
        at,
        "calibrate rig.csv --twin rig.toml -o t.qct --csv table.csv",
    );
    fs::write(at.join("again.toml"), rig("[errors]\ncsv = \"table.csv\"")).unwrap();
    let truth = Twin::load(&at.join("rig.toml")).unwrap();
    let again = Twin::load(&at.join("again.toml")).unwrap();
    let (listed, errors) = (true_errors(&again).unwrap(), true_errors(&truth).unwrap());
    left(&listed, &errors, |k| truth.encoder.is_real(k))
}

#[test]
fn a_quadrature_encoder_s_table_is_its_errors() {
    let step = TAU / 2000.0;
    let errors = format!(
        "[errors]\nposition = {{ normal = {{ rms_rad = {} }} }}\nwidth_a_rad = {}\nquadrature_rad = {}",
        0.1 * step,
        0.2 * step,
        0.15 * step
    );
    for turned in [false, true] {
        let rest = rest(
            "[encoder.quadrature]\nlines = 500\nindex = true",
            &errors,
            turned,
        );
        assert!(rest < 0.05, "{turned}: {rest}");
    }
}

#[test]
fn a_wheel_s_table_is_its_errors() {
    let errors =
        "[errors]\nposition = { normal = { rms_rad = 2e-3, per = \"line\" } }\nwidth_a_rad = 4e-3";
    // One channel does not tell the direction: of a wheel in reverse the table has the teeth in the order in which they passed.
    let rest = rest("[encoder.wheel]\nteeth = 60\nmissing = 2", errors, false);
    assert!(rest < 0.05, "{rest}");
}

#[test]
fn a_hall_table_is_its_errors() {
    let errors = "[errors]\nposition = { normal = { rms_rad = 1e-2 } }\nwidth_a_rad = 3e-2\nshift_c_rad = 2e-2\nwidth_c_rad = -1e-2";
    for turned in [false, true] {
        let rest = rest("[encoder.hall]\npole_pairs = 4", errors, turned);
        assert!(rest < 0.05, "{turned}: {rest}");
    }
}
