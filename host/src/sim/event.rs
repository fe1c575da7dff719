//! What the simulator gives out: rows, and apart from them the truth.

use quadcal::edge::Levels;

use crate::recording::{Channels, Header, Row};
use crate::twin::{Encoder, Twin};

/// What changed at an event, named as it looks going forward: an [`Class::ARise`] passed in reverse makes A fall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// A rises.
    ARise,
    /// B rises.
    BRise,
    /// A falls.
    AFall,
    /// B falls.
    BFall,
    /// The third Hall sensor rises.
    CRise,
    /// The third Hall sensor falls.
    CFall,
    /// The index rises.
    IndexRise,
    /// The index falls.
    IndexFall,
    /// Start or end of a glitch.
    Glitch,
}

impl Class {
    /// The channel's level bit, and whether it rises.
    pub(super) const fn bit_and_rise(self) -> (u8, bool) {
        match self {
            Self::ARise => (Levels::A, true),
            Self::AFall => (Levels::A, false),
            Self::BRise => (Levels::B, true),
            Self::BFall => (Levels::B, false),
            Self::CRise => (Levels::C, true),
            Self::CFall => (Levels::C, false),
            Self::IndexRise => (Levels::Z, true),
            Self::IndexFall => (Levels::Z, false),
            Self::Glitch => (0, false),
        }
    }
}

/// What really happened at an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Exact time of the change on the disc, s: before any delay of its capture.
    pub time_s: f64,
    /// True shaft angle, rad, through all turns; at a glitch that of the change before it.
    pub angle_rad: f64,
    /// Number k of the edge on the grid; none for index and glitch rows.
    pub edge: Option<u32>,
    /// What changed.
    pub class: Class,
}

/// One change of level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The row as captured: all that a recording may hold.
    pub row: Row,
    /// The truth, for checks only.
    pub truth: Truth,
}

/// The header of a twin's recording.
pub(super) fn header_of(twin: &Twin) -> Header {
    let (channels, count) = match twin.encoder {
        Encoder::Quadrature { lines, index } => (Channels::Quadrature { index }, ("lines", lines)),
        Encoder::Hall { pole_pairs } => (Channels::Hall, ("pole_pairs", pole_pairs)),
        Encoder::Wheel { teeth, .. } => (Channels::Wheel, ("teeth", teeth)),
    };
    let mut notes = vec![
        ("source".to_owned(), "simulated by quadcal".to_owned()),
        (count.0.to_owned(), count.1.to_string()),
    ];
    if twin.timer.raw_captures {
        notes.push(("timer_bits".to_owned(), twin.timer.bits.to_string()));
    }
    Header {
        clock_hz: twin.timer.clock_hz,
        channels,
        notes,
    }
}
