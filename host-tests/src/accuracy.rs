//! The accuracy table: one rig, several kinds of torque, four ways to estimate, errors against the true edge angles.

use quadcal::estimate::Solution;
use quadcal::step::{Flags, Outcome};
use quadcal::units::RAD_PER_TURN32;
use quadcal_host::buffers::HeapBuffers;
use quadcal_host::calibrate::{self, CalibrateOptions, Calibration};
use quadcal_host::recording::Row;
use quadcal_host::sim::Simulation;
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Duration, Errors, Noise, Twin};

use crate::{paper, reference};

/// Turns that an estimate rests on.
pub const TURNS: u32 = 11;

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// Section 4 of the paper, no torque noise.
    Quiet,
    /// Speed wander of 0.1 % RMS, correlated over 0.5 rad.
    Wander01,
    /// Speed wander of 1 %.
    Wander1,
    /// An encoder without errors, 0.1 % wander.
    Perfect,
}

impl Scenario {
    /// Every row.
    pub const ALL: [Self; 4] = [Self::Quiet, Self::Wander01, Self::Wander1, Self::Perfect];

    /// Its name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quiet => "no torque noise",
            Self::Wander01 => "speed wander 0.1 %",
            Self::Wander1 => "speed wander 1 %",
            Self::Perfect => "perfect encoder, wander 0.1 %",
        }
    }

    /// Share of the error RMS that is to be removed; none for an encoder without errors.
    #[must_use]
    pub const fn target_removed(self) -> Option<f64> {
        match self {
            Self::Quiet => Some(0.97),
            Self::Wander01 => Some(0.96),
            Self::Wander1 => Some(0.90),
            Self::Perfect => None,
        }
    }

    /// The rig with a seed.
    #[must_use]
    pub fn twin(self, seed: u64) -> Twin {
        let mut twin = Twin::paper();
        twin.seed = seed;
        // One turn for the rate or the smoother's margin, one at the end, and the way to the first index.
        twin.duration = Duration::Turns(f64::from(TURNS) + 3.1);
        let wander = |rms_fraction| Noise::SpeedWander {
            rms_fraction,
            correlation_rad: Some(0.5),
            hold_s: None,
        };
        match self {
            Self::Quiet => {}
            Self::Wander01 => twin.noise = Some(wander(1e-3)),
            Self::Wander1 => twin.noise = Some(wander(1e-2)),
            Self::Perfect => {
                twin.noise = Some(wander(1e-3));
                twin.errors = Errors::default();
            }
        }
        twin
    }
}

/// Everything that was recorded of a run, and the truth apart from it.
pub struct Run {
    /// Times of all edges from the first edge 0 on.
    pub times: Vec<u64>,
    /// The core's calibration.
    pub calibration: Calibration,
    /// True error of every edge, zero mean, rad.
    pub truth: Vec<f64>,
}

/// Simulates a twin and calibrates on [`TURNS`] turns of it; the calibration sees the rows only.
///
/// # Panics
/// When the twin can't be simulated or calibrated: a fault of the test.
#[must_use]
pub fn run(twin: &Twin) -> Run {
    let simulation = Simulation::new(twin).expect("the twin is valid");
    let (header, truth) = (simulation.header(), simulation.true_errors());
    let rows: Vec<Row> = simulation.map(|event| event.row).collect();
    let replay = || rows.iter().copied().map(Ok);
    let survey = Survey::of(header, replay()).expect("rows can't fail");
    let options = CalibrateOptions {
        turns: Some(TURNS),
        ..CalibrateOptions::default()
    };
    let plan = calibrate::plan(&survey, &options).expect("the recording shows its encoder");
    let mut decoder = plan.decoder().expect("lines are in range");
    let mut times = Vec::new();
    for row in &rows {
        if let Outcome::Step(step) = decoder.push(*row) {
            let started = !times.is_empty() || step.edge == 0;
            if started && step.flags.contains(Flags::REFERENCED) {
                times.push(step.ticks);
            }
        }
    }
    let calibration =
        calibrate::learn(survey, plan, replay(), &options).expect("the recording is long enough");
    Run {
        times,
        calibration,
        truth: zero_mean(truth),
    }
}

/// RMS errors of one run, rad.
#[derive(Clone, Copy, Debug)]
pub struct RunErrors {
    /// Of the encoder as it is.
    pub raw: f64,
    /// After the published method as printed.
    pub printed: f64,
    /// After the published method with (14) closed over a turn.
    pub closed: f64,
    /// After the core's table.
    pub ours: f64,
    /// RMS of the core's table itself.
    pub table: f64,
    /// The core's own standard error.
    pub standard_error: f64,
    /// RMS difference between the core and the double-precision reference.
    pub from_reference: f64,
    /// Largest relative error of the core's xi_A, xi_B and p against the truth in the same form; none without such errors.
    pub class_error: Option<f64>,
}

impl Run {
    /// Compares all estimates with the truth.
    #[must_use]
    pub fn errors(&self) -> RunErrors {
        let lines = self.truth.len() / 4;
        let ours = table_rad(&self.calibration.solution);
        let printed = paper::estimate(&self.times, lines, TURNS as usize, false);
        let closed = paper::estimate(&self.times, lines, TURNS as usize, true);
        let reference = self.reference();
        RunErrors {
            raw: rms(&self.truth),
            printed: distance(&printed.error, &self.truth),
            closed: distance(&closed.error, &self.truth),
            ours: distance(&ours, &self.truth),
            table: rms(&ours),
            standard_error: f64::from(self.calibration.solution.standard_error()) * RAD_PER_TURN32,
            from_reference: distance(&ours, &reference.error),
            class_error: class_error(&ours, &self.truth),
        }
    }

    /// The double-precision estimate from the same turns.
    #[must_use]
    pub fn reference(&self) -> reference::Reference {
        let edges = self.truth.len();
        let used = (TURNS as usize + 1) * edges + 1;
        reference::estimate(&[&self.times[..used]], edges, 4, 0)
    }

    /// Error power of every order 1..N/2 before and after correction, rad^2.
    #[must_use]
    pub fn order_powers(&self) -> Vec<(f64, f64)> {
        let ours = table_rad(&self.calibration.solution);
        let rest: Vec<f64> = self.truth.iter().zip(&ours).map(|(e, c)| e - c).collect();
        let (before, after) = (spectrum(&self.truth), spectrum(&rest));
        before.into_iter().zip(after).collect()
    }
}

/// Mean error power of every order after correction over that before, over many seeds: `(order, ratio)`.
#[must_use]
pub fn order_ratios(scenario: Scenario, seeds: std::ops::Range<u64>) -> Vec<(usize, f64)> {
    let mut sums: Vec<(f64, f64)> = Vec::new();
    for seed in seeds {
        let powers = run(&scenario.twin(seed)).order_powers();
        sums.resize(powers.len(), (0.0, 0.0));
        for (sum, (before, after)) in sums.iter_mut().zip(powers) {
            *sum = (sum.0 + before, sum.1 + after);
        }
    }
    sums.into_iter()
        .enumerate()
        .map(|(index, (before, after))| (index + 1, after / before))
        .collect()
}

/// Largest relative deviation of xi_A, xi_B and p, each from its class means.
fn class_error(estimate: &[f64], truth: &[f64]) -> Option<f64> {
    let parameters = |x: &[f64]| {
        let mean =
            |class: usize| x.iter().skip(class).step_by(4).sum::<f64>() * 4.0 / x.len() as f64;
        [mean(2) - mean(0), mean(3) - mean(1), mean(1) - mean(0)]
    };
    let (found, meant) = (parameters(estimate), parameters(truth));
    let worst = found
        .iter()
        .zip(meant)
        .map(|(f, m)| (f / m - 1.0).abs())
        .fold(0.0, f64::max);
    meant.iter().all(|m| *m != 0.0).then_some(worst)
}

/// A solved table in radians.
#[must_use]
pub fn table_rad(solution: &Solution<HeapBuffers>) -> Vec<f64> {
    let classes = solution.shape().classes() as usize;
    let entries = solution.entries().iter().enumerate();
    let error = |(edge, &entry): (usize, &i16)| {
        let offset = i64::from(solution.class_offset(edge % classes).0);
        (offset + (i64::from(entry) << solution.shift())) as f64 * RAD_PER_TURN32
    };
    zero_mean(entries.map(error).collect())
}

/// Root mean square.
#[must_use]
pub fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

/// RMS of the difference, means taken out: the angle's zero is nobody's to know.
#[must_use]
pub fn distance(x: &[f64], y: &[f64]) -> f64 {
    rms(&zero_mean(x.iter().zip(y).map(|(x, y)| x - y).collect()))
}

/// The values less their mean.
pub(crate) fn zero_mean(mut x: Vec<f64>) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter_mut().for_each(|x| *x -= mean);
    x
}

/// Power of orders 1..N/2.
fn spectrum(x: &[f64]) -> Vec<f64> {
    let edges = x.len();
    let mut planner = realfft::RealFftPlanner::<f64>::new();
    let fft = planner.plan_fft_forward(edges);
    let mut input = x.to_vec();
    let mut output = fft.make_output_vec();
    fft.process(&mut input, &mut output)
        .expect("lengths are the plan's");
    output[1..edges / 2]
        .iter()
        .map(|c| 2.0 * c.norm_sqr() / (edges * edges) as f64)
        .collect()
}

/// The middle value.
///
/// # Panics
/// Without values.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len().is_multiple_of(2) {
        (values[half - 1] + values[half]) / 2.0
    } else {
        values[half]
    }
}
