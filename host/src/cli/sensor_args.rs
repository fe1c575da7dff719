//! Options that say what sensor a recording is of.

use std::path::{Path, PathBuf};

use clap::{Args, value_parser};

use crate::calibrate::CalibrateOptions;
use crate::recording::Channels;
use crate::twin::{Encoder, Twin};

use super::failure::Failure;

/// The sensor, where the recording does not tell.
#[derive(Clone, Debug, Args)]
pub struct SensorArgs {
    /// Twin that declares the sensor: its lines, pole pairs or teeth, and those missing
    #[arg(long, value_name = "TWIN", conflicts_with_all = ["lines", "missing"], help_heading = "Sensor")]
    pub twin: Option<PathBuf>,
    /// Lines, pole pairs or teeth (missing ones counted) a turn, if not to be found in the recording
    #[arg(long, value_name = "M", value_parser = value_parser!(u32).range(1..), help_heading = "Sensor")]
    pub lines: Option<u32>,
    /// Teeth missing at the gap of a toothed wheel
    #[arg(
        long,
        value_name = "K",
        default_value_t = 0,
        hide_default_value = true,
        help_heading = "Sensor"
    )]
    pub missing: u16,
}

impl SensorArgs {
    /// The twin, if one is given.
    ///
    /// # Errors
    /// As [`Twin::load`].
    pub fn twin(&self) -> Result<Option<Twin>, Failure> {
        let twin = self.twin.as_deref().map(Twin::load).transpose();
        twin.map_err(Failure::from)
    }

    /// As the calibration takes them, checked against what `channels` the `recording` has.
    ///
    /// # Errors
    /// A twin that can't be used, or one of another kind of sensor; missing teeth of a sensor that has none.
    pub fn options(
        &self,
        recording: &Path,
        channels: Channels,
    ) -> Result<CalibrateOptions, Failure> {
        if self.missing > 0 && !matches!(channels, Channels::Wheel | Channels::Pulses) {
            return Err(Failure::Useless {
                option: "--missing",
                recording: recording.to_owned(),
                why: "is not of a toothed wheel, so no teeth can be missing",
            });
        }
        let Some(path) = &self.twin else {
            return Ok(CalibrateOptions {
                lines: self.lines,
                missing: self.missing,
                ..CalibrateOptions::default()
            });
        };
        let twin = Twin::load(path).map_err(Failure::from)?;
        let (lines, missing, without_index) = match (&twin.encoder, channels) {
            (&Encoder::Quadrature { lines, index }, Channels::Quadrature { .. }) => {
                (lines, 0, !index)
            }
            (&Encoder::Hall { pole_pairs }, Channels::Hall) => (pole_pairs, 0, false),
            (&Encoder::Wheel { teeth, .. }, Channels::Wheel | Channels::Pulses) => {
                (teeth, twin.missing_teeth()?, false)
            }
            (declared, _) => {
                return Err(Failure::OtherSensor {
                    twin: path.clone(),
                    declared: match declared {
                        Encoder::Quadrature { .. } => "a quadrature encoder",
                        Encoder::Hall { .. } => "three Hall sensors",
                        Encoder::Wheel { .. } => "a toothed wheel",
                    },
                    recorded: match channels {
                        Channels::Quadrature { .. } => "a quadrature encoder",
                        Channels::Hall => "three Hall sensors",
                        Channels::Wheel | Channels::Pulses => "one channel",
                    },
                });
            }
        };
        Ok(CalibrateOptions {
            lines: Some(lines),
            // A twin may leave out more teeth than the core can take; the plan says so.
            missing: u16::try_from(missing).unwrap_or(u16::MAX),
            without_index,
            ..CalibrateOptions::default()
        })
    }
}
