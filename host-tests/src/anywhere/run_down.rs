//! Shafts that run down freely, their drive off: friction and drag set the speed's course. No torque noise, so that the time stamps'
//! jitter is all that is not known.

use std::f64::consts::TAU;

use quadcal_host::calibrate::{self, CalibrateError, CalibrateOptions, Calibration, Learner};
use quadcal_host::survey::Survey;
use quadcal_host::twin::{
    Drive, Duration, Encoder, Errors, Harmonic, Per, Position, Ripple, Twin, TwinError,
};

use super::Run;
use crate::peer_polynomial;

/// Lines of the disc.
pub const LINES: u32 = 100;
/// Speed at the start, rev/s.
pub const START_REV_S: f64 = 20.0;
/// Jitter of a time stamp, RMS, s.
pub const JITTER_S: f64 = 1e-8;
/// Torque that is locked to the shaft, N m, at each of its orders.
pub const TORQUE_N_M: f64 = 2e-4;
/// Inertia of all that turns, kg m^2.
const INERTIA: f64 = 2e-5;
/// Speed that friction takes in a turn, rev/s.
const LOSS_REV_S: f64 = 5.0 / 33.0;

/// What runs down, and what the shaft has beside friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunDown {
    /// Once from 20 to 15 rev/s in 33 turns.
    Once,
    /// The same with torque once a turn.
    TorqueOnce,
    /// The same with cogging at orders 5 and 10.
    Cogging,
    /// Once under drag that goes with the square of the speed.
    Drag,
    /// Twice from 20 to 10 rev/s in 66 turns.
    Twice,
}

impl RunDown {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Once,
        Self::TorqueOnce,
        Self::Cogging,
        Self::Drag,
        Self::Twice,
    ];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Once => "run-down 20 to 15 rev/s",
            Self::TorqueOnce => "run-down, torque once a turn",
            Self::Cogging => "run-down, cogging",
            Self::Drag => "run-down under drag",
            Self::Twice => "two run-downs 20 to 10 rev/s",
        }
    }

    /// Orders of the torque that is there.
    #[must_use]
    pub const fn torque_orders(self) -> &'static [u16] {
        match self {
            Self::Once | Self::Drag | Self::Twice => &[],
            Self::TorqueOnce => &[1],
            Self::Cogging => &[5, 10],
        }
    }

    const fn recordings(self) -> u64 {
        match self {
            Self::Twice => 2,
            _ => 1,
        }
    }

    fn turns(self) -> f64 {
        match self {
            Self::Twice => 66.0,
            _ => 33.0,
        }
    }

    /// The twins of its recordings, of a disc drawn from `seed`.
    #[must_use]
    pub fn twins(self, seed: u64) -> Vec<Twin> {
        let count = self.recordings();
        (0..count)
            .map(|part| self.twin(seed, seed * count + part))
            .collect()
    }

    fn twin(self, disc: u64, seed: u64) -> Twin {
        let mut twin = Twin::paper();
        twin.seed = seed;
        twin.encoder = Encoder::Quadrature {
            lines: LINES,
            index: true,
        };
        twin.errors = Errors {
            seed: Some(disc),
            position: Some(Position::Uniform {
                amplitude_rad: 2e-4,
                per: Per::Edge,
            }),
            eccentricity: Some(Harmonic {
                amplitude_rad: 5e-4,
                phase_rad: 0.7,
            }),
            ..Errors::default()
        };
        twin.drive = Drive::RunDown {
            r_min: START_REV_S * 60.0,
            off_s: 0.0,
        };
        let loss = LOSS_REV_S;
        let shaft = &mut twin.shaft;
        shaft.inertia_kg_m2 = INERTIA;
        match self {
            Self::Drag => {
                shaft.viscous_n_m_s = 0.0;
                shaft.drag_n_m_s2 = INERTIA * loss / (START_REV_S * TAU);
            }
            _ => shaft.viscous_n_m_s = INERTIA * loss,
        }
        shaft.initial_angle_rad = -0.05 * TAU;
        twin.duration = Duration::Turns(self.turns() + 0.1);
        twin.ripple = self
            .torque_orders()
            .iter()
            .map(|&order| Ripple {
                order: order.into(),
                phase_rad: 0.4 * f64::from(order),
                torque_n_m: Some(TORQUE_N_M),
                speed_fraction: None,
            })
            .collect();
        twin.timer.jitter_s = JITTER_S;
        twin
    }

    /// Runs it.
    ///
    /// # Errors
    /// The simulator's.
    pub fn run(self, seed: u64) -> Result<Run, TwinError> {
        Run::of(&self.twins(seed))
    }

    /// Calibrates on a run's recordings together, as `quadcal calibrate` does.
    ///
    /// # Errors
    /// [`CalibrateError`] of the recordings.
    ///
    /// # Panics
    /// Without a recording.
    pub fn calibrate(self, run: &Run) -> Result<Calibration, CalibrateError> {
        let options = CalibrateOptions {
            lines: Some(LINES),
            ..CalibrateOptions::default()
        };
        let mut learner: Option<Learner> = None;
        for recorded in &run.recordings {
            let rows = || recorded.rows.iter().copied().map(Ok);
            let survey = Survey::of(recorded.header.clone(), rows())?;
            let plan = calibrate::plan(&survey, &options)?;
            let clock_hz = survey.header.clock_hz;
            let learner = match &mut learner {
                Some(learner) => learner,
                none => none.insert(Learner::new(plan, clock_hz, options.drive)?),
            };
            learner.add(survey, rows(), &options)?;
        }
        learner.expect("a recording").solve()
    }

    /// Error of the ideal estimator, rad, RMS over the edges: it knows the speed's course and at which orders there is torque, and all
    /// whole turns count.
    #[must_use]
    pub fn bound(self, run: &Run) -> f64 {
        let edges = 4 * LINES as usize;
        // Information on geometry, on torque, and on both.
        let (mut g, mut r, mut both) = (0.0, 0.0, 0.0);
        for recorded in &run.recordings {
            let clock_hz = recorded.header.clock_hz as f64;
            let stamp_s = JITTER_S.hypot(1.0 / (12.0_f64.sqrt() * clock_hz));
            for ends in recorded.times.windows(edges + 1).step_by(edges) {
                let speed = TAU * clock_hz / (ends[edges] - ends[0]) as f64;
                let one = (stamp_s * speed).powi(-2);
                g += one;
                both += one / (speed * speed);
                r += one / speed.powi(4);
            }
        }
        let with_torque = 1.0 / (g - both * both / r);
        let share = 2.0 * self.torque_orders().len() as f64 / edges as f64;
        ((1.0 - share) / g + share * with_torque).sqrt()
    }
    /// Errors of every edge, rad, by a polynomial fit to each recording: their mean.
    #[must_use]
    pub fn polynomial(self, run: &Run) -> Vec<f64> {
        let edges = run.truth.len();
        let mut error = vec![0.0; edges];
        for recorded in &run.recordings {
            let turns = (recorded.times.len() - 1) / edges;
            let found = peer_polynomial::estimate(&recorded.times[..=turns * edges], edges);
            for (sum, value) in error.iter_mut().zip(found) {
                *sum += value / run.recordings.len() as f64;
            }
        }
        error
    }
}
