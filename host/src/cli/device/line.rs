//! The options that say where the device is, and the way to it.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, value_parser};

use crate::device::{
    Address, Client, Fault, KeyError, Port, SerialLine, Timing, key_from_environment, key_from_file,
};

use super::super::failure::Failure;

/// The environment variable that names the port.
const PORT_VARIABLE: &str = "QUADCAL_PORT";

/// Where the device is.
#[derive(Clone, Debug, Args)]
pub(super) struct LineArgs {
    /// Serial port, unix:PATH or tcp:HOST:PORT; QUADCAL_PORT if not given
    #[arg(long, value_name = "PORT", global = true, help_heading = "Device")]
    port: Option<Address>,
    /// Rate of a serial port, bits a second
    #[arg(long, value_name = "RATE", default_value_t = SerialLine::default().baud, value_parser = value_parser!(u32).range(1..), global = true, help_heading = "Device")]
    baud: u32,
    /// Time to wait for a reply, seconds; what only reads is asked three times
    #[arg(long, value_name = "S", default_value = "1", value_parser = seconds, global = true, help_heading = "Device")]
    timeout: Duration,
    /// File with the device's key: 32 bytes, or 64 hexadecimal digits; QUADCAL_KEY if not given
    #[arg(long, value_name = "PATH", global = true, help_heading = "Device")]
    key_file: Option<PathBuf>,
}

/// A time from a hundredth of a second to an hour.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.01..=3600.0).contains(&value) => Ok(Duration::from_secs_f64(value)),
        _ => Err("give seconds from 0.01 to 3600".to_owned()),
    }
}

/// A device at any port.
pub(super) type AnyClient = Client<Box<dyn Port>>;

impl LineArgs {
    /// Opens the port, to read only.
    ///
    /// # Errors
    /// [`Failure::NoPort`], [`Failure::Device`].
    pub(super) fn reader(&self) -> Result<AnyClient, Failure> {
        self.open(None)
    }

    /// Opens the port, to change something too.
    ///
    /// # Errors
    /// As [`Self::reader`], and [`Failure::Key`].
    pub(super) fn commander(&self) -> Result<AnyClient, Failure> {
        let key = match &self.key_file {
            Some(path) => key_from_file(path),
            None => key_from_environment(),
        };
        self.open(Some(key))
    }

    fn open(
        &self,
        key: Option<Result<quadcal::access::Key, KeyError>>,
    ) -> Result<AnyClient, Failure> {
        let named = std::env::var(PORT_VARIABLE).ok();
        let address = match (&self.port, named) {
            (Some(address), _) => address.clone(),
            (None, Some(named)) => named.parse().map_err(|source| Failure::PortVariable {
                name: PORT_VARIABLE,
                source,
            })?,
            (None, None) => return Err(Failure::NoPort),
        };
        let key = key.transpose()?;
        let line = SerialLine { baud: self.baud };
        let name = address.to_string();
        let port = address.open(line);
        let port = port.map_err(|error| Fault::Open(error).at(&name))?;
        let timing = Timing {
            read: self.timeout,
            ..Timing::default()
        };
        Ok(Client::new(port, name, timing, key))
    }
}
