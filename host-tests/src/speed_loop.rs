//! Prototype
use std::f64::consts::TAU;
use quadcal_host::free_run::{command::Command, crossing::Crossing, fit, model::{Gains, LoopModel}};
use quadcal_host::calibrate::{self, CalibrateOptions};
use quadcal_host::recording::{Row, Header};
use quadcal_host::sim::Simulation;
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Drive, Duration, Harmonic, Noise, Twin};
use crate::accuracy::{distance, rms};

pub fn disc_twin(seed: u64) -> Twin {
    let mut twin = Twin::paper();
    twin.seed = seed;
    twin.errors.eccentricity = Some(Harmonic { amplitude_rad: 5e-4, phase_rad: 0.7 });
    twin.errors.tilt = Some(Harmonic { amplitude_rad: 1e-4, phase_rad: 2.1 });
    twin
}

pub fn looped(seed: u64, r_min: f64) -> Twin {
    let disc = disc_twin(seed);
    let errors = Simulation::new(&disc).unwrap().true_errors();
    let mut twin = disc.clone();
    twin.errors = Default::default();
    twin.errors.list_rad = errors;
    twin.seed = seed ^ (r_min as u64) << 32;
    twin.duration = Duration::Turns(14.1);
    // ripple as torque: sized at 15 r/min
    let w15 = 15.0 * TAU / 60.0;
    let j = twin.shaft.inertia_kg_m2;
    for (order, frac, r) in [(5.0, 0.01, 0), (10.0, 0.005, 1), (15.0, 0.0025, 2)] {
        twin.ripple[r].speed_fraction = None;
        twin.ripple[r].torque_n_m = Some(frac * w15 * j * order * w15);
    }
    twin.drive = Drive::SpeedLoop { r_min, f_hz: 1e4, bandwidth_hz: Some(100.0), kp_n_m_s: None, ki_n_m: None, timeout_s: None, limit_n_m: None };
    let c = w15 / 0.5;
    twin.noise = Some(Noise::White { psd_n2_m2_s: 2.0 * j * j * c * (1e-3 * w15).powi(2), hold_s: None });
    twin
}

pub struct Rec { pub header: Header, pub rows: Vec<Row>, pub truth: Vec<f64>, pub crossings: Vec<Crossing>, pub model: LoopModel }

pub fn record(twin: &Twin) -> Rec {
    let sim = Simulation::new(twin).unwrap();
    let (header, truth) = (sim.header(), sim.true_errors());
    let rows: Vec<Row> = sim.map(|e| e.row).collect();
    let survey = Survey::of(header.clone(), rows.iter().copied().map(Ok)).unwrap();
    let plan = calibrate::plan(&survey, &CalibrateOptions::default()).unwrap();
    let mut decoder = plan.decoder().unwrap();
    let crossings = rows.iter().filter_map(|r| Crossing::of(&decoder.push(*r))).collect();
    Rec { header, rows, truth, crossings, model: LoopModel::of(twin).unwrap() }
}

/// plain per-turn closed average of angle deviation
pub fn estimate(rec: &Rec, model: Option<&LoopModel>, turns: usize) -> (Vec<f64>, Vec<f64>) {
    let n = rec.truth.len();
    let start = rec.crossings.iter().position(|c| c.edge == 0 && c.sure).unwrap() ;
    let step = TAU / n as f64;
    let clock = rec.header.clock_hz;
    let zero = rec.model;
    let m = model.unwrap_or(&zero);
    let mut cmd = Command::new(m, clock, step, rec.crossings[0].ticks);
    let t0 = rec.crossings[start].ticks as f64;
    let w = step * (turns * n) as f64 / (rec.crossings[start + turns * n].ticks as f64 - t0) * clock as f64;
    let mut z = vec![];
    for c in &rec.crossings {
        let d = cmd.reach(c.ticks);
        cmd.edge(c.ticks, c.direction, c.steps);
        let dd = if model.is_some() { m.gains.kp * d[0] + m.gains.ki * d[1] + d[2] } else { 0.0 };
        z.push(w * (c.ticks as f64 - t0) / clock as f64 + dd);
    }
    let mut mean = vec![0.0; n];
    let mut per_turn1 = vec![];
    for turn in 0..turns {
        let s = start + turns_at(turn, n);
        let dev: Vec<f64> = (0..=n).map(|k| step * k as f64 - (z[s + k] - z[s])).collect();
        // close line + quadratic using next turn
        let close = dev[n];
        let next = if s + 2 * n < z.len() { step * n as f64 - (z[s + 2 * n] - z[s + n]) } else { close };
        let prev = if s >= n + start || s >= n { step * n as f64 - (z[s] - z[s - n]) } else { close };
        let curve = (next - prev) / 2.0; // change of closing per turn
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..n {
            let x = k as f64 / n as f64;
            let v = dev[k] - close * x - curve / 2.0 * (x * x - x);
            mean[k] += v / turns as f64;
            re += v * (TAU * x).cos() * 2.0 / n as f64; im += v * (TAU * x).sin() * 2.0 / n as f64;
        }
        per_turn1.push((re * re + im * im).sqrt());
    }
    (mean, per_turn1)
}
fn turns_at(turn: usize, n: usize) -> usize { turn * n }

pub fn main() {
    for seed in 1..=2u64 {
        for r_min in [15.0, 600.0] {
            let t = std::time::Instant::now();
            let rec = record(&looped(seed, r_min));
            println!("seed {seed} r_min {r_min} rows {} sim {:?}", rec.rows.len(), t.elapsed());
            let n = rec.truth.len();
            let zero = vec![0.0; n];
            let raw = distance(&zero, &rec.truth);
            let (e, _) = estimate(&rec, None, 11);
            println!(" raw {raw:e} hidden {:e}", distance(&e, &rec.truth) / raw);
            let (e, p1) = estimate(&rec, Some(&rec.model), 11);
            println!(" exact {:e} order1 {:?}", distance(&e, &rec.truth) / raw, &p1[..5]);
            let mut off = rec.model;
            off.gains = Gains { kp: off.gains.kp * 1.1, ki: off.gains.ki * 0.9 };
            let (e, _) = estimate(&rec, Some(&off), 11);
            println!(" off {:e}", distance(&e, &rec.truth) / raw);
            let t = std::time::Instant::now();
            let f = fit::fit(&rec.crossings, rec.header.clock_hz, n as u32, &off, 0.1).unwrap();
            println!(" fit kp {:e} ki {:e} se {:e} {:e} left {:e} in {:?}", f.gains.kp / rec.model.gains.kp - 1.0, f.gains.ki / rec.model.gains.ki - 1.0, f.standard_error.kp / rec.model.gains.kp, f.standard_error.ki / rec.model.gains.ki, f.left, t.elapsed());
            off.gains = f.gains;
            let (e, _) = estimate(&rec, Some(&off), 11);
            println!(" refined {:e}", distance(&e, &rec.truth) / raw);
            let _ = rms(&e);
        }
    }
}
