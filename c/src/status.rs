//! What a call came to.

use core::ffi::{CStr, c_char};

use quadcal::encoder::EncoderError;
use quadcal::slot::SlotError;

/// What a call came to. Negative values are errors: nothing was done.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum quadcal_status {
    /// Done; of a capture: it was an edge.
    QUADCAL_OK = 0,
    /// The capture was no edge: the first one, a change of Z alone, a glitch, which takes the edge before back, or no change.
    QUADCAL_NO_EDGE = 1,
    /// There is more to do: call again.
    QUADCAL_MORE = 2,
    /// A pointer is null or not aligned.
    QUADCAL_ERROR_POINTER = -1,
    /// The structure was not initialised.
    QUADCAL_ERROR_NOT_INITIALISED = -2,
    /// No lines, or more than 16,384.
    QUADCAL_ERROR_LINES = -3,
    /// The glitch gate is not from 2 to 31.
    QUADCAL_ERROR_GATE = -4,
    /// The timer has neither 16 nor 32 bits.
    QUADCAL_ERROR_TIMER = -5,
    /// There is no edge yet that an angle could go on from.
    QUADCAL_ERROR_NO_ANGLE = -6,
    /// The bytes are no table: another magic, version or length, or a field out of range.
    QUADCAL_ERROR_TABLE = -7,
    /// The bytes' check sum is not the table's.
    QUADCAL_ERROR_TABLE_CRC = -8,
    /// The table is of an encoder with other lines.
    QUADCAL_ERROR_TABLE_SHAPE = -9,
    /// The table's delays can't be told in ticks of this clock.
    QUADCAL_ERROR_TABLE_CLOCK = -10,
    /// The memory is too small.
    QUADCAL_ERROR_MEMORY = -11,
    /// Fewer than two turns were taken: nothing says how well turns agree.
    QUADCAL_ERROR_TOO_FEW_TURNS = -12,
    /// Not at this stage: samples after the first slice, or a table before the last one.
    QUADCAL_ERROR_STAGE = -13,
}

use quadcal_status::*;

impl From<EncoderError> for quadcal_status {
    fn from(error: EncoderError) -> Self {
        match error {
            EncoderError::Sensor(quadcal::step::SensorError::Gate) => QUADCAL_ERROR_GATE,
            EncoderError::Sensor(_) | EncoderError::Shape(_) => QUADCAL_ERROR_LINES,
            EncoderError::Table(_) => QUADCAL_ERROR_TABLE_SHAPE,
        }
    }
}

impl From<SlotError> for quadcal_status {
    fn from(error: SlotError) -> Self {
        match error {
            SlotError::Crc { .. } => QUADCAL_ERROR_TABLE_CRC,
            _ => QUADCAL_ERROR_TABLE,
        }
    }
}

/// The name of a status, as in this header; "QUADCAL_UNKNOWN" for any other number. The text is constant.
#[unsafe(no_mangle)]
pub extern "C" fn quadcal_error_name(status: i32) -> *const c_char {
    name(status).as_ptr()
}

fn name(status: i32) -> &'static CStr {
    macro_rules! names {
        ($($status:ident),*) => {
            match status {
                $(status if status == $status as i32 => const {
                    // The name and its end.
                    match CStr::from_bytes_with_nul(concat!(stringify!($status), "\0").as_bytes()) {
                        Ok(name) => name,
                        Err(_) => c"",
                    }
                },)*
                _ => c"QUADCAL_UNKNOWN",
            }
        };
    }
    names!(
        QUADCAL_OK,
        QUADCAL_NO_EDGE,
        QUADCAL_MORE,
        QUADCAL_ERROR_POINTER,
        QUADCAL_ERROR_NOT_INITIALISED,
        QUADCAL_ERROR_LINES,
        QUADCAL_ERROR_GATE,
        QUADCAL_ERROR_TIMER,
        QUADCAL_ERROR_NO_ANGLE,
        QUADCAL_ERROR_TABLE,
        QUADCAL_ERROR_TABLE_CRC,
        QUADCAL_ERROR_TABLE_SHAPE,
        QUADCAL_ERROR_TABLE_CLOCK,
        QUADCAL_ERROR_MEMORY,
        QUADCAL_ERROR_TOO_FEW_TURNS,
        QUADCAL_ERROR_STAGE
    )
}
