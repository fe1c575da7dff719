//! Where a device is: a serial port, a socket in the file system, or a host and port.

use std::fmt;
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use thiserror::Error;

use super::port::{Port, WRITE_WAIT};

/// Time that a connection over TCP may take.
const CONNECT_WAIT: Duration = Duration::from_secs(5);

/// Where a device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A serial port: `/dev/ttyACM0`, `COM3`.
    Serial(PathBuf),
    /// `unix:PATH`, a socket in the file system.
    #[cfg(unix)]
    Unix(PathBuf),
    /// `tcp:HOST:PORT`.
    Tcp(String),
}

/// How a serial line is set: 8 data bits, no parity, 1 stop bit, no flow control, and this rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialLine {
    /// Bits a second.
    pub baud: u32,
}

impl Default for SerialLine {
    fn default() -> Self {
        Self { baud: 115_200 }
    }
}

/// Why a text is no address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BadAddress {
    /// Nothing is named.
    #[error("give a serial port, unix:PATH or tcp:HOST:PORT")]
    Empty,
    /// A kind of port that there is not.
    #[error("there is no such kind of port; give a serial port, unix:PATH or tcp:HOST:PORT")]
    Kind,
    /// Not a host and a port number.
    #[error("after tcp: give a host and a port number, as in tcp:localhost:4444")]
    HostAndPort,
}

impl FromStr for Address {
    type Err = BadAddress;

    fn from_str(text: &str) -> Result<Self, BadAddress> {
        if let Some(place) = text.strip_prefix("tcp:") {
            let (host, port) = place.rsplit_once(':').ok_or(BadAddress::HostAndPort)?;
            if host.is_empty() || port.parse::<u16>().is_err() {
                return Err(BadAddress::HostAndPort);
            }
            return Ok(Self::Tcp(place.to_owned()));
        }
        #[cfg(unix)]
        if let Some(path) = text.strip_prefix("unix:") {
            return match path {
                "" => Err(BadAddress::Empty),
                path => Ok(Self::Unix(path.into())),
            };
        }
        // Paths and names such as COM3 do not begin like this.
        if let Some((kind, _)) = text.split_once(':')
            && kind.len() > 1
            && kind.bytes().all(|byte| byte.is_ascii_alphabetic())
        {
            return Err(BadAddress::Kind);
        }
        match text {
            "" => Err(BadAddress::Empty),
            path => Ok(Self::Serial(path.into())),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(path) => path.display().fmt(f),
            #[cfg(unix)]
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
            Self::Tcp(place) => write!(f, "tcp:{place}"),
        }
    }
}

impl Address {
    /// Opens the port; a serial one is this process's alone while it is open.
    ///
    /// # Errors
    /// The system's.
    pub fn open(&self, line: SerialLine) -> io::Result<Box<dyn Port>> {
        match self {
            Self::Serial(path) => {
                let path = path.to_string_lossy();
                let port = serialport::new(path, line.baud).timeout(WRITE_WAIT);
                Ok(Box::new(port.open()?))
            }
            #[cfg(unix)]
            Self::Unix(path) => {
                let stream = std::os::unix::net::UnixStream::connect(path)?;
                stream.set_write_timeout(Some(WRITE_WAIT))?;
                Ok(Box::new(stream))
            }
            Self::Tcp(place) => {
                let mut failed = io::Error::from(io::ErrorKind::NotFound);
                for address in place.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&address, CONNECT_WAIT) {
                        Ok(stream) => {
                            stream.set_write_timeout(Some(WRITE_WAIT))?;
                            // Frames are short, and each waits for its reply.
                            stream.set_nodelay(true)?;
                            return Ok(Box::new(stream));
                        }
                        Err(error) => failed = error,
                    }
                }
                Err(failed)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_read_as_it_is_written() {
        let places = [
            ("/dev/ttyACM0", Address::Serial("/dev/ttyACM0".into())),
            ("COM3", Address::Serial("COM3".into())),
            (
                "/dev/serial/by-path/pci-0000:00:14.0",
                Address::Serial("/dev/serial/by-path/pci-0000:00:14.0".into()),
            ),
            ("tcp:localhost:4444", Address::Tcp("localhost:4444".into())),
            ("tcp:[::1]:80", Address::Tcp("[::1]:80".into())),
            #[cfg(unix)]
            ("unix:/tmp/a b", Address::Unix("/tmp/a b".into())),
        ];
        for (text, address) in places {
            assert_eq!(text.parse(), Ok(address.clone()));
            assert_eq!(address.to_string(), text);
        }
        for wrong in ["tcp:", "tcp:host", "tcp::1", "tcp:host:70000", "tcp:host:x"] {
            assert_eq!(
                wrong.parse::<Address>(),
                Err(BadAddress::HostAndPort),
                "{wrong}"
            );
        }
        for wrong in ["foo:bar", "TCP:host:1", "serial:/dev/ttyACM0"] {
            assert_eq!(wrong.parse::<Address>(), Err(BadAddress::Kind), "{wrong}");
        }
        assert_eq!("".parse::<Address>(), Err(BadAddress::Empty));
        #[cfg(unix)]
        assert_eq!("unix:".parse::<Address>(), Err(BadAddress::Empty));
    }
}
