//! The twin: a rig as declared in a TOML file. The simulator runs it, a diagnosis is written back as one.
//!
//! Every key carries its unit. An unknown key, a value out of range and two keys that contradict each other are errors with file,
//! line, column and key ([`TwinError`]). `host/twins/` has a commented file for every kind of rig.

mod check;
pub(crate) mod csv_file;
mod curve;
mod defect;
mod delay;
mod drift;
mod drive;
mod edit;
mod effect;
mod elastic;
mod encoder;
mod error;
mod index_slip;
mod latency;
mod load;
mod paper;
mod play;
mod rotating;
mod speed_loop;
#[cfg(test)]
mod tests;
mod threshold;
mod tone;
mod whole;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use curve::{SpeedProfile, TorquePoint, TorqueProfile};
pub use defect::{Channel, Flank, LocalDefect};
pub use delay::{ChannelSkew, EdgeDelay, RiseFall};
pub use drift::SpeedDrift;
pub use drive::{Drive, Noise, Ripple, Shaft, Step};
pub use edit::edited;
pub use effect::{DeclaredEffect, EffectSite, Follows};
pub use elastic::{StickSlip, TorsionalResonance};
pub use encoder::{Encoder, Errors, Gap, Harmonic, Per, Position};
pub use error::{BadValue, CurveFault, ErrorListFault, Place, TwinError};
pub use index_slip::IndexSlip;
pub use latency::CaptureLatency;
pub use load::LoadStep;
pub use play::{Backlash, Hysteresis};
pub use rotating::Bearing;
pub use speed_loop::{Gains, SeenSpeed, SpeedLoop};
pub use threshold::{ThresholdDrift, ThresholdRipple};
pub use tone::TorqueTone;

use whole::whole;

/// Every key of a twin: key, unit, default and what it is.
pub const KEYS: &str = include_str!("../../twins/keys.txt");

/// A declared rig: encoder, shaft, drive, noise, timer and what to record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Twin {
    /// Seed of every random number, 0 to 2^63 - 1. The same seed gives the same bytes, so recordings of one rig want a seed each, or
    /// noise is the same in them, edge by edge; `errors.seed` gives them one disc.
    #[serde(default, deserialize_with = "whole")]
    pub seed: u64,
    /// How much to record; of a recording it is what was recorded.
    #[serde(default, skip_serializing_if = "Duration::is_unknown")]
    pub duration: Duration,
    /// What kind of encoder, and its counts.
    pub encoder: Encoder,
    /// The encoder's own errors; none where left out.
    #[serde(default)]
    pub errors: Errors,
    /// Places of the disc that are out of line; they add to [`Twin::errors`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub local_defect: Vec<LocalDefect>,
    /// Inertia and friction of everything that turns; nothing is known of it where left out.
    #[serde(default, skip_serializing_if = "Shaft::is_unknown")]
    pub shaft: Shaft,
    /// What drives the shaft.
    #[serde(default, skip_serializing_if = "Drive::is_unknown")]
    pub drive: Drive,
    /// Whether each recording has phases of its own where orders are not whole and at frequencies: it begins anywhere in the turn of a belt
    /// or a gear. The simulator goes by the phases that are written.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub free_phases: bool,
    /// Torque ripple locked to the shaft's angle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ripple: Vec<Ripple>,
    /// Torques at orders that gears give.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gear_mesh: Vec<Ripple>,
    /// Torque or run-out at orders tied to nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bearing: Vec<Bearing>,
    /// Torques at fixed frequencies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torque_tone: Vec<TorqueTone>,
    /// Torques that come and go at given times.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load_step: Vec<LoadStep>,
    /// White torque noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// A slow change of the drive's speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_drift: Option<SpeedDrift>,
    /// A spring between drive and shaft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stick_slip: Option<StickSlip>,
    /// A second mass behind a spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsional_resonance: Option<TorsionalResonance>,
    /// Delays of rising and falling edges; none where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_delay: Option<EdgeDelay>,
    /// Delays of whole channels; none where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel_skew: Option<ChannelSkew>,
    /// Tones on the comparator's level.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub threshold_ripple: Vec<ThresholdRipple>,
    /// Drifts of the comparator's level.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub threshold_drift: Vec<ThresholdDrift>,
    /// Edges that come late in either direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<Hysteresis>,
    /// A play between shaft and disc.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Backlash>,
    /// Slips of the index against the disc.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub index_slip: Vec<IndexSlip>,
    /// Captures that come late.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture_latency: Option<CaptureLatency>,
    /// Effects that no other section has a name for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effect: Vec<DeclaredEffect>,
    /// The timer that stamps the edges.
    pub timer: Timer,
    /// Faults of the capture, for tests.
    #[serde(default, skip_serializing_if = "Faults::is_none")]
    pub faults: Faults,
    /// Name for messages: the file the twin came from.
    #[serde(skip)]
    pub name: String,
    /// Folder that paths of CSV files are relative to.
    #[serde(skip)]
    pub folder: PathBuf,
}

/// How much to record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Duration {
    /// Not said: a twin of recordings needs none.
    #[default]
    #[serde(skip)]
    Unknown,
    /// Turns travelled, either way; more than 0. Should the shaft not get that far, the recording ends after ten times the time
    /// these turns take at the drive's highest speed, counted from the profile's last change.
    Turns(f64),
    /// Seconds, more than 0.
    Seconds(f64),
}

impl Duration {
    #[allow(clippy::trivially_copy_pass_by_ref)] // The signature that serde asks for.
    fn is_unknown(&self) -> bool {
        *self == Self::Unknown
    }
}

/// The timer that stamps the edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timer {
    /// Tick rate, 1 to 1e12 Hz.
    #[serde(deserialize_with = "whole")]
    pub clock_hz: u64,
    /// Width of the capture register: 16, 32 or 64 bits.
    #[serde(default = "Timer::full_width", deserialize_with = "whole")]
    pub bits: u32,
    /// RMS of a normal, independent time error of every stamp, 0 to 1 s. Stamps never go back: a later one is held at the earlier.
    #[serde(default)]
    pub jitter_s: f64,
    /// Write what the register holds (modulo 2^bits) in place of times extended to 64 bits.
    #[serde(default)]
    pub raw_captures: bool,
}

impl Timer {
    const fn full_width() -> u32 {
        64
    }
}

/// Faults of the capture, for tests.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Faults {
    /// Probability, 0 to 1, that the capture of an edge is lost: its row is missing, later rows show the true levels.
    #[serde(default)]
    pub lost_probability: f64,
    /// Edges that are lost, counted from 0 at the first edge of the recording (index rows do not count).
    #[serde(
        default,
        deserialize_with = "whole",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub lost_edges: Vec<u64>,
    /// Probability, 0 to 1, that an edge is followed by a glitch: a short pulse on one channel, at a random time within an interval
    /// as long as the one just ended.
    #[serde(default)]
    pub glitch_probability: f64,
    /// Length of a glitch, up to 1 s; needed where there are glitches.
    #[serde(default)]
    pub glitch_width_s: f64,
}

/// Whether a key may be left out of a file, as its default is 0.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Faults {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Twin {
    /// Reads and checks a twin file.
    ///
    /// # Errors
    /// [`TwinError::Read`], [`TwinError::Folder`], [`TwinError::NotText`] where there is no text to read, else as [`Twin::parse`].
    pub fn load(path: &Path) -> Result<Self, TwinError> {
        Self::load_with_text(path).map(|(_, twin)| twin)
    }

    /// As [`Self::load`], with the file's text.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_with_text(path: &Path) -> Result<(String, Self), TwinError> {
        let text = error::text_of(path)?;
        let twin = Self::parse(&text, &path.display().to_string())?;
        Ok((text, twin))
    }

    /// Parses and checks the text of a twin; `name` is its file's name, used in messages, and paths of CSV files are relative to
    /// its folder.
    ///
    /// # Errors
    /// [`TwinError::Syntax`] for what is not TOML or not a twin, [`TwinError::Value`] for a value out of range or in conflict,
    /// [`TwinError::CsvFile`] or [`TwinError::Curve`] for an unusable file of the drive.
    pub fn parse(text: &str, name: &str) -> Result<Self, TwinError> {
        let mut twin: Self = toml::from_str(text).map_err(|e| error::from_toml(&e, text, name))?;
        twin.name = name.to_owned();
        twin.folder = Path::new(name)
            .parent()
            .map(Path::to_owned)
            .unwrap_or_default();
        twin.read_curves()?;
        match twin.find_bad_value() {
            Some(bad) => Err(bad.placed_in(text)),
            None => Ok(twin),
        }
    }

    /// Checks every value and combination; [`Twin::parse`] has done so, a twin changed in code may need it.
    ///
    /// # Errors
    /// [`TwinError::Value`] with the first offending key, without line and column.
    pub fn check(&self) -> Result<(), TwinError> {
        match self.find_bad_value() {
            Some(bad) => Err(TwinError::Value(Box::new(bad))),
            None => Ok(()),
        }
    }

    /// This twin as TOML that [`Twin::parse`] reads back to an equal twin.
    ///
    /// # Errors
    /// As [`Twin::check`]; [`TwinError::Write`] where the TOML writer fails.
    pub fn to_toml(&self) -> Result<String, TwinError> {
        self.check()?;
        Ok(toml::to_string(self)?)
    }

    /// Teeth that are missing at the end of the turn, as a table and the core's decoder know it.
    ///
    /// # Errors
    /// [`TwinError::Gaps`] for a wheel with gaps elsewhere.
    pub fn missing_teeth(&self) -> Result<u32, TwinError> {
        let missing = self.encoder.missing_at_end();
        missing.ok_or_else(|| TwinError::Gaps {
            name: self.name.clone(),
        })
    }

    /// Reads the drive's CSV file, if it has one.
    fn read_curves(&mut self) -> Result<(), TwinError> {
        match &mut self.drive {
            Drive::Profile(profile) => {
                if let Some(csv) = &profile.csv {
                    let rows = curve::read(&self.folder.join(csv), "r_min")?;
                    let point = |(t_s, r_min)| Step { t_s, r_min };
                    profile.listed = rows.into_iter().map(point).collect();
                }
            }
            Drive::Torque(torque) => {
                if let Some(csv) = &torque.csv {
                    let rows = curve::read(&self.folder.join(csv), "torque_n_m")?;
                    let point = |(t_s, torque_n_m)| TorquePoint { t_s, torque_n_m };
                    torque.listed = rows.into_iter().map(point).collect();
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Paths of the CSV files that the twin names.
    pub(crate) fn csv_paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let drive = match &mut self.drive {
            Drive::Profile(profile) => profile.csv.as_mut(),
            Drive::Torque(torque) => torque.csv.as_mut(),
            _ => None,
        };
        self.errors.csv.as_mut().into_iter().chain(drive)
    }

    /// `errors.csv` as a path that can be opened: relative to the twin's own file.
    pub(crate) fn error_list_path(&self) -> Option<PathBuf> {
        self.errors.csv.as_ref().map(|csv| self.folder.join(csv))
    }
}
