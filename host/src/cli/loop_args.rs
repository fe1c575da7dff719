//! Options that say what a speed loop did during a recording.

use std::io::{self, Write as _};
use std::path::Path;

use clap::{Args, value_parser};

use crate::free_run::torque::TorqueRecord;
use crate::free_run::{
    FreeRun, FreeRunError, HiddenOrders, Knowledge, LoopModel, Push, hidden_orders,
};
use crate::recording::{Header, torque};
use crate::sensor::SensorPlan;
use crate::twin::Twin;

use super::Globals;
use super::failure::Failure;
use super::input::InputArgs;

/// The loop, as far as the twin does not tell.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Speed loop")]
pub struct LoopArgs {
    /// Column of REC with the torque asked for, N m: undoes what it did to the shaft
    #[arg(long, value_name = "COLUMN")]
    torque: Option<String>,
    /// Viscous friction, N m s; 0 if neither given nor in a twin
    #[arg(long, value_name = "B", value_parser = not_negative, requires = "torque")]
    viscous: Option<f64>,
    /// Sample rate of the drive, Hz: tells when a torque changed between two edges
    #[arg(long, value_name = "HZ", value_parser = positive, requires = "torque")]
    torque_rate: Option<f64>,
    /// How well the gains (or the inertia) are known, as a fraction; 0 takes them as exact
    #[arg(long, value_name = "F", default_value_t = 0.1, value_parser = fraction)]
    loop_within: f64,
    /// A sample time of the loop, in ticks of REC; looked for if not given
    #[arg(long, value_name = "TICKS", value_parser = value_parser!(u64))]
    loop_tick: Option<u64>,
    /// Bandwidth of a loop that is not undone, Hz: says which orders it may hide
    #[arg(long, value_name = "HZ", value_parser = positive, conflicts_with = "torque")]
    loop_hz: Option<f64>,
}

fn number(text: &str, fits: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && fits(value) => Ok(value),
        _ => Err(format!("give a number {wanted}")),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |value| value > 0.0, "above 0")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |value| value >= 0.0, "from 0 up")
}

fn fraction(text: &str) -> Result<f64, String> {
    number(text, |value| (0.0..=0.5).contains(&value), "from 0 to 0.5")
}

impl LoopArgs {
    /// The free run behind a recording; none where nothing is said of what drove it.
    ///
    /// # Errors
    /// A twin or torque column that can't be used, or a recording from which the loop can't be undone.
    pub fn free_run(
        &self,
        input: &InputArgs,
        twin: Option<&Twin>,
        header: &Header,
        plan: SensorPlan,
        inertia: Option<f64>,
    ) -> Result<Option<FreeRun>, Failure> {
        let Some(push) = self.push(input, twin, header, inertia)? else {
            return Ok(None);
        };
        let knowledge = Knowledge {
            gains_within: self.loop_within,
            phase: self.loop_tick.is_some(),
        };
        let failed = |source| match source {
            FreeRunError::Read(error) => Failure::Read(error),
            source => Failure::Loop {
                recording: input.recording.clone(),
                source,
            },
        };
        let open = || input.reopen().map_err(FreeRunError::from);
        FreeRun::of(open, header, plan, push, knowledge)
            .map(Some)
            .map_err(failed)
    }

    /// The orders that a loop which was not undone may hide at a speed; none where no loop is declared.
    #[must_use]
    pub fn hidden(&self, turns_per_s: f64, edges: u32) -> Option<HiddenOrders> {
        self.loop_hz
            .map(|bandwidth| hidden_orders(bandwidth, turns_per_s, edges))
    }

    #[allow(clippy::cast_precision_loss)]
    fn push(
        &self,
        input: &InputArgs,
        twin: Option<&Twin>,
        header: &Header,
        inertia: Option<f64>,
    ) -> Result<Option<Push>, Failure> {
        let clock_hz = header.clock_hz as f64;
        let Some(column) = &self.torque else {
            return Ok(twin.and_then(LoopModel::of).map(|mut model| {
                model.phase_s = self.loop_tick.unwrap_or(0) as f64 / clock_hz;
                Push::Loop(model)
            }));
        };
        let shaft = twin.map(|twin| (twin.shaft.inertia_kg_m2, twin.shaft.viscous_n_m_s));
        let shaft = shaft.filter(|(inertia, _)| *inertia > 0.0);
        let given = inertia.map(|inertia| (inertia, self.viscous.unwrap_or(0.0)));
        let Some((inertia, viscous)) = given.or(shaft) else {
            return Err(Failure::NoInertia);
        };
        let rate = self.torque_rate;
        let rate = rate.or_else(|| twin.and_then(LoopModel::of).map(|model| model.rate_hz));
        let steps = torque::open(&input.recording, column, &input.reading.options())?;
        Ok(Some(Push::Torque(TorqueRecord::new(
            &steps,
            inertia,
            viscous / inertia,
            rate.map(|rate| clock_hz / rate),
        ))))
    }
}

/// Says on stderr which gains were found in a recording.
pub fn remark_gains(recording: &Path, free: &FreeRun, globals: Globals) {
    if globals.quiet {
        return;
    }
    let mut line = format!("{}: speed loop undone", recording.display());
    if let Some(fit) = free.fit() {
        let (gains, error) = (fit.gains, fit.standard_error);
        let given = free.given();
        line += &match free.push() {
            Push::Loop(_) => format!(
                ": kp {:+.2} % (standard error {:.2} %), ki {:+.2} % ({:.2} %) from the gains given",
                100.0 * (gains.kp / given.kp - 1.0),
                100.0 * error.kp / given.kp,
                100.0 * (gains.ki / given.ki - 1.0),
                100.0 * error.ki / given.ki,
            ),
            Push::Torque(_) => format!(
                ": inertia {:+.2} % (standard error {:.2} %) from the one given",
                100.0 * (1.0 / gains.kp - 1.0),
                100.0 * error.kp,
            ),
        };
    }
    // A remark that cannot be shown is no reason to fail.
    let _ = writeln!(io::stderr(), "{line}");
}
