//! A trial in the field, whole: firmware in QEMU, a simulated, badly made encoder behind it whose edges come in real time, and a host at
//! its port. Everything that is reported comes from the device, over the wire.

mod bench;
pub mod drive;
mod error;
pub mod ripple;
pub mod shaft;
mod timer;

use std::time::{Duration, Instant};

use quadcal::recalibrate::{Figures, Options, Stage};
use quadcal::wire::{Learned, Request, Status, TableInfo};
use quadcal_host::pretend::Pretend;
use quadcal_host::twin::Twin;

use drive::{Host, LINES};
use ripple::{Answers, Ripple, Speeds};

pub use bench::Bench;
pub use error::TrialError;

/// Longest time that anything may take that the trial waits for.
const WAIT: Duration = Duration::from_secs(180);

/// Time between two looks at a calibration.
const LOOK: Duration = Duration::from_millis(20);

/// Ripple without a table over ripple with it, at least, for a trial that went well.
pub const GAIN_LEAST: f64 = 10.0;

/// What is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Seed of the encoder's errors and the shaft's wander.
    pub seed: u64,
    /// Speed of the shaft, r/min.
    pub r_min: f64,
    /// Turns to learn from.
    pub turns: u16,
    /// Fresh turns to prove the table on.
    pub proof_turns: u8,
    /// Speeds that are asked for, before and after.
    pub samples: usize,
}

impl Default for Trial {
    fn default() -> Self {
        Self {
            seed: 1,
            r_min: 300.0,
            turns: 32,
            proof_turns: 8,
            samples: 500,
        }
    }
}

/// What has just been done.
#[derive(Clone, Copy, Debug)]
pub enum Progress {
    /// The image is built, flash is empty, the drive is on.
    Started,
    /// No table, so the speed is as the encoder has it.
    Uncorrected(Ripple),
    /// The calibration goes on.
    Calibrating(Status),
    /// A table waits: what was learned, and the figures on fresh turns.
    Proven(Learned, Figures),
    /// It is in flash and in use.
    Committed(TableInfo),
    /// The drive was killed and switched on again.
    Rebooted,
    /// The speed with the table that was found in flash.
    Corrected(TableInfo, Ripple),
}

/// What a trial showed.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Speed without a table.
    pub before: Ripple,
    /// While it learned, solved and proved, uncorrected as before.
    pub meanwhile: Ripple,
    /// What the device says it learned.
    pub learned: Learned,
    /// No table against the new one, on fresh turns.
    pub figures: Figures,
    /// The table in use after the reboot.
    pub table: TableInfo,
    /// Speed with it.
    pub after: Ripple,
    /// RAM that the image took until it had committed: statics, and stack at its deepest.
    pub memory: Memory,
    /// How soon it answered while it learned and proved.
    pub answers_at_work: Answers,
    /// How soon it answered while it solved.
    pub answers_solving: Answers,
}

/// RAM of an image, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// All statics, the estimator's buffers among them.
    pub statics: u64,
    /// Stack at its deepest.
    pub stack: u64,
}

impl Memory {
    /// The last that an image logged of it.
    fn logged(log: &str) -> Option<Self> {
        let last = |key: &str| {
            let words = log.split_ascii_whitespace().rev();
            let mut numbers = words.filter_map(|word| word.strip_prefix(key)?.parse().ok());
            numbers.next()
        };
        Some(Self {
            statics: last("static_bytes=")?,
            stack: last("stack_bytes=")?,
        })
    }
}

impl Outcome {
    /// Whether the speed handed out is more even with the table from flash, by [`GAIN_LEAST`] at least.
    #[must_use]
    pub fn is_better(&self) -> bool {
        self.after.given * GAIN_LEAST < self.before.given
    }
}

impl Trial {
    /// The badly made encoder and its shaft: the paper's.
    #[must_use]
    pub fn twin(&self) -> Twin {
        let rig = Pretend {
            lines: LINES,
            r_min: self.r_min,
            seed: self.seed,
            ..Pretend::default()
        };
        rig.twin()
    }

    /// Does it, and leaves the drive on. `progress` is told of every step.
    ///
    /// # Errors
    /// [`TrialError`].
    pub fn run(&self, mut progress: impl FnMut(Progress)) -> Result<(Outcome, Bench), TrialError> {
        let mut bench = Bench::start(&self.twin())?;
        let mut host = bench.drive.connect()?;
        progress(Progress::Started);
        if let Some(table) = host.status()?.table {
            return Err(TrialError::TableAlready(table));
        }
        let before = ripple(&Speeds::sample(&mut host, self.samples)?)?;
        progress(Progress::Uncorrected(before));

        let work = self.calibrate(&mut host, &mut progress)?;
        let learned = host.result()?.ok_or(TrialError::Missing("result"))?;
        let figures = host.preview()?.ok_or(TrialError::Missing("preview"))?;
        progress(Progress::Proven(learned, figures));
        let committed = host.commit()?.ok_or(TrialError::Missing("table"))?;
        progress(Progress::Committed(committed));

        let log = bench.reboot()?;
        let memory = Memory::logged(&log).ok_or(TrialError::Missing("log"))?;
        progress(Progress::Rebooted);
        let mut host = bench.drive.connect()?;
        let found = host.status()?.table;
        let table = found
            .filter(|found| *found == committed)
            .ok_or(TrialError::Lost { committed, found })?;
        let after = ripple(&Speeds::sample(&mut host, self.samples)?)?;
        progress(Progress::Corrected(table, after));
        let outcome = Outcome {
            before,
            meanwhile: ripple(&work.speeds)?,
            learned,
            figures,
            table,
            after,
            memory,
            answers_at_work: work.at_work,
            answers_solving: work.solving,
        };
        Ok((outcome, bench))
    }

    /// Starts a calibration and looks on until a table waits.
    fn calibrate(
        &self,
        host: &mut Host,
        progress: &mut impl FnMut(Progress),
    ) -> Result<Work, TrialError> {
        let options = Options {
            turns: self.turns,
            proof_turns: self.proof_turns,
            ..Options::default()
        };
        host.change("recalibrate", &Request::Start(options))?;
        let (begin, mut work) = (Instant::now(), Work::default());
        let mut stage = Stage::Idle;
        loop {
            let answers = match stage {
                Stage::Solving => &mut work.solving,
                _ => &mut work.at_work,
            };
            let live = answers.time(|| host.live())?;
            let status = host.status()?;
            progress(Progress::Calibrating(status));
            work.speeds.add(&live);
            stage = status.stage;
            match stage {
                Stage::ReadyToCommit => return Ok(work),
                Stage::Failed(failure) => return Err(TrialError::Calibration(failure)),
                stage if begin.elapsed() > WAIT => return Err(TrialError::Stuck { stage }),
                _ => {}
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// What was seen while a calibration went on.
#[derive(Default)]
struct Work {
    speeds: Speeds,
    at_work: Answers,
    solving: Answers,
}

fn ripple(speeds: &Speeds) -> Result<Ripple, TrialError> {
    speeds.ripple().ok_or(TrialError::Missing("speed"))
}
