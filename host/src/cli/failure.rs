//! How a command ends when it cannot do what was asked: one line on stderr and an exit code.

mod exit;
mod make;

use std::io;
use std::path::{Path, PathBuf};

use quadcal::recalibrate::SpeedWindow;
use quadcal::slot::SlotError;
use thiserror::Error;

use crate::calibrate::{CalibrateError, Disagreement};
use crate::demo::DemoError;
use crate::device::{BadAddress, DeviceError, KeyError, TableMismatch};
use crate::diagnose::edges::PlaceError;
use crate::diagnose::rig::DiagnoseError;
use crate::free_run::FreeRunError;
use crate::locate::LocateError;
use crate::recording::ReadError;
use crate::recording::write::WriteError;
use crate::starting_twin::SensorUnknown;
use crate::table_file;
use crate::twin::TwinError;
use crate::verify::{ReferenceError, VerifyError};

use super::device::pace::outside;
use super::diagnose::OtherEncoder;
use super::hints::{lines_hint, option_for, reference_hint, twin_hint};
use super::output::Target;

/// Why a command did not do what was asked. Prints as one line, what is wrong and where, then what to do.
#[derive(Debug, Error)]
pub enum Failure {
    /// A recording cannot be read.
    #[error("{0}{hint}", hint = option_for(.0))]
    Read(Box<ReadError>),
    /// A recording holds what the format to be written cannot.
    #[error("{target}: {source}; write the other format")]
    Unwritable {
        /// Where it was to go.
        target: Target,
        /// What the format cannot hold.
        source: WriteError,
    },
    /// An output cannot be written.
    #[error(
        "{target}: cannot be written ({source}); check the folder, its permissions and the free space"
    )]
    Write {
        /// Where it was to go.
        target: Target,
        /// The system's reason.
        source: io::Error,
    },
    /// A twin can't be used.
    #[error("{0}{hint}", hint = twin_hint(.0))]
    Twin(#[from] TwinError),
    /// A twin declares another kind of sensor than was recorded.
    #[error(
        "{twin}: the twin declares {declared}, the recording is of {recorded}; give the twin of this rig, or --lines",
        twin = twin.display()
    )]
    OtherSensor {
        /// The twin.
        twin: PathBuf,
        /// The sensor that it declares.
        declared: &'static str,
        /// The sensor that was recorded.
        recorded: &'static str,
    },
    /// A recording is not of the encoder that its twin declares.
    #[error("{recording}: another encoder than in {twin}: {source}", recording = recording.display(), twin = twin.display())]
    OtherEncoder {
        /// The recording.
        recording: PathBuf,
        /// The twin.
        twin: PathBuf,
        /// What differs.
        source: OtherEncoder,
    },
    /// A recording of another clock than its twin's.
    #[error(
        "{recording}: its header says clock_hz = {stated}, {twin} says timer.clock_hz = {declared}; correct the one that is wrong",
        recording = recording.display(),
        twin = twin.display()
    )]
    OtherClock {
        /// The recording.
        recording: PathBuf,
        /// The twin.
        twin: PathBuf,
        /// As the recording says, Hz.
        stated: u64,
        /// As the twin says, Hz.
        declared: u64,
    },
    /// Two twins of one rig declare two encoders.
    #[error(
        "{this}: declares another encoder than {other}; recordings diagnosed together must be of one rig",
        this = this.display(),
        other = other.display()
    )]
    OtherRig {
        /// The twin.
        this: PathBuf,
        /// One given before it.
        other: PathBuf,
    },
    /// A recording's edges can't be placed on the disc.
    #[error("{recording}: {source}", recording = recording.display())]
    Placing {
        /// The recording.
        recording: PathBuf,
        /// Why.
        source: PlaceError,
    },
    /// Nothing to make a twin of.
    #[error("no recording is given")]
    NoRecording,
    /// The sensor of a recording can't be told.
    #[error("{recording}: {source}", recording = recording.display())]
    Sensor {
        /// The recording.
        recording: PathBuf,
        /// Why.
        source: SensorUnknown,
    },
    /// Neither one twin nor one for each recording.
    #[error(
        "--twin: given {twins} times for {recordings} {name}; give it once for all, or once for each in the same order",
        name = if *recordings == 1 { "recording" } else { "recordings" }
    )]
    TwinCount {
        /// Twins given.
        twins: usize,
        /// Recordings given.
        recordings: usize,
    },
    /// There is no diagnosis.
    #[error("{0}")]
    Diagnose(Box<DiagnoseError>),
    /// A recording can't be calibrated.
    #[error("{recording}: {source}{hint}", recording = recording.display(), hint = lines_hint(source, twin.as_deref()))]
    Calibrate {
        /// The recording.
        recording: PathBuf,
        /// The twin that declared the sensor.
        twin: Option<PathBuf>,
        /// Why.
        source: CalibrateError,
    },
    /// What a speed loop did can't be undone.
    #[error("{recording}: {source}", recording = recording.display())]
    Loop {
        /// The recording.
        recording: PathBuf,
        /// Why.
        source: FreeRunError,
    },
    /// A torque without an inertia.
    #[error(
        "--torque: a torque moves a shaft by its inertia; give --inertia J in kg m^2, or --twin"
    )]
    NoInertia,
    /// An option that says nothing of this recording.
    #[error("{option}: {recording} {why}; leave the option out", recording = recording.display())]
    Useless {
        /// The option.
        option: &'static str,
        /// The recording.
        recording: PathBuf,
        /// What it is that makes the option useless.
        why: &'static str,
    },
    /// Two recordings can't be learned from together.
    #[error("{this}: does not go with {other}: {source}", this = this.display(), other = other.display())]
    Together {
        /// The recording.
        this: PathBuf,
        /// One given before it.
        other: PathBuf,
        /// Why.
        source: Disagreement,
    },
    /// A file other than a recording can't be opened or read.
    #[error("{path}: cannot be read ({source}); check the path and its permissions", path = path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A recording that can be read only once.
    #[error("{path}: not a regular file; the recording is read twice, so save it to a file first", path = path.display())]
    NotAFile {
        /// The recording.
        path: PathBuf,
    },
    /// A table can't be used.
    #[error("{table}: {what}", table = table.display(), what = table_file::describe(fault))]
    Table {
        /// The table.
        table: PathBuf,
        /// Why.
        fault: SlotError,
    },
    /// A table can't be checked on a recording.
    #[error("{file}: {source}", file = blamed(source, recording, table).display())]
    Verify {
        /// The recording.
        recording: PathBuf,
        /// The table.
        table: PathBuf,
        /// Why.
        source: VerifyError,
    },
    /// A reference can't be used.
    #[error("{0}{hint}", hint = reference_hint(.0))]
    Reference(#[from] ReferenceError),
    /// A reference and a recording share no time.
    #[error(
        "{reference}: no edge of the recording lies within the reference's times; both must count seconds from the same start"
    )]
    Apart {
        /// The reference.
        reference: String,
    },
    /// The demonstration, which reads nothing but itself, failed.
    #[error("demo: {0}; this is a fault of quadcal, please report it")]
    Demo(Box<DemoError>),
    /// A table makes an encoder worse.
    #[error(
        "{table}: this table makes the encoder WORSE ({what} {before} before, {after} after); don't use it: check that it is of this \
         encoder and calibrate again",
        table = table.display()
    )]
    Worse {
        /// The table.
        table: PathBuf,
        /// What was compared.
        what: &'static str,
        /// Without the table.
        before: String,
        /// With it.
        after: String,
    },
    /// A table's line pattern is not in a recording.
    #[error(
        "{table}: this table belongs to another disc than the one recorded, or the index moved ({share:.0} % of its line pattern shows); \
         don't use it: calibrate this encoder",
        table = table.display(),
        share = 100.0 * share.max(0.0)
    )]
    OtherPattern {
        /// The table.
        table: PathBuf,
        /// How much of its pattern the recording shows.
        share: f64,
    },
    /// No place can be looked for in a table.
    #[error("{file}: {source}", file = match source { LocateError::NothingLeft | LocateError::Plan(_) => recording, _ => table }.display())]
    Locate {
        /// The recording.
        recording: PathBuf,
        /// The table.
        table: PathBuf,
        /// Why.
        source: LocateError,
    },
    /// A table is of another disc.
    #[error(
        "{table}: this table belongs to another disc than the one recorded (refused at {refused} of {starts} starts); don't use it: \
         calibrate this encoder",
        table = table.display()
    )]
    OtherDisc {
        /// The table.
        table: PathBuf,
        /// Starts that said so.
        refused: usize,
        /// All starts.
        starts: usize,
    },
    /// The index contradicts the fingerprint.
    #[error(
        "{table}: the recording's index is not where the table has it (at {moved} of {starts} starts); check the index channel and \
         calibrate again",
        table = table.display()
    )]
    IndexMoved {
        /// The table.
        table: PathBuf,
        /// Starts that the index contradicts.
        moved: usize,
        /// All starts.
        starts: usize,
    },
    /// No start found its place.
    #[error(
        "{table}: no place was found at any of {starts} starts: the pattern is too weak for the noise, or the recording too short; wait \
         for the index instead",
        table = table.display()
    )]
    NoPlace {
        /// The table.
        table: PathBuf,
        /// All starts.
        starts: usize,
    },
    /// No port is named.
    #[error("no port is named; give --port PORT, or set QUADCAL_PORT")]
    NoPort,
    /// The environment names no port.
    #[error("{name}: {source}; correct the variable, or give --port PORT")]
    PortVariable {
        /// The variable.
        name: &'static str,
        /// Why.
        source: BadAddress,
    },
    /// There is no key.
    #[error("{0}")]
    Key(#[from] KeyError),
    /// The device can't be reached, refuses, or fails.
    #[error("{0}")]
    Device(Box<DeviceError>),
    /// A table is not for the device.
    #[error("{table}: {source}", table = table.display())]
    Load {
        /// The table.
        table: PathBuf,
        /// Why.
        source: TableMismatch,
    },
    /// A table waits, as the device does not commit it now.
    #[error("{source}; the new table waits, {minutes} min: then use 'quadcal device commit'")]
    Waits {
        /// Why it is not committed.
        source: Box<DeviceError>,
        /// How long it waits.
        minutes: u32,
    },
    /// The shaft never turned as fast as was asked for, or always faster.
    #[error(
        "{port}: the speed never was in the window: {}; drive at that speed, or widen --from and --to",
        outside(*speed, *window).unwrap_or_default()
    )]
    OutOfWindow {
        /// The device's port.
        port: String,
        /// The speed, r/min.
        speed: f64,
        /// The speeds that were asked for.
        window: SpeedWindow,
    },
    /// A loaded table is worse than the device's.
    #[error(
        "{table}: on fresh turns it is WORSE than the table in use, so it is not committed; it waits: give it up with 'quadcal device \
         abort', or commit it all the same with 'quadcal device commit', or at once with --commit --force",
        table = table.display()
    )]
    WorseLoaded {
        /// The table.
        table: PathBuf,
    },
    /// Nobody can be asked whether it is meant.
    #[error("nothing was erased; add --yes if it is meant")]
    NotConfirmed,
    /// The user ended it.
    #[error("stopped; the device was told to abort, and its table in use is as before")]
    Stopped,
    /// An output would take the place of an input.
    #[error("{target}: is the input itself; give another name for the output")]
    OverInput {
        /// The output.
        target: Target,
    },
    /// Two outputs have one name.
    #[error("{target}: named for two results; give each its own file")]
    OverOutput {
        /// The output.
        target: Target,
    },
    /// The name of a simulated recording does not say its format.
    #[error("{target}: cannot tell the format from the name; end it in .csv or .vcd")]
    RecordingName {
        /// The output.
        target: Target,
    },
    /// The name of an output does not say its format.
    #[error(
        "{target}: cannot tell the format from the name; end it in .csv or .vcd, or add --to csv or --to vcd"
    )]
    OutputFormat {
        /// The output.
        target: Target,
    },
}

/// The file that a check's error is about.
fn blamed<'a>(error: &VerifyError, recording: &'a Path, table: &'a Path) -> &'a Path {
    match error {
        VerifyError::Table(_) | VerifyError::Shape { .. } | VerifyError::NotAnchored => table,
        _ => recording,
    }
}
