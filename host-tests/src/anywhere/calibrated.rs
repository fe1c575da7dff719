//! A rig's recordings through the calibration that users run, and what it came to.

use quadcal::estimate::DriveKnowledge;
use quadcal_host::calibrate::{self, CalibrateError, CalibrateOptions, Calibration, Learner};
use quadcal_host::free_run::{self, FreeRun, FreeRunError, Gains, Knowledge, LoopModel, Push};
use quadcal_host::survey::Survey;

use super::{Recorded, Rig, Run, Scenario};
use crate::accuracy::{rms, table_rad};

/// What is said of a speed loop's gains: factors on the true kp and ki.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenGains {
    /// On kp.
    pub kp: f64,
    /// On ki.
    pub ki: f64,
    /// How well they are said to be known; 0 takes them as they are.
    pub within: f64,
}

impl GivenGains {
    /// The true ones, taken as they are.
    pub const EXACT: Self = Self {
        kp: 1.0,
        ki: 1.0,
        within: 0.0,
    };
}

impl Rig {
    /// What a user knows of the drive: at one speed, with nothing but the motor on the shaft, its five pole pairs.
    #[must_use]
    pub fn knowledge(self) -> DriveKnowledge {
        let one_speed = matches!(
            self.scenario,
            Scenario::OneSpeed | Scenario::OneSpeedCogging
        );
        DriveKnowledge {
            torque_base: if one_speed { 5 } else { 0 },
            hidden_up_to: 0,
        }
    }

    /// Calibrates on a run's recordings together, as `quadcal calibrate` does; a speed loop is undone with the gains given.
    ///
    /// # Errors
    /// [`CalibrateError`] of the recordings.
    ///
    /// # Panics
    /// When a loop can't be undone: a fault of the test.
    pub fn calibrate(
        self,
        run: &Run,
        seed: u64,
        gains: GivenGains,
    ) -> Result<Calibration, CalibrateError> {
        let options = CalibrateOptions {
            lines: Some(self.lines),
            drive: self.knowledge(),
            ..CalibrateOptions::default()
        };
        let models = self
            .twins(seed)
            .iter()
            .map(LoopModel::of)
            .collect::<Vec<_>>();
        let mut learner: Option<Learner> = None;
        let mut runs = Vec::new();
        for (recorded, model) in run.recordings.iter().zip(models) {
            let rows = || recorded.rows.iter().copied().map(Ok);
            let mut survey = Survey::of(recorded.header.clone(), rows())?;
            let plan = calibrate::plan(&survey, &options)?;
            let free = model.map(|model| undone(recorded, plan, model, gains).expect("a loop"));
            if let Some(free) = &free {
                survey = free.survey(survey);
            }
            let clock_hz = survey.header.clock_hz;
            let learner = match &mut learner {
                Some(learner) => learner,
                none => none.insert(Learner::new(plan, clock_hz, options.drive)?.comparing_discs()),
            };
            learner.add(survey, free_run::rows(free.as_ref(), rows()), &options)?;
            runs.push(free);
        }
        let solved = learner.expect("a rig has recordings").solve()?;
        let runs: Vec<Option<&FreeRun>> = runs.iter().map(Option::as_ref).collect();
        Ok(solved.with_loops_undone(&runs))
    }
}

fn undone(
    recorded: &Recorded,
    plan: quadcal_host::sensor::SensorPlan,
    model: LoopModel,
    given: GivenGains,
) -> Result<FreeRun, FreeRunError> {
    let Gains { kp, ki } = model.gains;
    let push = Push::Loop(LoopModel {
        gains: Gains {
            kp: kp * given.kp,
            ki: ki * given.ki,
        },
        ..model
    });
    let knowledge = Knowledge {
        gains_within: given.within,
        phase: true,
    };
    let open = || Ok(recorded.rows.iter().copied().map(Ok));
    FreeRun::of(open, &recorded.header, plan, push, knowledge)
}

/// A calibration against the truth.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// RMS of the encoder's error, rad.
    pub raw: f64,
    /// RMS of what the table leaves of it.
    pub left: f64,
    /// What the calibration says of that itself.
    pub standard_error: f64,
    /// Share of edges whose error is within 1.96 standard errors of the table.
    pub covered: f64,
}

impl Judged {
    /// Compares a calibration with a run's truth.
    #[must_use]
    pub fn of(calibration: &Calibration, run: &Run) -> Self {
        let table = table_rad(&calibration.solution);
        let rest: Vec<f64> = run.truth.iter().zip(&table).map(|(e, c)| e - c).collect();
        let standard_error = calibration.standard_error_rad();
        let within = rest
            .iter()
            .filter(|off| off.abs() <= 1.96 * standard_error)
            .count();
        Self {
            raw: rms(&run.truth),
            left: rms(&rest),
            standard_error,
            covered: within as f64 / rest.len() as f64,
        }
    }
}
