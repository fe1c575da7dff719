//! The power cut while a drive commits: image `qemu_store` commits table after table into a flash that is a file, QEMU is killed at
//! a random moment (SIGKILL), and the next start says which table counts.
//!
//! After every kill the file is looked at here too: the table that counts must be the last that was announced, or the one after
//! it, and every byte of it must be as its sequence number says.

mod act;
mod commanded;
mod machine;
mod ram;

#[path = "../../src/bin/tables/derive.rs"]
mod derive;

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use quadcal::slot::{self, slot_bytes};
use quadcal::stm32f405::{PLACES, layout};
use quadcal::store::{Place, Store};
use quadcal_host::device::DeviceError;
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::field_trial::TrialError;
use crate::firmware::{FirmwareError, build};
use derive::EDGES;
use machine::Machine;
use ram::Ram;

pub use act::{Act, ActTally, act};
pub use commanded::{Command, CommandTally, commanded};

/// Where the slot begins in a place.
const SLOT_AT: usize = 96;

/// Commits that a run is left time for at most, after it has said what counts.
const COMMITS_MAX: u32 = 3;

/// Name of the flash's file, and of the one on which it is measured how long a commit takes on this machine.
const FLASH: &str = "flash.bin";
const MEASURED: &str = "measured.bin";

/// What a kill left at the place that does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Left {
    /// A whole table, or nothing but blank flash: nothing was being written.
    Whole,
    /// A sector with bits risen in parts of it.
    HalfErased,
    /// A table in part.
    HalfWritten {
        /// Whether its last word is neither blank nor what it was to be.
        torn: bool,
    },
}

impl From<DeviceError> for PowerCutError {
    fn from(error: DeviceError) -> Self {
        Self::Drive(error.into())
    }
}

/// Counts over all kills.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// QEMU killed, and started once more after each.
    pub kills: u32,
    /// The table that was the last announced counted.
    pub old: u32,
    /// The one after it counted already.
    pub new: u32,
    /// The kill left a sector erased in parts.
    pub half_erased: u32,
    /// The kill left a table written in parts.
    pub half_written: u32,
    /// Of those, with a word some of whose bits had fallen.
    pub torn_words: u32,
    /// Tables committed and announced.
    pub commits: u32,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} kills in {} commits: the last table announced counted {} times, the next one {} times, and each was whole; left \
             behind were {} half-erased places and {} half-written ones, {} of them with a torn word",
            self.kills,
            self.commits,
            self.old,
            self.new,
            self.half_erased,
            self.half_written,
            self.torn_words
        )
    }
}

/// Why a table was lost, or nothing could be said.
#[derive(Debug, thiserror::Error)]
pub enum PowerCutError {
    /// The image can't be built or started.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The drive can't be started or asked.
    #[error(transparent)]
    Drive(#[from] TrialError),
    /// The file or a pipe can't be read.
    #[error("{what}: {source}")]
    Io {
        /// What was tried.
        what: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The image did not say what counts in time.
    #[error("the image did not say which table counts; it printed `{0}`")]
    Silent(String),
    /// After a kill another table counts than may.
    #[error("kill {kill}: after {announced:?} was announced, {found:?} counts")]
    Lost {
        /// Number of the kill, from 1.
        kill: u32,
        /// Sequence number of the last table announced.
        announced: Option<u32>,
        /// The one that counts.
        found: Option<u32>,
    },
    /// A table counts that is not the one of its sequence number.
    #[error("the table of sequence {0} is not whole")]
    Torn(u32),
    /// The image says that another table counts than the file does.
    #[error("the image takes {image:?} to count, the file holds {file:?}")]
    Disagree {
        /// Sequence number according to the image.
        image: Option<u32>,
        /// According to the file.
        file: Option<u32>,
    },
    /// The tables of this test are refused.
    #[error("{0}")]
    Table(String),
}

/// Kills the image so many times; `seed` decides when. The tables go on from kill to kill.
///
/// # Errors
/// [`PowerCutError`]: the first table that was lost, or that nothing could be said.
pub fn run(kills: u32, seed: u64) -> Result<Tally, PowerCutError> {
    let elf: PathBuf = build("qemu_store", &[])?;
    let io = |what| move |source| PowerCutError::Io { what, source };
    let folder = tempfile::tempdir().map_err(io("making a folder"))?;
    let file = folder.path().join(FLASH);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut tally = Tally::default();
    let mut counts = None;
    let run_max = commits_time(&elf, folder.path())?;
    for kill in 1..=kills {
        let mut machine = Machine::start(&elf, &[FLASH, "loop"], folder.path())?;
        let image = machine.counts()?;
        if image != counts {
            return Err(PowerCutError::Disagree {
                image,
                file: counts,
            });
        }
        std::thread::sleep(random.random_range(Duration::ZERO..run_max));
        let committed = machine.kill()?;
        tally.kills += 1;
        tally.commits += committed.len() as u32;
        let announced = committed.last().copied().or(counts);
        let (found, left) = look(&file)?;
        let next = announced.map_or(0, |sequence| sequence + 1);
        if found == Some(next) {
            tally.new += 1;
        } else if found == announced {
            tally.old += 1;
        } else {
            return Err(PowerCutError::Lost {
                kill,
                announced,
                found,
            });
        }
        tally.half_erased += u32::from(left == Left::HalfErased);
        tally.half_written += u32::from(matches!(left, Left::HalfWritten { .. }));
        tally.torn_words += u32::from(left == Left::HalfWritten { torn: true });
        counts = found;
    }
    let mut machine = Machine::start(&elf, &[FLASH], folder.path())?;
    let image = machine.counts()?;
    machine.kill()?;
    if image == counts {
        Ok(tally)
    } else {
        Err(PowerCutError::Disagree {
            image,
            file: counts,
        })
    }
}

/// How long so many commits take as a run may make at most.
fn commits_time(elf: &Path, folder: &Path) -> Result<Duration, PowerCutError> {
    let commits = COMMITS_MAX.to_string();
    let mut machine = Machine::start(elf, &[MEASURED, "commit", &commits], folder)?;
    machine.counts()?;
    let begin = Instant::now();
    machine.end()?;
    Ok(begin.elapsed())
}

/// The sequence number of the table that counts in a flash's file, after comparing it, and what is at the other place.
fn look(file: &Path) -> Result<(Option<u32>, Left), PowerCutError> {
    let bytes = std::fs::read(file).map_err(|source| PowerCutError::Io {
        what: "reading the flash",
        source,
    })?;
    let mut ram = Ram { bytes };
    let layout = layout(&ram).map_err(|error| PowerCutError::Table(format!("{error:?}")))?;
    let newest = Store::new(&mut ram, layout).newest();
    let newest = newest.map_err(|error| PowerCutError::Table(format!("{error:?}")))?;
    let Some(found) = newest else {
        return Ok((None, left(ram.place(PLACES[0].clone()), 0)?));
    };
    let sequence = found.header.stamp.sequence;
    if !ram.bytes[found.offset as usize..].starts_with(&slot_of(sequence)?) {
        return Err(PowerCutError::Torn(sequence));
    }
    let idle = found.place.other();
    let place = ram.place(PLACES[usize::from(idle == Place::B)].clone());
    Ok((Some(sequence), left(place, sequence + 1)?))
}

/// What is at a place that was to get the table of sequence number `next`.
fn left(place: &[u8], next: u32) -> Result<Left, PowerCutError> {
    let before = next.checked_sub(2).map(slot_of).transpose()?;
    let new = slot_of(next)?;
    let slot = &place[SLOT_AT..SLOT_AT + new.len()];
    if before.is_some_and(|before| slot == before) || place.iter().all(|byte| *byte == 0xFF) {
        return Ok(Left::Whole);
    }
    // Written in order: new words, perhaps one that is torn, blank words.
    let words = slot.as_chunks::<4>().0.iter().zip(new.as_chunks::<4>().0);
    let mut rest = words.skip_while(|(there, new)| there == new).peekable();
    let blank = |word: &[u8; 4]| *word == [0xFF; 4];
    let torn = rest.next_if(|(there, _)| !blank(there)).is_some();
    Ok(if rest.all(|(there, _)| blank(there)) {
        Left::HalfWritten { torn }
    } else {
        Left::HalfErased
    })
}

/// The bytes of the slot with this sequence number.
fn slot_of(sequence: u32) -> Result<Vec<u8>, PowerCutError> {
    let wrong = |error| PowerCutError::Table(format!("{error:?}"));
    let header = derive::header(sequence).map_err(wrong)?;
    let entries: Vec<i16> = (0..EDGES as u32)
        .map(|edge| derive::entry(sequence, edge))
        .collect();
    let mut bytes = Vec::with_capacity(slot_bytes(header.shape));
    let Ok(()) = slot::write(&header, &entries, |piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    });
    Ok(bytes)
}

#[cfg(test)]
mod tests;
