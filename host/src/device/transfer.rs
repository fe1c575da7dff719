//! Tables read from a device and handed over to it, piece by piece.

use quadcal::recalibrate::Stage;
use quadcal::slot::{Slot, VERSION, slot_bytes};
use quadcal::wire::{Identity, PIECE_BYTES, Piece, Refusal, Reply, Request};
use thiserror::Error;

use crate::table_file::SLOT_BYTES_MAX;

use super::client::Client;
use super::error::{DeviceError, Fault};
use super::port::Port;

/// Times that reading a table begins anew, as a commit in between changes it.
const READINGS: u32 = 2;

/// Pieces of a table that are handed over anew.
const REPEATS: u32 = 16;

/// What handing a table over is called.
const LOAD: &str = "load";

/// Why a table is not for a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TableMismatch {
    /// It has another format version.
    #[error(
        "the table has format version {table}, the device takes {device}; write it again with quadcal calibrate, or update the firmware"
    )]
    Version {
        /// The table's.
        table: u16,
        /// The one that the device writes.
        device: u16,
    },
    /// It is of an encoder of another shape.
    #[error(
        "the table is of an encoder with {table} edges a turn in {table_classes} classes, the device's has {device} in {device_classes}; give \
         the table of this encoder"
    )]
    Shape {
        /// Edges of the table's.
        table: u32,
        /// Its classes.
        table_classes: u32,
        /// Edges of the device's.
        device: u32,
        /// Its classes.
        device_classes: u32,
    },
    /// It is of another encoder.
    #[error(
        "the table is of encoder {table}, the device has encoder {device}; give the table of this encoder"
    )]
    Serial {
        /// The table's serial number.
        table: u64,
        /// The device's.
        device: u64,
    },
    /// It holds for one recording only.
    #[error(
        "the table was learned without the index and holds for its recording only; calibrate with the index"
    )]
    NotIndexed,
    /// Its delays can't be told in the device's ticks.
    #[error("the table's delays don't fit the device's clock of {0} Hz; calibrate on the device")]
    Clock(u64),
}

/// Whether a table fits a device, as far as this can be told without it.
///
/// # Errors
/// [`TableMismatch`].
pub fn check(slot: &Slot<'_>, version: u16, identity: &Identity) -> Result<(), TableMismatch> {
    let header = &slot.header;
    if version != identity.slot_version {
        return Err(TableMismatch::Version {
            table: version,
            device: identity.slot_version,
        });
    }
    let (edges, classes) = (header.shape.edges(), header.shape.classes());
    if (edges, classes) != (identity.edges, identity.classes.into()) {
        return Err(TableMismatch::Shape {
            table: edges,
            table_classes: classes,
            device: identity.edges,
            device_classes: identity.classes.into(),
        });
    }
    let (table, device) = (header.stamp.serial, identity.serial);
    if table != 0 && device != 0 && table != device {
        return Err(TableMismatch::Serial { table, device });
    }
    if !header.indexed {
        return Err(TableMismatch::NotIndexed);
    }
    match header.delays.at_clock(identity.clock_hz) {
        Some(_) => Ok(()),
        None => Err(TableMismatch::Clock(identity.clock_hz)),
    }
}

impl<P: Port> Client<P> {
    /// Reads the slot in use and checks it; `progress` is told how many bytes of how many are there.
    ///
    /// # Errors
    /// [`DeviceError`], [`Fault::DamagedTable`] where what came is no slot.
    pub fn dump(&mut self, mut progress: impl FnMut(u32, u32)) -> Result<Vec<u8>, DeviceError> {
        let mut reading = 1;
        loop {
            let bytes = self.pieces(&mut progress)?;
            match Slot::parse(&bytes) {
                Ok(_) => return Ok(bytes),
                Err(_) if reading < READINGS => reading += 1,
                Err(error) => return Err(self.fault(Fault::DamagedTable(error))),
            }
        }
    }

    fn pieces(&mut self, progress: &mut impl FnMut(u32, u32)) -> Result<Vec<u8>, DeviceError> {
        const WHAT: &str = "dump";
        let mut bytes = Vec::new();
        loop {
            let wanted = u32::try_from(bytes.len()).map_err(|_| self.unknown(WHAT))?;
            match self.read(WHAT, &Request::ReadTable { offset: wanted })? {
                Reply::Table {
                    offset,
                    whole,
                    piece,
                } if offset == wanted && !piece.is_empty() && whole <= SLOT_BYTES_MAX => {
                    bytes.extend_from_slice(&piece);
                    progress(wanted + piece.len() as u32, whole);
                    if bytes.len() >= whole as usize {
                        return Ok(bytes);
                    }
                }
                _ => return Err(self.unknown(WHAT)),
            }
        }
    }

    /// Hands a slot over, after which it waits to be committed; `progress` is told how many bytes of how many are there. A piece whose
    /// reply is lost is handed over again: the device says which one it wants, and nothing is in flash yet.
    ///
    /// # Errors
    /// [`DeviceError`], [`Fault::Mismatch`] before anything is sent.
    pub fn load(
        &mut self,
        slot: &[u8],
        mut progress: impl FnMut(u32, u32),
    ) -> Result<(), DeviceError> {
        let identity = self.identify()?;
        let parsed = Slot::parse(slot).map_err(|error| self.fault(Fault::DamagedTable(error)))?;
        let version = match slot {
            [_, _, _, _, low, high, ..] => u16::from_le_bytes([*low, *high]),
            _ => VERSION,
        };
        check(&parsed, version, &identity).map_err(|error| self.fault(error.into()))?;
        let slot = &slot[..slot_bytes(parsed.header.shape).min(slot.len())];
        let (mut at, mut repeats) = (0, 0);
        while let Some(next) = self.hand_over(slot, at)? {
            if next <= at {
                repeats += 1;
            }
            if repeats > REPEATS {
                return Err(self.unknown(LOAD));
            }
            at = next.min(slot.len());
            progress(at as u32, slot.len() as u32);
        }
        progress(slot.len() as u32, slot.len() as u32);
        Ok(())
    }

    /// Hands a piece over, and says where the next one begins; none once the device has all.
    fn hand_over(&mut self, slot: &[u8], at: usize) -> Result<Option<usize>, DeviceError> {
        let end = slot.len().min(at + PIECE_BYTES);
        let piece = Piece::from_slice(slot.get(at..end).unwrap_or_default());
        let piece = piece.map_err(|_| self.unknown(LOAD))?;
        let offset = u32::try_from(at).map_err(|_| self.unknown(LOAD))?;
        let next = match self.change(LOAD, &Request::WriteTable { offset, piece }) {
            Ok(Reply::Written { whole: true, .. }) => return Ok(None),
            Ok(Reply::Written { next, .. }) => next,
            Ok(_) => return Err(self.unknown(LOAD)),
            Err(error) => match error.fault {
                Fault::Refused {
                    refusal: Refusal::Offset(next),
                    ..
                } => next,
                // The last piece may have arrived, although its reply did not.
                Fault::Unanswered { .. } if self.status()?.stage == Stage::ReadyToCommit => {
                    return Ok(None);
                }
                Fault::Unanswered { .. } => offset,
                _ => return Err(error),
            },
        };
        Ok(Some(next as usize))
    }
}
