//! Kills while a table is rolled back or all are erased, each on the same two tables.

use std::fmt;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::time::{Duration, Instant};

use quadcal::stm32f405::PLACES;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::machine::{ANSWER_MAX, Machine};
use super::{FLASH, PowerCutError, SLOT_AT, build, look};

/// About how long the image takes to write one mark.
const MARK: Duration = Duration::from_micros(100);

/// What is going on when QEMU is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// The newer table is withdrawn.
    RollBack,
    /// Both are withdrawn and erased.
    Erase,
}

impl Act {
    /// The image's word for it.
    const fn word(self) -> &'static str {
        match self {
            Self::RollBack => "roll-back",
            Self::Erase => "erase",
        }
    }

    /// Sequence number of the table that counts when it is done, of tables 0 and 1.
    const fn after(self) -> Option<u32> {
        match self {
            Self::RollBack => Some(0),
            Self::Erase => None,
        }
    }
}

/// Counts over all kills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActTally {
    /// What was going on.
    pub act: Act,
    /// QEMU killed, and started once more after each.
    pub kills: u32,
    /// The newer table still counted.
    pub before: u32,
    /// What counts when all is done counted already.
    pub after: u32,
    /// The flash was neither as before nor as after.
    pub midway: u32,
}

impl fmt::Display for ActTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} kills during {}: as before {} times, as after it {} times, whole each time; {} times flash was left midway, and the store still found a whole table",
            self.kills,
            self.act.word(),
            self.before,
            self.after,
            self.midway
        )
    }
}

/// Kills the image so many times while it does `act`, half of them at random moments of the whole run, half soon after the flash
/// begins to change; `seed` decides when.
///
/// # Errors
/// [`PowerCutError`], as [`super::run`].
pub fn act(act: Act, kills: u32, seed: u64) -> Result<ActTally, PowerCutError> {
    let elf = build("qemu_store", &[])?;
    let io = |what| move |source| PowerCutError::Io { what, source };
    let folder = tempfile::tempdir().map_err(io("making a folder"))?;
    let file = folder.path().join(FLASH);
    let bytes = || std::fs::read(&file).map_err(io("reading the flash"));
    let whole_run = |words: &[&str]| -> Result<Duration, PowerCutError> {
        let mut machine = Machine::start(&elf, words, folder.path())?;
        machine.counts()?;
        let begin = Instant::now();
        machine.end()?;
        Ok(begin.elapsed())
    };
    whole_run(&[FLASH, "commit", "2"])?;
    let prepared = bytes()?;
    let time = whole_run(&[FLASH, act.word()])?;
    let done = bytes()?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut tally = ActTally {
        act,
        kills: 0,
        before: 0,
        after: 0,
        midway: 0,
    };
    for kill in 1..=kills {
        std::fs::write(&file, &prepared).map_err(io("writing the flash"))?;
        let mut machine = Machine::start(&elf, &[FLASH, act.word()], folder.path())?;
        let announced = machine.counts()?;
        if kill % 2 == 0 {
            std::thread::sleep(random.random_range(Duration::ZERO..=time));
        } else {
            // Withdrawing is a single mark: random moments of the whole run hardly ever meet it.
            wait_for_a_mark(&file, &prepared).map_err(io("watching the flash"))?;
            let (begin, wait) = (Instant::now(), random.random_range(Duration::ZERO..=MARK));
            while begin.elapsed() < wait {
                std::hint::spin_loop();
            }
        }
        machine.kill()?;
        let (found, _) = look(&file)?;
        tally.kills += 1;
        if found == announced {
            tally.before += 1;
        } else if found == act.after() {
            tally.after += 1;
        } else {
            return Err(PowerCutError::Lost {
                kill,
                announced,
                found,
            });
        }
        let left = bytes()?;
        tally.midway += u32::from(left != prepared && left != done);
        let mut machine = Machine::start(&elf, &[FLASH], folder.path())?;
        let image = machine.counts()?;
        if image != found {
            return Err(PowerCutError::Disagree { image, file: found });
        }
    }
    Ok(tally)
}

/// Returns when the marks of a place in a flash's file are no longer what they were, or much too long has passed.
pub(super) fn wait_for_a_mark(file: &Path, before: &[u8]) -> std::io::Result<()> {
    let mut flash = File::open(file)?;
    let begin = Instant::now();
    while begin.elapsed() < ANSWER_MAX {
        for place in PLACES {
            let start = place.start as usize;
            let mut marks = [0; SLOT_AT];
            flash.seek(SeekFrom::Start(place.start.into()))?;
            flash.read_exact(&mut marks)?;
            if !before[start..].starts_with(&marks) {
                return Ok(());
            }
        }
    }
    Ok(())
}
