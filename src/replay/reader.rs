//! Events from an event file that comes in blocks.

use core::fmt;

use super::{Event, HEADER_LEN, Header, RECORD_LEN, ReplayError};

/// Why an event file can't be read; `F` is the source's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReadError<F> {
    /// The source failed.
    Source(F),
    /// The header or record at this byte is wrong.
    Format {
        /// Byte offset of the header or record.
        offset: usize,
        /// What is wrong with it.
        error: ReplayError,
    },
    /// The file ends inside the header or record at this byte.
    Truncated {
        /// Byte offset.
        offset: usize,
    },
}

impl<F: fmt::Display> fmt::Display for ReadError<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => error.fmt(f),
            Self::Format { offset, error } => write!(f, "byte {offset}: {error}"),
            Self::Truncated { offset } => write!(f, "byte {offset}: the file ends inside a record"),
        }
    }
}

impl<F: fmt::Debug + fmt::Display> core::error::Error for ReadError<F> {}

/// Reads an event file through a block of memory.
pub struct EventReader<'a, S> {
    source: S,
    block: &'a mut [u8],
    header: Header,
    /// The block's bytes not yet parsed.
    at: usize,
    end: usize,
    /// Byte of the file at `at`.
    offset: usize,
    last_block: bool,
}

impl<'a, S, F> EventReader<'a, S>
where
    S: FnMut(&mut [u8]) -> Result<usize, F>,
{
    /// Reads the header. `source` fills its buffer and says how many bytes came, fewer than asked for only at the end. The
    /// block is used in whole records, and must hold one at least.
    ///
    /// # Errors
    /// [`ReadError`] for a file without a valid header.
    pub fn new(mut source: S, block: &'a mut [u8]) -> Result<Self, ReadError<F>> {
        let mut head = [0; HEADER_LEN];
        let got = source(&mut head).map_err(ReadError::Source)?;
        if got < HEADER_LEN {
            return Err(ReadError::Truncated { offset: got });
        }
        let header =
            Header::parse(&head).map_err(|error| ReadError::Format { offset: 0, error })?;
        let whole = block.len() / RECORD_LEN * RECORD_LEN;
        Ok(Self {
            source,
            block: &mut block[..whole],
            header,
            at: 0,
            end: 0,
            offset: HEADER_LEN,
            last_block: false,
        })
    }

    /// The file's header.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next event, none at the file's end.
    ///
    /// # Errors
    /// [`ReadError`] with the byte at which the file is wrong.
    pub fn next_event(&mut self) -> Result<Option<Event>, ReadError<F>> {
        if self.at == self.end {
            if self.last_block {
                return Ok(None);
            }
            self.at = 0;
            self.end = (self.source)(self.block).map_err(ReadError::Source)?;
            self.last_block = self.end < self.block.len() || self.block.is_empty();
            if self.end == 0 {
                return Ok(None);
            }
        }
        let offset = self.offset;
        let record = self.block[self.at..self.end]
            .first_chunk()
            .ok_or(ReadError::Truncated { offset })?;
        self.at += RECORD_LEN;
        self.offset += RECORD_LEN;
        Event::parse(record, self.header.timer)
            .map(Some)
            .map_err(|error| ReadError::Format { offset, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge::Levels;
    use crate::replay::{TimerWidth, Wiring};
    use std::vec::Vec;

    fn file(events: &[Event]) -> Vec<u8> {
        let header = Header {
            timer: TimerWidth::Bits16,
            wiring: Wiring::Quadrature,
            lines: 4,
            clock_hz: 1,
            turns: 2,
        };
        let mut bytes = header.emit().to_vec();
        events.iter().for_each(|event| bytes.extend(event.emit()));
        bytes
    }

    fn read(mut bytes: &[u8], block: usize) -> Result<Vec<Event>, ReadError<()>> {
        let source = |buffer: &mut [u8]| {
            let take = buffer.len().min(bytes.len());
            buffer[..take].copy_from_slice(&bytes[..take]);
            bytes = &bytes[take..];
            Ok(take)
        };
        let mut block = std::vec![0; block];
        let mut reader = EventReader::new(source, &mut block)?;
        let mut events = Vec::new();
        while let Some(event) = reader.next_event()? {
            events.push(event);
        }
        Ok(events)
    }

    fn sent() -> Vec<Event> {
        let capture = |raw| Event::Capture {
            raw,
            levels: Levels(1),
            overflow_pending: false,
        };
        (0..20).map(capture).chain([Event::Overflow]).collect()
    }

    #[test]
    fn every_event_comes_through_blocks_of_any_size() {
        for block in [8, 9, 24, 56, 168, 169, 1000] {
            assert_eq!(read(&file(&sent()), block), Ok(sent()), "{block}");
        }
    }

    #[test]
    fn errors_name_their_byte() {
        let good = file(&sent());
        for block in [8, 40, 1000] {
            assert_eq!(
                read(&good[..9], block),
                Err(ReadError::Truncated { offset: 9 })
            );
            assert_eq!(
                read(&good[..20 + 85], block),
                Err(ReadError::Truncated { offset: 100 })
            );
            let mut bad = good.clone();
            bad[36] = 7;
            let error = ReplayError::Kind(7);
            assert_eq!(
                read(&bad, block),
                Err(ReadError::Format { offset: 36, error })
            );
        }
    }
}
