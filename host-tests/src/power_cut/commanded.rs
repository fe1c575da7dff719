//! Kills while a drive commits, rolls back or erases by command: image `qemu_device`, a host at its port, each on the same two tables.

use std::fmt;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use quadcal::recalibrate::Stage;
use quadcal::wire::{LogLevel, Request};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use super::act::wait_for_a_mark;
use super::machine::Machine;
use super::{PowerCutError, build, look, slot_of};
use crate::field_trial::drive::{self, Drive, FLASH, Host};

/// Sequence numbers of the two tables there are, the newer one being in use.
const OLDER: u32 = 0;
const NEWER: u32 = 1;

/// Longest time after a mark has changed until the kill, of those kills that wait for one.
const MARK: Duration = Duration::from_micros(500);

/// What is commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// A table that was handed over is written.
    Commit,
    /// The newer table is withdrawn.
    RollBack,
    /// Both are withdrawn and erased.
    Erase,
}

impl Command {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Commit, Self::RollBack, Self::Erase];

    const fn request(self) -> Request {
        match self {
            Self::Commit => Request::Commit,
            Self::RollBack => Request::RollBack,
            Self::Erase => Request::Erase,
        }
    }

    /// Sequence number of the table that counts when it is done.
    const fn after(self) -> Option<u32> {
        match self {
            Self::Commit => Some(NEWER + 1),
            Self::RollBack => Some(OLDER),
            Self::Erase => None,
        }
    }
}

/// Counts over all kills during one command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandTally {
    /// What was commanded.
    pub command: Command,
    /// QEMU killed, and started once more after each.
    pub kills: u32,
    /// The newer table still counted.
    pub before: u32,
    /// What counts when all is done counted already.
    pub after: u32,
    /// The flash was neither as before nor as after.
    pub midway: u32,
}

impl fmt::Display for CommandTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} kills during {:?} by command: as before {} times, as after it {} times, whole each time; {} times flash was left midway, and the store still found a whole table",
            self.kills, self.command, self.before, self.after, self.midway
        )
    }
}

/// What all kills of one command share.
struct Rig {
    command: Command,
    folder: TempDir,
    elf: PathBuf,
    /// The flash with the two tables, and when the command was followed.
    prepared: Vec<u8>,
    done: Vec<u8>,
    /// How long following it takes.
    time: Duration,
}

/// Kills a drive so many times while it follows a command, at random moments of all the time that this takes; but for a commit, every other
/// one soon after the flash begins to change. `seed` decides when. After each the file is looked at, the drive is started again, and its
/// status and table are read over the port.
///
/// # Errors
/// [`PowerCutError`], as [`super::run`].
pub fn commanded(command: Command, kills: u32, seed: u64) -> Result<CommandTally, PowerCutError> {
    let rig = Rig::new(command)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut tally = CommandTally {
        command,
        kills: 0,
        before: 0,
        after: 0,
        midway: 0,
    };
    for kill in 1..=kills {
        // Withdrawing is a single mark: random moments of the whole command hardly ever meet it.
        let wait_for_mark = kill % 2 == 0 && command != Command::Commit;
        rig.kill(wait_for_mark, &mut random)?;
        let found = rig.counts()?;
        tally.kills += 1;
        if found == Some(NEWER) {
            tally.before += 1;
        } else if found == command.after() {
            tally.after += 1;
        } else {
            return Err(PowerCutError::Lost {
                kill,
                announced: Some(NEWER),
                found,
            });
        }
        let left = rig.flash()?;
        tally.midway += u32::from(left != rig.prepared && left != rig.done);
        rig.restart(found)?;
    }
    Ok(tally)
}

impl Rig {
    /// Two tables in flash; then the command is followed once.
    fn new(command: Command) -> Result<Self, PowerCutError> {
        let folder = tempfile::tempdir().map_err(|source| PowerCutError::Io {
            what: "making a folder",
            source,
        })?;
        let store = build("qemu_store", &[])?;
        Machine::start(&store, &[FLASH, "commit", "2"], folder.path())?.end()?;
        let mut rig = Self {
            command,
            folder,
            elf: drive::build()?,
            prepared: Vec::new(),
            done: Vec::new(),
            time: Duration::ZERO,
        };
        rig.prepared = rig.flash()?;
        let (mut drive, mut host) = rig.ready()?;
        let begin = Instant::now();
        host.change("follow", &command.request())?;
        while host.status()?.stage == Stage::Committing {}
        rig.time = begin.elapsed();
        drive.cut_power()?;
        rig.done = rig.flash()?;
        Ok(rig)
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(FLASH)
    }

    fn flash(&self) -> Result<Vec<u8>, PowerCutError> {
        std::fs::read(self.path()).map_err(|source| PowerCutError::Io {
            what: "reading the flash",
            source,
        })
    }

    fn counts(&self) -> Result<Option<u32>, PowerCutError> {
        Ok(look(&self.path())?.0)
    }

    /// A drive on the two tables, and a host with an open session; a third table waits where it is to be committed.
    fn ready(&self) -> Result<(Drive, Host), PowerCutError> {
        std::fs::write(self.path(), &self.prepared).map_err(|source| PowerCutError::Io {
            what: "writing the flash",
            source,
        })?;
        let mut drive = Drive::start(&self.elf, self.folder.path(), None)?;
        let mut host = drive.connect()?;
        if self.command == Command::Commit {
            host.load(&slot_of(NEWER + 1)?, |_, _| ())?;
        } else {
            host.change("open a session", &Request::LogLevel(LogLevel::Off))?;
        }
        Ok((drive, host))
    }

    /// Gives the command, and kills the drive while it is followed.
    fn kill(&self, wait_for_mark: bool, random: &mut impl Rng) -> Result<(), PowerCutError> {
        let (mut drive, mut host) = self.ready()?;
        let longest = if wait_for_mark { MARK } else { self.time };
        let wait = random.random_range(Duration::ZERO..=longest);
        thread::scope(|scope| {
            // What it answers, if it still does, says nothing: the reply may have been cut off.
            scope.spawn(move || drop(host.change("follow", &self.command.request())));
            if wait_for_mark {
                wait_for_a_mark(&self.path(), &self.prepared).map_err(|source| {
                    PowerCutError::Io {
                        what: "watching the flash",
                        source,
                    }
                })?;
            }
            let begin = Instant::now();
            while begin.elapsed() < wait {
                std::hint::spin_loop();
            }
            drive.cut_power()?;
            Ok(())
        })
    }

    /// Starts the drive again: it must correct with the table that counts in the file, and hand it out byte by byte.
    fn restart(&self, file: Option<u32>) -> Result<(), PowerCutError> {
        let mut drive = Drive::start(&self.elf, self.folder.path(), None)?;
        let mut host = drive.connect()?;
        let image = host.status()?.table.map(|table| table.sequence);
        if image != file {
            return Err(PowerCutError::Disagree { image, file });
        }
        if let Some(sequence) = file
            && host.dump(|_, _| ())? != slot_of(sequence)?
        {
            return Err(PowerCutError::Torn(sequence));
        }
        Ok(())
    }
}
