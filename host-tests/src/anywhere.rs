//! One rig driven in several ways: two speeds, a ramp, one speed, a speed loop. Recordings and, apart from them, the truth.
//!
//! Shaft, torque noise and cogging are the same torques at every speed, so the shaft's swing in angle falls as 1/speed^2 while the
//! disc's errors stay.

mod calibrated;
mod disturbed;
mod orders;
mod run_down;
mod scenario;

use std::f64::consts::TAU;

use quadcal_host::recording::{Header, Row};
use quadcal_host::sim::Simulation;
use quadcal_host::twin::{
    Drive, Duration, Encoder, Harmonic, Noise, Per, Position, Ripple, Twin, TwinError,
};

use crate::accuracy::zero_mean;

pub use calibrated::{GivenGains, Judged};
pub use disturbed::{
    Disturbance, Disturbed, LOADS, RAMP_LOADS, STRONG_RIPPLE, STRONG_WANDER, Share, Verdicts,
};
pub use orders::{ByOrder, WorstOrder};
pub use run_down::RunDown;
pub use scenario::Scenario;

/// Turns that are learned from a recording of one speed; it holds one more, for the speed before.
pub const TURNS: u32 = 11;
/// The slow speed, r/min; wander and cogging are sized at it.
pub const SLOW_R_MIN: f64 = 15.0;
/// The fast speed, r/min.
pub const FAST_R_MIN: f64 = 600.0;
/// Speed at the end of the ramp, r/min.
pub const RAMP_END_R_MIN: f64 = 1500.0;
/// Whole turns of the ramp, from index to index.
pub const RAMP_TURNS: f64 = 60.0;
/// RMS wander of the slow speed, a part of it.
pub const WANDER: f64 = 1e-3;
/// Angle over which the slow speed forgets, rad.
pub const CORRELATION_RAD: f64 = 0.5;
/// Cogging: order and phase of its torques, rad.
pub const COGGING: [(f64, f64); 4] = [(5.0, 0.3), (10.0, 1.1), (15.0, 2.0), (30.0, -0.8)];
/// Speed swing that each order of the cogging makes at the slow speed, a part of it.
pub const COGGING_SWING: f64 = 0.01;
/// Bandwidth of the speed loop, Hz.
pub const LOOP_HZ: f64 = 100.0;
/// Sample rate of the speed loop, Hz.
pub const LOOP_SAMPLE_HZ: f64 = 10_000.0;
/// Rate of the timer, Hz.
pub const CLOCK_HZ: u64 = 84_000_000;

/// Way to the first index, and beyond the last one, at one speed, in turns.
const MARGIN_TURNS: f64 = 0.15;
/// The same on the ramp: short, as the slowest speeds are over within a fraction of a turn.
pub const RAMP_MARGIN_TURNS: f64 = 0.01;
/// Steps of the torque noise in a turn, at any number of lines.
const NOISE_STEPS: f64 = 10_000.0;

/// The slow speed, rad/s.
#[must_use]
pub fn slow_rad_s() -> f64 {
    SLOW_R_MIN * TAU / 60.0
}

/// Damping of the open-loop shaft, friction and drive stiffness over inertia, 1/s.
#[must_use]
pub fn damping() -> f64 {
    slow_rad_s() / CORRELATION_RAD
}

/// Length of the ramp with its margins, s.
#[must_use]
pub fn ramp_s() -> f64 {
    (RAMP_TURNS + 2.0 * RAMP_MARGIN_TURNS) * 60.0 / f64::midpoint(SLOW_R_MIN, RAMP_END_R_MIN)
}

/// Two-sided density of the acceleration that the torque noise makes, (rad/s^2)^2/Hz.
#[must_use]
pub fn noise_density() -> f64 {
    2.0 * damping() * (WANDER * slow_rad_s()).powi(2)
}

/// A rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rig {
    /// How it is driven.
    pub scenario: Scenario,
    /// Lines M of its disc. Line, width and quadrature errors are those of the paper in parts of a grid step; eccentricity and tilt
    /// are 5e-4 and 1e-4 rad.
    pub lines: u32,
}

/// One recording and when its edges came.
pub struct Recorded {
    /// Header of the recording.
    pub header: Header,
    /// Its rows.
    pub rows: Vec<Row>,
    /// Ticks of all edges from the first edge 0 after an index on: entry i is edge i mod N.
    pub times: Vec<u64>,
}

/// The recordings of a rig, and the truth apart from them.
pub struct Run {
    /// One for each drive.
    pub recordings: Vec<Recorded>,
    /// True error e(k) of every edge, zero mean, rad: the same disc in all recordings.
    pub truth: Vec<f64>,
}

impl Run {
    /// Runs the twins of one disc.
    ///
    /// # Errors
    /// The simulator's.
    pub fn of(twins: &[Twin]) -> Result<Self, TwinError> {
        let mut truth = Vec::new();
        let mut recordings = Vec::new();
        for twin in twins {
            let simulation = Simulation::new(twin)?;
            truth = zero_mean(simulation.true_errors());
            recordings.push(record(simulation));
        }
        Ok(Self { recordings, truth })
    }

    /// What a calibration may see: headers and rows.
    #[must_use]
    pub fn into_recordings(self) -> Vec<(Header, Vec<Row>)> {
        self.recordings
            .into_iter()
            .map(|recorded| (recorded.header, recorded.rows))
            .collect()
    }
}

impl Rig {
    /// The twins of its recordings: one disc, drawn from `seed`, and torque noise of each recording's own.
    #[must_use]
    pub fn twins(self, seed: u64) -> Vec<Twin> {
        let drives = self.scenario.drives();
        let count = drives.len() as u64;
        drives
            .into_iter()
            .zip(0..)
            .map(|(drive, part)| {
                let mut twin = self.twin(drive);
                twin.errors.seed = Some(seed);
                twin.seed = seed * count + part;
                twin
            })
            .collect()
    }

    fn twin(self, drive: Drive) -> Twin {
        let mut twin = Twin::paper();
        self.set_encoder(&mut twin);
        let nominal = drive.nominal_rad_s();
        let looped = matches!(drive, Drive::SpeedLoop { .. });
        let inertia = twin.shaft.inertia_kg_m2;
        let hold_s = Some(TAU / nominal / NOISE_STEPS);
        let (turns, margin) = match drive {
            Drive::Ramp { .. } => (RAMP_TURNS, RAMP_MARGIN_TURNS),
            _ => (f64::from(TURNS) + 1.0, MARGIN_TURNS),
        };
        twin.duration = Duration::Turns(turns + 2.0 * margin);
        twin.shaft.initial_angle_rad = -margin * TAU;
        if looped {
            twin.noise = Some(Noise::White {
                psd_n2_m2_s: noise_density() * inertia * inertia,
                hold_s,
            });
        } else {
            twin.shaft.stiffness_n_m_s = damping() * inertia - twin.shaft.viscous_n_m_s;
            // The same torque at every speed: in rad/s the wander stays.
            twin.noise = Some(Noise::SpeedWander {
                rms_fraction: WANDER * slow_rad_s() / nominal,
                correlation_rad: None,
                hold_s,
            });
        }
        twin.drive = drive;
        twin.ripple = Vec::new();
        if self.scenario.has_cogging() {
            twin.ripple.extend(COGGING.map(|(order, phase_rad)| Ripple {
                order,
                phase_rad,
                torque_n_m: Some(
                    inertia * COGGING_SWING * slow_rad_s() * damping().hypot(order * slow_rad_s()),
                ),
                speed_fraction: None,
            }));
        }
        twin.timer.clock_hz = CLOCK_HZ;
        twin
    }

    fn set_encoder(self, twin: &mut Twin) {
        let scale = 2500.0 / f64::from(self.lines);
        twin.encoder = Encoder::Quadrature {
            lines: self.lines,
            index: true,
        };
        let errors = &mut twin.errors;
        errors.position = Some(Position::Uniform {
            amplitude_rad: 6.2832e-5 * scale,
            per: Per::Edge,
        });
        errors.width_a_rad *= scale;
        errors.width_b_rad *= scale;
        errors.quadrature_rad *= scale;
        errors.eccentricity = Some(Harmonic {
            amplitude_rad: 5e-4,
            phase_rad: 0.7,
        });
        errors.tilt = Some(Harmonic {
            amplitude_rad: 1e-4,
            phase_rad: -1.9,
        });
    }

    /// Runs the rig.
    ///
    /// # Errors
    /// The simulator's.
    pub fn run(self, seed: u64) -> Result<Run, TwinError> {
        Run::of(&self.twins(seed))
    }

    /// What a calibration may see of a run: headers and rows.
    ///
    /// # Errors
    /// The simulator's.
    pub fn recordings(self, seed: u64) -> Result<Vec<(Header, Vec<Row>)>, TwinError> {
        Ok(self.run(seed)?.into_recordings())
    }
}

/// Runs a simulation to its end.
#[must_use]
pub fn record(simulation: Simulation) -> Recorded {
    let header = simulation.header();
    let mut rows = Vec::new();
    let mut times = Vec::new();
    for event in simulation {
        if let Some(edge) = event.truth.edge
            && (edge == 0 || !times.is_empty())
        {
            times.push(event.row.ticks);
        }
        rows.push(event.row);
    }
    Recorded {
        header,
        rows,
        times,
    }
}

#[cfg(test)]
mod tests;
