//! What can be asked of a device without a session.

use quadcal::recalibrate::Figures;
use quadcal::wire::{Identity, Learned, Live, Reply, Request, Status};

use super::client::Client;
use super::error::DeviceError;
use super::port::Port;

impl<P: Port> Client<P> {
    /// Who the device is.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn identify(&mut self) -> Result<Identity, DeviceError> {
        match self.read("identify", &Request::Identify)? {
            Reply::Identity(identity) => Ok(identity),
            _ => Err(self.unknown("identify")),
        }
    }

    /// Where things stand.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn status(&mut self) -> Result<Status, DeviceError> {
        match self.read("status", &Request::Status)? {
            Reply::Status(status) => Ok(status),
            _ => Err(self.unknown("status")),
        }
    }

    /// The shaft now.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn live(&mut self) -> Result<Live, DeviceError> {
        match self.read("watch", &Request::Live)? {
            Reply::Live(live) => Ok(live),
            _ => Err(self.unknown("watch")),
        }
    }

    /// What the last calibration found.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn result(&mut self) -> Result<Option<Learned>, DeviceError> {
        match self.read("result", &Request::Result)? {
            Reply::Result(learned) => Ok(learned),
            _ => Err(self.unknown("result")),
        }
    }

    /// The new table against the old one on fresh turns.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn preview(&mut self) -> Result<Option<Figures>, DeviceError> {
        match self.read("preview", &Request::Preview)? {
            Reply::Preview(figures) => Ok(figures),
            _ => Err(self.unknown("preview")),
        }
    }
}
