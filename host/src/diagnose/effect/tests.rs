//! Effects that the simulator runs, held against the columns by which the diagnosis sees them.

use super::*;
use crate::diagnose::bench::Bench;
use crate::diagnose::edges::{Sensor, place};
use crate::diagnose::filter::Noise;
use crate::diagnose::lsq;
use crate::recording::Row;
use crate::sim::{self, Simulation};
use crate::twin::{DeclaredEffect, Twin};
use quadcal::edge::Levels;

/// Least of an effect, rad, that is held against its columns: a hundred times what a tick is at these speeds.
const TOLD_RAD: f64 = 8e-6;
/// Most recordings, of some 300, whose count may be lost.
const LOST: usize = 12;
/// A shaft that goes faster and slower, one way.
const ONE_WAY: &str = "points = [{ t_s = 0.0, r_min = 40.0 }, { t_s = 1.5, r_min = 80.0 }, { t_s = 4.0, r_min = 35.0 }]";
/// One that turns round twice.
const BOTH_WAYS: &str = "points = [{ t_s = 0.0, r_min = 60.0 }, { t_s = 1.2, r_min = 60.0 }, { t_s = 1.4, r_min = -50.0 }, \
                         { t_s = 2.6, r_min = -50.0 }, { t_s = 2.8, r_min = 70.0 }]";

fn rig(profile: &str) -> Twin {
    let text = format!(
        "seed = 1\n[duration]\nseconds = 4.0\n[encoder.quadrature]\nlines = 500\nindex = true\n[shaft]\ninertia_kg_m2 = 1e-4\n\
         viscous_n_m_s = 1e-4\nstiffness_n_m_s = 4e-4\ninitial_angle_rad = 0.3\n[drive.profile]\n{profile}\n[timer]\nclock_hz = 84e6\n"
    );
    Twin::parse(&text, "a.toml").unwrap()
}

/// A twin's recording beside another.
fn bench(real: &Twin, given: &Twin) -> Option<Bench> {
    let sensor = Sensor::Quadrature {
        lines: 500,
        index: Some(Levels(Levels::A)),
    };
    let rows: Vec<Row> = Simulation::new(real)
        .unwrap()
        .map(|event| event.row)
        .collect();
    let edges = place(&sensor, real.timer.clock_hz, &rows).unwrap();
    let record = Record::of(&edges, given);
    let errors = sim::true_errors(given).unwrap();
    let noise = Noise {
        torque: 1e-6,
        stamp_s: 1e-8,
        drift: 0.0,
        fade: 0.0,
        angle_rad: 0.0,
        unseen: 0.0,
        ..Noise::default()
    };
    edges
        .events
        .is_empty()
        .then(|| Bench::new(record, given, &errors, &noise))
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// A row less what an unknown start makes of it.
fn less_start(bench: &Bench, row: &[f64]) -> Vec<f64> {
    let time: Vec<f64> = bench.record.time_s.clone();
    let fades = bench.plant.fading(&bench.course);
    let fades: Vec<f64> = fades.iter().map(|[angle, _]| *angle).collect();
    let one = vec![1.0; row.len()];
    lsq::solve(&[&one, &time, &fades], row).left
}

/// Part of what an effect does in the simulator that its columns do not foretell, and its RMS, rad; none where the recording lost its
/// count at a reversal.
fn off(effect: &Effect, sizes: &[f64], profile: &str) -> Option<(f64, f64)> {
    let given = rig(profile);
    let mut real = given.clone();
    real.effect = DeclaredEffect::of(effect, sizes).into_iter().collect();
    // Through its text, as a file has it.
    let real = Twin::parse(&real.to_toml().unwrap(), "a.toml").unwrap();
    let bench = bench(&real, &given)?;
    let mut foretold = vec![0.0; bench.record.len()];
    for (column, size) in bench.columns(effect).iter().zip(sizes) {
        for (sum, value) in foretold.iter_mut().zip(column) {
            *sum += size * value;
        }
    }
    let left: Vec<f64> = bench
        .residual
        .iter()
        .zip(&foretold)
        .map(|(seen, foretold)| seen - foretold)
        .collect();
    let (left, all) = (less_start(&bench, &left), less_start(&bench, &foretold));
    Some((rms(&left) / rms(&all), rms(&all)))
}

/// Sizes that move edges by some 1e-5 to 1e-3 rad.
fn size(site: Site, carrier: Carrier) -> f64 {
    // Sizes at 1 rad/s and at 1 s are smaller than at speed, and at the end.
    let share = match carrier {
        Carrier::Power(power) => 4_f64.powf(-power),
        _ => 1.0,
    };
    share
        * match site {
            Site::Torque => 2e-6,
            Site::Drive => 3e-4,
            Site::Disc(_) | Site::Level(_) => 1e-4,
            Site::Stamp(_) | Site::Declared(_) => 1e-5,
        }
}

#[test]
fn what_an_effect_does_in_the_simulator_is_what_its_columns_foretell() {
    let on = On {
        channel: Some(1),
        rises: Some(true),
    };
    let of_b = On { rises: None, ..on };
    let sites = [
        Site::Torque,
        Site::Drive,
        Site::Disc(On::ALL),
        Site::Disc(on),
        Site::Level(of_b),
        Site::Stamp(on),
    ];
    let carriers = [
        Carrier::Steady,
        Carrier::Order(3.0),
        Carrier::Order(4.37),
        Carrier::Tone(7.3),
        Carrier::Chirp(5.0, 1.1),
        Carrier::Bump(2.0, 0.2),
        Carrier::Window(1.0, 2.3),
        Carrier::Window(f64::NEG_INFINITY, 1.7),
        Carrier::Settling(0.8, 0.5),
        Carrier::Time,
        Carrier::Direction,
        Carrier::Power(0.0),
        Carrier::Power(1.5),
        Carrier::Power(2.0),
        Carrier::Stribeck(4.0),
    ];
    let growths = [
        Growth::Constant,
        Growth::Even(0.4),
        Growth::Speed(1.3),
        Growth::Modulated(0.7, 0.6, 0.2),
    ];
    let (mut wrong, mut lost) = (Vec::new(), 0);
    for site in sites {
        for carrier in carriers {
            for growth in growths {
                let effect = Effect {
                    site,
                    carrier,
                    growth,
                    only: None,
                };
                // What the drive balances is written as the shaft's friction, never as an effect.
                if effect.is_friction() {
                    continue;
                }
                // A power of the speed is 1 at 1 rad/s, and these shafts turn at some 4.
                let one = match growth {
                    Growth::Speed(power) => size(site, carrier) * 4_f64.powf(-power),
                    _ => size(site, carrier),
                };
                let sizes = [0.6 * one, 0.8 * one];
                let turns = matches!(carrier, Carrier::Direction | Carrier::Power(_));
                let profile = if turns { BOTH_WAYS } else { ONE_WAY };
                let Some((off, of)) = off(&effect, &sizes[..effect.sizes()], profile) else {
                    lost += 1;
                    continue;
                };
                // What an unknown start makes as well can't be told from it. Between the edges at a reversal the course is not known.
                let most = if turns && site == Site::Drive {
                    0.03
                } else {
                    0.01
                };
                if of > TOLD_RAD && off > most {
                    wrong.push(format!("{off:.4} of {of:.2e} rad: {effect:?}"));
                }
            }
        }
    }
    assert!(lost <= LOST, "{lost}");
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}
