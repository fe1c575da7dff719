//! A pretend device at a socket or any other port.

use std::io;
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::device::{Address, Port};

use super::{PretendError, Running};

/// Time between two looks at the port.
const LOOK: Duration = Duration::from_millis(1);

/// Where hosts connect, one after the other.
pub enum Listener {
    /// A socket in the file system, which goes when the listener does.
    #[cfg(unix)]
    Unix(std::os::unix::net::UnixListener, std::path::PathBuf),
    /// A host and port.
    Tcp(TcpListener),
}

impl Listener {
    /// Opens it; an old socket in the file system is replaced.
    ///
    /// # Errors
    /// The system's; `InvalidInput` for a serial port, which does not listen.
    pub fn bind(address: &Address) -> io::Result<Self> {
        match address {
            #[cfg(unix)]
            Address::Unix(path) => {
                use std::os::unix::fs::FileTypeExt;
                if std::fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket())
                {
                    std::fs::remove_file(path)?;
                }
                let listener = std::os::unix::net::UnixListener::bind(path)?;
                listener.set_nonblocking(true)?;
                Ok(Self::Unix(listener, path.clone()))
            }
            Address::Tcp(place) => {
                let listener = TcpListener::bind(place)?;
                listener.set_nonblocking(true)?;
                Ok(Self::Tcp(listener))
            }
            Address::Serial(_) => Err(io::ErrorKind::InvalidInput.into()),
        }
    }

    fn accept(&self) -> io::Result<Box<dyn Port>> {
        Ok(match self {
            #[cfg(unix)]
            Self::Unix(listener, _) => {
                let (stream, _) = listener.accept()?;
                stream.set_nonblocking(false)?;
                Box::new(stream)
            }
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept()?;
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                Box::new(stream)
            }
        })
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        #[cfg(unix)]
        if let Self::Unix(_, path) = self {
            // Where it is gone already, so much the better.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Runs a device and serves whoever connects, until `stop`.
///
/// # Errors
/// [`PretendError`]; that a host goes away is none.
pub fn serve(
    device: &mut Running,
    listener: &Listener,
    stop: &AtomicBool,
) -> Result<(), PretendError> {
    while !stop.load(Ordering::Relaxed) {
        device.step()?;
        match listener.accept() {
            Ok(mut port) => serve_port(device, &mut *port, stop)?,
            Err(_) => thread::sleep(LOOK),
        }
    }
    Ok(())
}

/// Runs a device at a port until that closes, or `stop`.
///
/// # Errors
/// [`PretendError`]; that the port fails is none.
pub fn serve_port(
    device: &mut Running,
    port: &mut (impl Port + ?Sized),
    stop: &AtomicBool,
) -> Result<(), PretendError> {
    let mut bytes = [0; 512];
    while !stop.load(Ordering::Relaxed) {
        device.step()?;
        let read = port.set_wait(LOOK).and_then(|()| port.read(&mut bytes));
        match read {
            Ok(0) => break,
            Ok(count) => {
                let sent = device.receive(&bytes[..count]);
                if port.write_all(&sent).and_then(|()| port.flush()).is_err() {
                    break;
                }
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::WouldBlock
                | io::ErrorKind::Interrupted => {}
                _ => break,
            },
        }
    }
    Ok(())
}
