//! The demonstration: the paper's rig, simulated, and a recording of a real motor, each calibrated and then checked on turns that
//! were not learned from.

use std::io::Cursor;

use quadcal::slot::Slot;
use thiserror::Error;

use crate::calibrate::{self, CalibrateError, CalibrateOptions, Calibration};
use crate::findings::{Findings, class_means, distance, parameters};
use crate::recording::write::{NativeWriter, WriteError};
use crate::recording::{self, ReadError, ReadOptions, Recording};
use crate::sim::Simulation;
use crate::survey::Survey;
use crate::table_file;
use crate::twin::{Duration, Twin, TwinError};
use crate::verify::{Verification, VerifyError, verify};

/// The paper's rig with a speed that wanders by 0.1 %, as shipped.
pub const RIG_TWIN: &str = include_str!("../twins/wander-0.1.toml");

/// Three Hall sensors of a real spindle motor, as shipped.
pub const SPINDLE: &[u8] = include_bytes!("../recordings/hall-spindle.csv");

/// Turns that the paper averages over.
pub const RIG_TURNS: u32 = 11;

/// Turns simulated: those to learn from, the way there, and some to check on.
const RIG_TURNS_ALL: f64 = 20.0;

/// Table 1 of the paper: name, true value and its estimate, rad, in the order xi_A, xi_B, p.
pub const TABLE_1: [(&str, f64, f64); 3] = [
    ("Signal width error xi_A", 1.2566e-4, 1.2368e-4),
    ("Signal width error xi_B", 1.1310e-4, 1.1281e-4),
    ("Quadrature error p", 1.2566e-4, 1.3750e-4),
];

/// Why the demonstration can't run: a fault of the program, as all it reads is shipped with it.
#[derive(Debug, Error)]
pub enum DemoError {
    /// The simulator.
    #[error(transparent)]
    Twin(#[from] TwinError),
    /// A recording.
    #[error(transparent)]
    Read(Box<ReadError>),
    /// The simulated recording.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A calibration.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// A check.
    #[error(transparent)]
    Verify(#[from] VerifyError),
    /// A table.
    #[error("{}", table_file::describe(.0))]
    Table(quadcal::slot::SlotError),
}

impl From<ReadError> for DemoError {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}

/// One encoder calibrated and checked.
pub struct Run {
    /// The recording's bytes, native CSV.
    pub recording: Vec<u8>,
    /// The calibration.
    pub calibration: Calibration,
    /// What it found.
    pub findings: Findings,
    /// The table's bytes.
    pub table: Vec<u8>,
    /// The check on later turns.
    pub check: Verification,
}

/// The simulated rig and its truth, which the calibration does not see.
pub struct Rig {
    /// The run.
    pub run: Run,
    /// True errors, rad.
    pub truth_rad: Vec<f64>,
    /// RMS error without the table, rad.
    pub before_rad: f64,
    /// RMS error with it, rad.
    pub after_rad: f64,
    /// True xi_A, xi_B and p of this disc in unique form, rad.
    pub true_parameters_rad: Vec<f64>,
}

/// Simulates and calibrates the paper's rig.
///
/// # Errors
/// [`DemoError`], which would be a fault of the program.
pub fn rig() -> Result<Rig, DemoError> {
    let mut twin = Twin::parse(RIG_TWIN, "paper-rig.toml")?;
    twin.duration = Duration::Turns(RIG_TURNS_ALL);
    let simulation = Simulation::new(&twin)?;
    let truth_rad = simulation.true_errors();
    let mut writer = NativeWriter::new(Vec::new(), &simulation.header())?;
    for event in simulation {
        writer.row(&event.row)?;
    }
    let run = run(writer.finish()?, |_| CalibrateOptions {
        turns: Some(RIG_TURNS),
        ..CalibrateOptions::default()
    })?;
    let kind = run.calibration.plan.kind;
    let means = class_means(&truth_rad, kind.classes() as usize);
    let none = vec![0.0; truth_rad.len()];
    Ok(Rig {
        before_rad: distance(&truth_rad, &none),
        after_rad: distance(&truth_rad, &run.findings.error_rad),
        true_parameters_rad: parameters(kind, &means, 0.0)
            .iter()
            .map(|parameter| parameter.rad)
            .collect(),
        truth_rad,
        run,
    })
}

/// Calibrates the spindle's recording on its first half and checks on its second.
///
/// # Errors
/// [`DemoError`], which would be a fault of the program.
pub fn spindle() -> Result<Run, DemoError> {
    run(SPINDLE.to_vec(), |survey| CalibrateOptions {
        until: Some(survey.first.midpoint(survey.last)),
        ..CalibrateOptions::default()
    })
}

fn run(
    recording: Vec<u8>,
    options: impl FnOnce(&Survey) -> CalibrateOptions,
) -> Result<Run, DemoError> {
    let open = || -> Result<Recording, ReadError> {
        let bytes = Cursor::new(recording.clone());
        recording::from_reader(bytes, "recording", &ReadOptions::default())
    };
    let rows = open()?;
    let survey = Survey::of(rows.header.clone(), rows)?;
    let options = options(&survey);
    let plan = calibrate::plan(&survey, &options)?;
    let calibration = calibrate::learn(survey, plan, open()?, &options)?;
    let source = table_file::source_of_bytes(&recording);
    let table = table_file::bytes_of(&calibration, source);
    let slot: Slot<'_> = table_file::parse(&table).map_err(DemoError::Table)?;
    let clock_hz = calibration.clock_hz;
    let check = verify(&slot, plan, source, clock_hz, open()?, None)?;
    Ok(Run {
        findings: Findings::of(&calibration),
        calibration,
        table,
        check,
        recording,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::Verdict;

    #[test]
    fn the_real_spindle_scatters_less_on_its_second_half() {
        let run = spindle().unwrap();
        assert!(run.check.same_recording);
        assert_eq!(run.check.verdict(), Verdict::Better);
        assert!(run.check.scatter.after < 0.5 * run.check.scatter.before);
    }
}
