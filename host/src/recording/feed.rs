//! Bytes for the VCD parser, so that it cannot be made to hold more of a file than a command should have.

use std::io::{self, BufRead, ErrorKind, Read};

use thiserror::Error;

use super::lines::{Input, LINE_LIMIT};

/// Bytes read from the system at a time.
const BUFFER: usize = 64 * 1024;

/// Why the feed refuses to go on; travels through the parser inside an [`io::Error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(super) enum FeedError {
    /// One command is longer than [`LINE_LIMIT`].
    #[error("command too long")]
    TooLong,
    /// A NUL byte.
    #[error("not text")]
    NotText,
}

/// Reads ahead into a fixed buffer and counts what each command takes.
pub(super) struct Feed {
    input: Input,
    buffer: Box<[u8]>,
    start: usize,
    end: usize,
    consumed: u64,
    budget: usize,
    /// The last byte of the file, once its end is reached.
    ending: Option<u8>,
    last: u8,
}

impl Feed {
    pub fn new(input: Input) -> Self {
        Self {
            input,
            buffer: vec![0; BUFFER].into_boxed_slice(),
            start: 0,
            end: 0,
            consumed: 0,
            budget: LINE_LIMIT,
            ending: None,
            last: b'\n',
        }
    }

    /// Starts the count of a new command.
    pub fn renew(&mut self) {
        self.budget = LINE_LIMIT;
    }

    /// Bytes of the file handed out so far.
    pub fn consumed(&self) -> u64 {
        self.consumed
    }

    /// Whether all bytes are handed out and the file ended without a blank or line end behind its last word.
    pub fn ended_in_a_word(&self) -> bool {
        self.start == self.end && self.ending.is_some_and(|last| !last.is_ascii_whitespace())
    }
}

impl Read for Feed {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        // The parser asks for one byte at a time.
        if let [slot] = out
            && self.start < self.end
            && self.budget > 0
        {
            *slot = self.buffer[self.start];
            self.consume(1);
            return Ok(1);
        }
        let ready = self.fill_buf()?;
        let count = ready.len().min(out.len());
        out[..count].copy_from_slice(&ready[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Feed {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.budget == 0 {
            return Err(io::Error::new(ErrorKind::InvalidData, FeedError::TooLong));
        }
        while self.start == self.end && self.ending.is_none() {
            match self.input.read(&mut self.buffer) {
                Ok(0) => {
                    self.ending = Some(self.last);
                    // The parser ends a word at a blank only, and a file need not end with one.
                    self.buffer[0] = b'\n';
                    (self.start, self.end) = (0, 1);
                }
                Ok(count) => {
                    (self.start, self.end) = (0, count);
                    self.last = self.buffer[count - 1];
                    if memchr::memchr(0, &self.buffer[..count]).is_some() {
                        return Err(io::Error::new(ErrorKind::InvalidData, FeedError::NotText));
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        let end = self.end.min(self.start + self.budget);
        Ok(&self.buffer[self.start..end])
    }

    fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        if self.ending.is_none() {
            self.consumed += count as u64;
        }
        self.budget = self.budget.saturating_sub(count);
    }
}
