//! What carries bytes to a device and back.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serialport::SerialPort;

/// Time that writing a frame may take.
pub(super) const WRITE_WAIT: Duration = Duration::from_secs(5);

/// Shortest wait that every system takes.
const WAIT_LEAST: Duration = Duration::from_millis(1);

/// A stream of bytes whose reads end after a while.
pub trait Port: Read + Write + Send {
    /// Reads wait for the first byte this long at the most, and then fail with `TimedOut` or `WouldBlock`.
    ///
    /// # Errors
    /// The system's.
    fn set_wait(&mut self, wait: Duration) -> io::Result<()>;
}

impl Port for TcpStream {
    fn set_wait(&mut self, wait: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(wait.max(WAIT_LEAST)))
    }
}

#[cfg(unix)]
impl Port for std::os::unix::net::UnixStream {
    fn set_wait(&mut self, wait: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(wait.max(WAIT_LEAST)))
    }
}

impl Port for Box<dyn SerialPort> {
    fn set_wait(&mut self, wait: Duration) -> io::Result<()> {
        // One time for reading and writing: no frame takes as long as a reply may.
        Ok(self.set_timeout(wait.max(WAIT_LEAST))?)
    }
}

#[cfg(unix)]
impl Port for serialport::TTYPort {
    fn set_wait(&mut self, wait: Duration) -> io::Result<()> {
        Ok(self.set_timeout(wait.max(WAIT_LEAST))?)
    }
}

impl<P: Port + ?Sized> Port for Box<P> {
    fn set_wait(&mut self, wait: Duration) -> io::Result<()> {
        (**self).set_wait(wait)
    }
}
