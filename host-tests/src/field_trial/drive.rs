//! A drive: QEMU with the image that serves a port, in a folder with its flash and its edges.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use quadcal::access::Key;
use quadcal_host::device::{Address, Client, Port, SerialLine, Timing};

use super::TrialError;
use crate::firmware::{self, FirmwareError, start_qemu_at_port};

/// Name of the image.
pub const IMAGE: &str = "qemu_device";

/// Lines of its encoder.
pub const LINES: u32 = 2500;

/// Its timer's clock, hertz.
pub const CLOCK_HZ: u32 = 84_000_000;

/// Its key.
pub const KEY: Key = [0; 32];

/// Its flash's file.
pub const FLASH: &str = "flash.bin";

const SOCKET: &str = "port";

/// Longest time from the start until the port is there.
const START_MAX: Duration = Duration::from_secs(20);

/// What was asked before the image had the port on is lost, so it is soon asked again.
const TIMING: Timing = Timing {
    read: Duration::from_millis(100),
    tries: 50,
    flash: Duration::from_secs(15),
};

/// A drive that is on; off when dropped.
pub struct Drive {
    child: Child,
    address: Address,
}

/// A host at a drive's port.
pub type Host = Client<Box<dyn Port>>;

/// Builds the image.
///
/// # Errors
/// [`FirmwareError`].
pub fn build() -> Result<PathBuf, FirmwareError> {
    firmware::build(IMAGE, &[])
}

impl Drive {
    /// Switches it on: flash in file [`FLASH`] of `folder`, edges from the file of this name there, or a shaft at rest.
    ///
    /// # Errors
    /// [`TrialError::Firmware`] without QEMU.
    pub fn start(elf: &Path, folder: &Path, edges: Option<&str>) -> Result<Self, TrialError> {
        let socket = folder.join(SOCKET);
        // One that a killed QEMU left would be taken for the new one's.
        let _ = std::fs::remove_file(&socket);
        let words: Vec<&str> = [FLASH].into_iter().chain(edges).collect();
        Ok(Self {
            child: start_qemu_at_port(elf, &words, folder, SOCKET)?,
            address: Address::Unix(socket),
        })
    }

    /// Its port.
    #[must_use]
    pub const fn address(&self) -> &Address {
        &self.address
    }

    /// Whether QEMU still runs.
    pub fn is_on(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// A host at its port, which waits for it to answer.
    ///
    /// # Errors
    /// [`TrialError::Ended`] where the image ended instead, [`TrialError::Io`] without a port, [`TrialError::Device`] where it does not
    /// answer.
    pub fn connect(&mut self) -> Result<Host, TrialError> {
        let begin = Instant::now();
        let port = loop {
            match self.address.open(SerialLine::default()) {
                Ok(port) => break port,
                Err(_) if !self.is_on() => return Err(TrialError::Ended(self.complaint())),
                Err(_) if begin.elapsed() < START_MAX => {
                    thread::sleep(Duration::from_millis(2));
                }
                Err(source) => {
                    return Err(TrialError::Io {
                        what: "opening QEMU's port",
                        source,
                    });
                }
            }
        };
        let mut host = Client::new(port, "QEMU", TIMING, Some(KEY));
        host.identify()?;
        Ok(host)
    }

    /// Ends it by SIGKILL, as a power cut would. What the image had logged.
    ///
    /// # Errors
    /// [`TrialError::Io`] where the system refuses.
    pub fn cut_power(&mut self) -> Result<String, TrialError> {
        let mut log = String::new();
        let killed = self.child.kill().and_then(|()| self.child.wait());
        let read = killed.and_then(|_| match self.child.stdout.take() {
            Some(mut output) => output.read_to_string(&mut log),
            None => Ok(0),
        });
        read.map_err(|source| TrialError::Io {
            what: "killing QEMU",
            source,
        })?;
        Ok(log)
    }

    /// What a run that ended by itself had to say.
    fn complaint(&mut self) -> String {
        let mut text = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            let _ = errors.read_to_string(&mut text);
        }
        text.trim().to_owned()
    }
}

impl Drop for Drive {
    fn drop(&mut self) {
        let _ = self.cut_power();
    }
}
