//! Lines of a file with their numbers, in bounded memory.

use std::io::{ErrorKind, Read};
use std::sync::Arc;

use memchr::memchr;

use super::error::ReadError;
use super::place::Place;

/// Longest line of a recording, in bytes; anything longer is an error.
pub const LINE_LIMIT: usize = 64 * 1024;

/// Bytes read from the system at a time; must be over [`LINE_LIMIT`].
const BUFFER: usize = 256 * 1024;

/// Where a recording's bytes come from.
pub(super) type Input = Box<dyn Read + Send>;

/// One line without its line end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    pub bytes: &'a [u8],
    /// The first line is 1.
    pub number: u64,
    /// Whether a line end follows; a last line without one may be cut off.
    pub ended: bool,
}

impl Line<'_> {
    /// Whether the line holds nothing to read: blank, or a `#` line.
    pub fn is_blank_or_note(&self) -> bool {
        matches!(self.bytes.trim_ascii_start().first(), None | Some(b'#'))
    }

    /// Whether the line is text at all.
    pub fn is_text(&self) -> bool {
        memchr(0, self.bytes).is_none() && std::str::from_utf8(self.bytes).is_ok()
    }
}

/// Reads lines through one fixed buffer.
pub(super) struct Lines {
    input: Input,
    file: Arc<str>,
    buffer: Box<[u8]>,
    start: usize,
    end: usize,
    at_end: bool,
    number: u64,
    consumed: u64,
}

impl Lines {
    pub fn new(input: Input, file: &Arc<str>) -> Self {
        Self {
            input,
            file: Arc::clone(file),
            buffer: vec![0; BUFFER].into_boxed_slice(),
            start: 0,
            end: 0,
            at_end: false,
            number: 0,
            consumed: 0,
        }
    }

    /// Name of the file.
    pub fn file(&self) -> &Arc<str> {
        &self.file
    }

    /// Number of the last line handed out; 0 before the first.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Bytes handed out so far.
    pub fn consumed(&self) -> u64 {
        self.consumed
    }

    /// The next line, or none at the end of the file.
    pub fn next(&mut self) -> Result<Option<Line<'_>>, ReadError> {
        let mut searched = 0;
        let (length, ended) = loop {
            let pending = &self.buffer[self.start..self.end];
            if let Some(found) = memchr(b'\n', &pending[searched..]) {
                break (searched + found, true);
            }
            searched = pending.len();
            if searched > LINE_LIMIT {
                break (searched, false);
            }
            if self.at_end {
                if searched == 0 {
                    return Ok(None);
                }
                break (searched, false);
            }
            self.fill()?;
        };
        self.number += 1;
        let bytes = &self.buffer[self.start..self.start + length];
        if length > LINE_LIMIT {
            return Err(too_long(bytes, &self.file, self.number));
        }
        self.start += length + usize::from(ended);
        self.consumed += (length + usize::from(ended)) as u64;
        Ok(Some(Line {
            bytes: bytes.strip_suffix(b"\r").unwrap_or(bytes),
            number: self.number,
            ended,
        }))
    }

    fn fill(&mut self) -> Result<(), ReadError> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        loop {
            match self.input.read(&mut self.buffer[self.end..]) {
                Ok(count) => {
                    self.end += count;
                    self.at_end = count == 0;
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(source) => {
                    return Err(ReadError::Io {
                        at: Place::line(&self.file, self.number + 1),
                        source,
                    });
                }
            }
        }
    }
}

/// A line that never ends is more often a binary file than a text one, which the message should say.
fn too_long(bytes: &[u8], file: &Arc<str>, line: u64) -> ReadError {
    let at = Place::line(file, line);
    if memchr(0, bytes).is_some() {
        ReadError::NotText { at }
    } else {
        ReadError::TooLong {
            at,
            limit: LINE_LIMIT,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out one byte a call, the worst a pipe can do.
    struct Drip(std::io::Cursor<Vec<u8>>);

    impl Read for Drip {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            let length = out.len().min(1);
            self.0.read(&mut out[..length])
        }
    }

    fn lines(bytes: &[u8]) -> Lines {
        Lines::new(
            Box::new(Drip(std::io::Cursor::new(bytes.to_vec()))),
            &"f".into(),
        )
    }

    #[test]
    fn both_line_ends_and_a_last_line_without_one_are_read() {
        let mut lines = lines(b"one\r\ntwo\n\nlast");
        let mut seen = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            seen.push((line.bytes.to_vec(), line.number, line.ended));
        }
        let expected: Vec<(Vec<u8>, u64, bool)> = vec![
            (b"one".to_vec(), 1, true),
            (b"two".to_vec(), 2, true),
            (b"".to_vec(), 3, true),
            (b"last".to_vec(), 4, false),
        ];
        assert_eq!(seen, expected);
        assert_eq!(lines.consumed(), 14);
    }

    #[test]
    fn a_line_of_the_limit_is_read_and_one_byte_more_is_refused() {
        let mut text = vec![b'7'; LINE_LIMIT];
        text.push(b'\n');
        text.extend(vec![b'8'; LINE_LIMIT + 1]);
        text.push(b'\n');
        let mut lines = lines(&text);
        assert_eq!(lines.next().unwrap().unwrap().bytes.len(), LINE_LIMIT);
        assert!(matches!(lines.next(), Err(ReadError::TooLong { at, .. }) if at.line == Some(2)));
    }

    #[test]
    fn an_endless_binary_line_is_called_binary() {
        let mut lines = lines(&vec![0; LINE_LIMIT * 2]);
        assert!(matches!(lines.next(), Err(ReadError::NotText { .. })));
    }
}
