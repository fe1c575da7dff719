//! A file written through a block of memory, so that small pieces don't each stop the target.

use super::semihost::{File, IoError, Mode};

/// An output file that is made at its first byte.
pub struct Output<'a> {
    path: &'a str,
    file: Option<File>,
    block: &'a mut [u8],
    used: usize,
}

impl<'a> Output<'a> {
    /// Nothing is made yet. The block must not be empty.
    pub fn new(path: &'a str, block: &'a mut [u8]) -> Self {
        Self {
            path,
            file: None,
            block,
            used: 0,
        }
    }

    /// Adds `bytes` to the file.
    pub fn write(&mut self, mut bytes: &[u8]) -> Result<(), IoError> {
        while !bytes.is_empty() {
            let room = &mut self.block[self.used..];
            let (now, later) = bytes.split_at(room.len().min(bytes.len()));
            room[..now.len()].copy_from_slice(now);
            self.used += now.len();
            bytes = later;
            if self.used == self.block.len() {
                self.flush()?;
            }
        }
        Ok(())
    }

    /// Closes the file, so that all its bytes are in the host's hands, and turns to another one.
    pub fn turn_to(&mut self, path: &'a str) -> Result<(), IoError> {
        self.flush()?;
        self.path = path;
        self.file.take().map_or(Ok(()), File::close)
    }

    /// Closes the file.
    pub fn close(mut self) -> Result<(), IoError> {
        self.turn_to("")
    }

    fn flush(&mut self) -> Result<(), IoError> {
        if self.used == 0 {
            return Ok(());
        }
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(File::open(self.path, Mode::Write)?),
        };
        file.write(&self.block[..self.used])?;
        self.used = 0;
        Ok(())
    }
}
