//! How a failed command ends: its line on stderr and its exit code.

use std::io;
use std::io::Write as _;
use std::process::ExitCode;

use super::Failure;
use crate::cli::output::Target;
use crate::device::Fault;

impl Failure {
    /// Prints the failure and gives the exit code. A reader of stdout that has seen enough is no failure and prints nothing.
    #[must_use]
    pub fn report(&self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        // Where stderr is closed there is nobody left to tell.
        let _ = writeln!(io::stderr(), "quadcal: {self}");
        ExitCode::from(self.exit_code())
    }

    /// 2 where the input or the command line is to blame, 3 where a device can't be reached, else 1.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Write { .. }
            | Self::Worse { .. }
            | Self::OtherDisc { .. }
            | Self::OtherPattern { .. }
            | Self::IndexMoved { .. }
            | Self::NoPlace { .. }
            | Self::WorseLoaded { .. }
            | Self::OutOfWindow { .. }
            | Self::Stopped
            | Self::Demo(_) => 1,
            Self::Device(error) | Self::Waits { source: error, .. } => device_code(&error.fault),
            Self::Read(_)
            | Self::Twin(_)
            | Self::OtherSensor { .. }
            | Self::OtherEncoder { .. }
            | Self::OtherClock { .. }
            | Self::OtherRig { .. }
            | Self::Placing { .. }
            | Self::NoRecording
            | Self::Sensor { .. }
            | Self::TwinCount { .. }
            | Self::Diagnose(_)
            | Self::Calibrate { .. }
            | Self::Loop { .. }
            | Self::NoInertia
            | Self::Useless { .. }
            | Self::Together { .. }
            | Self::Open { .. }
            | Self::NotAFile { .. }
            | Self::Table { .. }
            | Self::Verify { .. }
            | Self::Locate { .. }
            | Self::Reference(_)
            | Self::Apart { .. }
            | Self::Unwritable { .. }
            | Self::RecordingName { .. }
            | Self::NoPort
            | Self::PortVariable { .. }
            | Self::Key(_)
            | Self::Load { .. }
            | Self::NotConfirmed
            | Self::OverInput { .. }
            | Self::OverOutput { .. }
            | Self::OutputFormat { .. } => 2,
        }
    }

    fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Write { target: Target::Stdout, source } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}

/// 3 where there is no talking to the device, 2 where the key or a table is to blame, else 1.
const fn device_code(fault: &Fault) -> u8 {
    match fault {
        Fault::Open(_)
        | Fault::Lost(_)
        | Fault::Silent { .. }
        | Fault::Unanswered { .. }
        | Fault::Version { .. }
        | Fault::UnknownReply { .. } => 3,
        Fault::WrongKey | Fault::Mismatch(_) => 2,
        Fault::SessionTaken
        | Fault::Refused { .. }
        | Fault::Failed(_)
        | Fault::Gone
        | Fault::HeldBack
        | Fault::DamagedTable(_) => 1,
    }
}
