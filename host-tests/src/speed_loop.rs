//! A live speed loop: what it hides, and what is left once it is undone, for gains known exactly, badly, and corrected on the recording.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use quadcal::step::{Flags, Outcome};
use quadcal_host::calibrate::{self, CalibrateOptions};
use quadcal_host::free_run::torque::{TorqueRecord, TorqueStep};
use quadcal_host::free_run::{FreeRun, FreeRunError, Gains, Knowledge, LoopModel, Push};
use quadcal_host::recording::{Header, Row};
use quadcal_host::sensor::SensorPlan;
use quadcal_host::sim::Simulation;
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Drive, Duration, Errors, Harmonic, Noise, Shaft, Twin};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::RealFftPlanner;

use crate::accuracy::rms;
use crate::anywhere::{GivenGains, Judged, Rig, Scenario};

/// Turns that an estimate rests on.
const TURNS: usize = 11;
/// The slower of the two speeds, r/min.
pub const SLOW: f64 = 15.0;
/// The faster, r/min.
pub const FAST: f64 = 600.0;
/// Sample rate of the loop, Hz.
const RATE_HZ: f64 = 10_000.0;

/// The disc of a seed in a speed loop of 100 Hz: section 4's errors, an eccentricity of 5e-4 rad and a tilt of 1e-4 rad; torque noise
/// that in open loop makes the speed wander 0.1 % RMS over 0.5 rad at 15 r/min, and section 4's ripple, as torques of that speed.
///
/// # Panics
/// When the twin can't be simulated: a fault of the test.
#[must_use]
pub fn twin(seed: u64, r_min: f64) -> Twin {
    let mut twin = Twin::paper();
    twin.seed = seed;
    let harmonic = |amplitude_rad, phase_rad| {
        Some(Harmonic {
            amplitude_rad,
            phase_rad,
        })
    };
    twin.errors.eccentricity = harmonic(5e-4, 0.7);
    twin.errors.tilt = harmonic(1e-4, 2.1);
    let disc = Simulation::new(&twin).expect("the twin is valid");
    twin.errors = Errors {
        list_rad: disc.true_errors(),
        ..Errors::default()
    };
    // The disc is the same at every speed, the noise is not.
    #[allow(clippy::cast_sign_loss)]
    let speed = r_min as u64;
    twin.seed = (seed << 16) ^ speed;
    twin.duration = Duration::Turns(TURNS as f64 + 3.1);
    let Shaft { inertia_kg_m2, .. } = twin.shaft;
    let slow = SLOW * TAU / 60.0;
    for ripple in &mut twin.ripple {
        let fraction = ripple.speed_fraction.take().unwrap_or(0.0);
        ripple.torque_n_m = Some(fraction * inertia_kg_m2 * ripple.order * slow * slow);
    }
    twin.drive = Drive::SpeedLoop {
        r_min,
        f_hz: RATE_HZ,
        bandwidth_hz: Some(100.0),
        kp_n_m_s: None,
        ki_n_m: None,
        timeout_s: None,
        limit_n_m: None,
    };
    let damping = slow / 0.5;
    let wander = 1e-3 * slow * inertia_kg_m2;
    twin.noise = Some(Noise::White {
        psd_n2_m2_s: 2.0 * damping * wander * wander,
        hold_s: None,
    });
    twin
}

/// Gains said to be known within 10 %: kp and ki off by a factor of their own, drawn from 0.9 to 1.1.
#[must_use]
pub fn drawn(seed: u64) -> GivenGains {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    GivenGains {
        kp: random.random_range(0.9..1.1),
        ki: random.random_range(0.9..1.1),
        within: 0.1,
    }
}

/// Calibrates both speeds of [`Scenario::SpeedLoop`] together with drawn gains, once a seed.
///
/// # Panics
/// When a recording can't be used: a fault of the test.
#[must_use]
pub fn sweep(seeds: RangeInclusive<u64>) -> Vec<Judged> {
    let rig = Rig {
        scenario: Scenario::SpeedLoop,
        lines: 2500,
    };
    let judge = |seed| {
        let run = rig.run(seed).expect("the twin is valid");
        let calibration = rig.calibrate(&run, seed, drawn(seed));
        Judged::of(&calibration.expect("the run is long enough"), &run)
    };
    seeds.map(judge).collect()
}

/// A recording under a loop, and the truth apart from it.
pub struct Run {
    header: Header,
    rows: Vec<Row>,
    plan: SensorPlan,
    truth: Vec<f64>,
    /// The loop as it is.
    pub model: LoopModel,
    /// Orders up to this are left out of the comparison: at low speed, ripple and wander drown them whatever the loop does.
    above: usize,
}

/// Simulates a disc at a speed; `later` ticks are added to every time stamp.
///
/// # Panics
/// When the twin can't be simulated: a fault of the test.
#[must_use]
pub fn record(seed: u64, r_min: f64, later: u64) -> Run {
    let twin = twin(seed, r_min);
    let simulation = Simulation::new(&twin).expect("the twin is valid");
    let (header, truth) = (simulation.header(), simulation.true_errors());
    let rows: Vec<Row> = simulation
        .map(|event| Row {
            ticks: event.row.ticks + later,
            ..event.row
        })
        .collect();
    let survey = Survey::of(header.clone(), rows.iter().copied().map(Ok)).expect("rows can't fail");
    Run {
        header,
        plan: calibrate::plan(&survey, &CalibrateOptions::default()).expect("it has an index"),
        rows,
        truth,
        model: LoopModel::of(&twin).expect("it is a loop"),
        above: if r_min < 100.0 { 40 } else { 0 },
    }
}

impl Run {
    /// The loop with gains off by these factors.
    #[must_use]
    pub fn off_by(&self, kp: f64, ki: f64) -> Push {
        let Gains { kp: p, ki: i } = self.model.gains;
        Push::Loop(LoopModel {
            gains: Gains {
                kp: kp * p,
                ki: ki * i,
            },
            ..self.model
        })
    }

    /// The free run behind the recording.
    ///
    /// # Errors
    /// As [`FreeRun::of`].
    pub fn free(&self, push: Push, knowledge: Knowledge) -> Result<FreeRun, FreeRunError> {
        let open = || Ok(self.rows.iter().copied().map(Ok));
        FreeRun::of(open, &self.header, self.plan, push, knowledge)
    }

    /// Error left over the error of the encoder, RMS, of the mean over `TURNS` turns of the recording as it is.
    #[must_use]
    pub fn left_as_is(&self) -> f64 {
        self.left(self.rows.iter().copied())
    }

    /// The same with the loop undone.
    ///
    /// # Panics
    /// When the recording can't be used: a fault of the test.
    #[must_use]
    pub fn left_undone(&self, push: Push, knowledge: Knowledge) -> f64 {
        let free = self.free(push, knowledge).expect("the run is long enough");
        let rows = free.rows(self.rows.iter().copied().map(Ok));
        self.left(rows.map(|row| row.expect("rows can't fail")))
    }

    fn left(&self, rows: impl Iterator<Item = Row>) -> f64 {
        let found = mean_deviation(rows, self.plan);
        let rest: Vec<f64> = found.iter().zip(&self.truth).map(|(f, t)| f - t).collect();
        rms(&orders_above(&rest, self.above)) / rms(&orders_above(&self.truth, self.above))
    }

    /// The torque that the loop gave, as recorded at each of its samples or at each edge only, rounded to `lsb`.
    #[must_use]
    pub fn torque(&self, at_edges: bool, lsb: Option<f64>) -> Vec<TorqueStep> {
        let model = &self.model;
        let clock = self.header.clock_hz as f64;
        let step = TAU / self.truth.len() as f64;
        let (mut integral, mut measured) = (model.start, model.target_rad_s);
        let (mut sample, mut last, mut torque) = (0_u64, None::<u64>, 0.0);
        let mut steps = Vec::new();
        let mut decoder = self.plan.decoder().expect("lines are in range");
        for row in &self.rows {
            let Outcome::Step(edge) = decoder.push(*row) else {
                continue;
            };
            let now = edge.ticks;
            loop {
                let tick = (sample as f64 * clock / RATE_HZ) as u64;
                if tick > now {
                    break;
                }
                let miss = model.target_rad_s - measured;
                torque = (model.gains.kp * miss + integral) * model.inertia_kg_m2;
                integral += model.gains.ki / RATE_HZ * miss;
                if !at_edges {
                    steps.push((tick, tick, torque));
                }
                sample += 1;
            }
            if at_edges {
                steps.push((last.unwrap_or(now), now, torque));
            }
            if let Some(last) = last {
                measured = step * clock / (now - last) as f64;
            }
            last = Some(now);
        }
        let rounded = |torque: f64| lsb.map_or(torque, |lsb| (torque / lsb).round() * lsb);
        let steps = steps.into_iter().map(|(after, from, torque)| TorqueStep {
            after,
            from,
            torque_n_m: rounded(torque),
        });
        let mut steps: Vec<TorqueStep> = steps.collect();
        steps.dedup_by(|next, before| next.torque_n_m == before.torque_n_m);
        steps
    }

    /// A recorded torque on a shaft whose inertia is off by a factor; with the drive's sample rate, if it is `timed`.
    #[must_use]
    pub fn torque_push(&self, steps: &[TorqueStep], inertia_off: f64, timed: bool) -> Push {
        Push::Torque(TorqueRecord::new(
            steps,
            self.model.inertia_kg_m2 * inertia_off,
            self.model.viscous,
            timed.then_some(self.header.clock_hz as f64 / RATE_HZ),
        ))
    }
}

/// Mean over turns of grid angle less speed times time, every turn closed.
fn mean_deviation(rows: impl Iterator<Item = Row>, plan: SensorPlan) -> Vec<f64> {
    let mut decoder = plan.decoder().expect("lines are in range");
    let mut times: Vec<f64> = Vec::new();
    for row in rows {
        if let Outcome::Step(step) = decoder.push(row)
            && (!times.is_empty() || step.edge == 0 && step.flags.contains(Flags::REFERENCED))
        {
            times.push(step.ticks as f64);
        }
    }
    let edges = 4 * plan.lines as usize;
    let step = TAU / edges as f64;
    let turn = |n: usize| times[n * edges + edges] - times[n * edges];
    let mut mean = vec![0.0; edges];
    for n in 1..=TURNS {
        let speed = TAU / turn(n);
        let bend = speed * (turn(n + 1) - turn(n - 1)) / 4.0;
        for (k, mean) in mean.iter_mut().enumerate() {
            let part = k as f64 / edges as f64;
            let moved = speed * (times[n * edges + k] - times[n * edges]);
            *mean += (step * k as f64 - moved + bend * (part * part - part)) / TURNS as f64;
        }
    }
    mean
}

/// A turn without the mean and the orders up to and with `last`.
fn orders_above(turn: &[f64], last: usize) -> Vec<f64> {
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(turn.len()),
        planner.plan_fft_inverse(turn.len()),
    );
    let mut input = turn.to_vec();
    let mut orders = forward.make_output_vec();
    let lengths = "lengths are the plan's";
    forward.process(&mut input, &mut orders).expect(lengths);
    orders[..=last].fill(Default::default());
    inverse.process(&mut orders, &mut input).expect(lengths);
    input.iter().map(|x| x / turn.len() as f64).collect()
}
