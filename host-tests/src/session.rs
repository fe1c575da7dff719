//! The sessions that firmware images run ([`quadcal::replay`]), on the host: event file in, slot and corrected file out.

use std::convert::Infallible;

use quadcal::replay::{self, HEADER_LEN, Header, Part, ReadError, Report, SessionError};
use quadcal::slot::Slot;
use quadcal_host::buffers::HeapBuffers;

/// What a session wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The learned table, as a slot.
    pub slot: Vec<u8>,
    /// The corrected file.
    pub corrected: Vec<u8>,
    /// What was done.
    pub report: Report,
}

/// Runs a session on the bytes of an event file, with memory for the encoder that it names.
///
/// # Errors
/// As the session.
pub fn run(file: &[u8]) -> Result<Written, SessionError<Infallible>> {
    let head = file
        .first_chunk::<HEADER_LEN>()
        .ok_or(ReadError::Truncated { offset: file.len() })?;
    let header = Header::parse(head).map_err(|error| ReadError::Format { offset: 0, error })?;
    let (mut slot, mut corrected) = (Vec::new(), Vec::new());
    let sink = |part, bytes: &[u8]| {
        match part {
            Part::Slot => slot.extend_from_slice(bytes),
            Part::Corrected => corrected.extend_from_slice(bytes),
        }
        Ok(())
    };
    let buffers = HeapBuffers::new(4 * header.lines as usize);
    let report = replay::run(source(file), &mut [0; 4096], buffers, sink)?;
    Ok(Written {
        slot,
        corrected,
        report,
    })
}

/// Corrects all of an event file with a table: the corrected file.
///
/// # Errors
/// As the session.
pub fn correct(file: &[u8], slot: &Slot<'_>) -> Result<Vec<u8>, SessionError<Infallible>> {
    let mut corrected = Vec::new();
    let sink = |bytes: &[u8]| {
        corrected.extend_from_slice(bytes);
        Ok(())
    };
    replay::correct(source(file), &mut [0; 4096], slot, sink)?;
    Ok(corrected)
}

/// Hands a file out in blocks.
fn source(mut file: &[u8]) -> impl FnMut(&mut [u8]) -> Result<usize, Infallible> {
    move |block| {
        let (now, later) = file.split_at(block.len().min(file.len()));
        block[..now.len()].copy_from_slice(now);
        file = later;
        Ok(now.len())
    }
}
