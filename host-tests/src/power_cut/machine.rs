//! One run of the image, from its start to the kill.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Child;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use super::PowerCutError;
use crate::firmware::start_qemu;

/// Longest that the image may take to say something.
pub const ANSWER_MAX: Duration = Duration::from_secs(60);

/// QEMU with the image in it. Killed when dropped.
pub struct Machine {
    child: Child,
    lines: Receiver<String>,
}

impl Machine {
    /// Starts the image with these words in a folder.
    pub fn start(elf: &Path, words: &[&str], folder: &Path) -> Result<Self, PowerCutError> {
        let mut child = start_qemu(elf, words, folder)?;
        let (sender, lines) = channel();
        if let Some(output) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut output = BufReader::new(output);
                let mut line = String::new();
                // A line cut off by the kill was not announced.
                while output.read_line(&mut line).is_ok() && line.ends_with('\n') {
                    if sender.send(std::mem::take(&mut line)).is_err() {
                        break;
                    }
                }
            });
        }
        Ok(Self { child, lines })
    }

    /// Waits for the image to say which table counts.
    pub fn counts(&mut self) -> Result<Option<u32>, PowerCutError> {
        match self.lines.recv_timeout(ANSWER_MAX) {
            Ok(line) if line.starts_with("counts none") => Ok(None),
            Ok(line) => match sequence(&line, "counts ") {
                Some(sequence) => Ok(Some(sequence)),
                None => Err(PowerCutError::Silent(line)),
            },
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                Err(PowerCutError::Silent(self.complaint()))
            }
        }
    }

    /// Waits for the image to end by itself.
    pub fn end(&mut self) -> Result<(), PowerCutError> {
        loop {
            match self.lines.recv_timeout(ANSWER_MAX) {
                Ok(_) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                Err(RecvTimeoutError::Timeout) => {
                    return Err(PowerCutError::Silent(self.complaint()));
                }
            }
        }
    }

    /// Ends QEMU by SIGKILL, and returns the sequence numbers of the tables that the image said it had committed.
    pub fn kill(&mut self) -> Result<Vec<u32>, PowerCutError> {
        let io = |source| PowerCutError::Io {
            what: "killing QEMU",
            source,
        };
        self.child.kill().map_err(io)?;
        self.child.wait().map_err(io)?;
        // Ends when the other end of the pipe is gone.
        let lines = self.lines.iter();
        Ok(lines
            .filter_map(|line| sequence(&line, "committed "))
            .collect())
    }

    /// What a run that ended by itself had to say.
    fn complaint(&mut self) -> String {
        let _ = self.child.kill();
        let mut text = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            let _ = std::io::Read::read_to_string(&mut errors, &mut text);
        }
        text
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The sequence number in a line that begins like this.
fn sequence(line: &str, begin: &str) -> Option<u32> {
    let words = line.strip_prefix(begin)?.split_ascii_whitespace();
    let number = words
        .filter_map(|word| word.strip_prefix("sequence="))
        .next()?;
    number.parse().ok()
}
