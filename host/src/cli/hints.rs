//! What to do about an error of the library, which knows no command line.

use std::path::Path;

use crate::calibrate::CalibrateError;
use crate::recording::ReadError;
use crate::twin::TwinError;
use crate::verify::ReferenceError;

/// The option that carries out what the reader advises, as the reader knows no command line.
pub(super) fn option_for(error: &ReadError) -> String {
    match error {
        ReadError::MissingColumn { wanted, .. } => {
            // The mapping knows the time by one name, whatever the column's own.
            let signal = match wanted.as_str() {
                signal @ ("a" | "b" | "c" | "z") => signal,
                _ => "time",
            };
            format!(" (--map {signal}=NAME)")
        }
        ReadError::DuplicateColumn { .. } => " (--map a=NAME)".to_owned(),
        ReadError::UnknownFormat { .. } => " (--format)".to_owned(),
        ReadError::NegativeInterval { .. } => " (--list times)".to_owned(),
        ReadError::TimeFalls { advice, .. } if advice.contains("as intervals") => {
            " (--list intervals)".to_owned()
        }
        _ => String::new(),
    }
}

/// What to do about a twin, where its message does not say.
pub(super) fn twin_hint(error: &TwinError) -> &'static str {
    match error {
        TwinError::Read { .. } => {
            "; check the path (quadcal simulate --example paper > twin.toml writes one to start from)"
        }
        TwinError::Empty { .. } => {
            "; write what is known of the rig (quadcal simulate --keys lists every key, --example paper shows a complete twin)"
        }
        TwinError::Syntax { message, .. } if message.starts_with("missing field") => {
            "; add it (quadcal simulate --keys lists every key, --example paper shows a complete twin)"
        }
        TwinError::Syntax { .. } => {
            "; correct the line (quadcal simulate --keys lists every key, --example paper shows a complete twin)"
        }
        _ => "",
    }
}

/// Says who gave the wrong number of lines, where that was a twin.
pub(super) fn lines_hint(error: &CalibrateError, twin: Option<&Path>) -> String {
    let wrong = matches!(
        error,
        CalibrateError::WrongLines { .. } | CalibrateError::WrongTurn { .. }
    );
    match twin {
        Some(twin) if wrong => format!(" in place of --twin {}, or correct it", twin.display()),
        _ => String::new(),
    }
}

/// What to do about a reference, where its message does not say.
pub(super) fn reference_hint(error: &ReferenceError) -> &'static str {
    match error {
        ReferenceError::Number { .. } => "; correct or delete the row",
        ReferenceError::Short { .. } => "; record the reference over the whole run",
        _ => "",
    }
}
