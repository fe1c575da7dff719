//! The encoder: edges from an event file that grows while the shaft turns.
//!
//! The file is as [`quadcal::replay`] describes, what the two interrupt handlers of a 16-bit capture timer see. Its end is not the end of
//! the edges: reading goes on where it stopped as soon as there is more, and never waits. The timer's overflows stand in it too, about
//! every millisecond, so time goes on where the shaft stands still.

use core::fmt;

use quadcal::decoder::QuadratureDecoder;
use quadcal::edge::Sample;
use quadcal::replay::{Event, HEADER_LEN, Header, RECORD_LEN, ReplayError, TimerWidth, Wiring};
use quadcal::step::Outcome;
use quadcal::timebase::Timebase16;
use quadcal::units::Ticks;

use crate::qemu::semihost::{File, IoError, Mode};

/// Bytes that are read in one call.
const BLOCK: usize = 2048;

/// Why the edges can't be read.
#[derive(Clone, Copy, Debug)]
pub enum EdgesError {
    Io(IoError),
    Format(ReplayError),
    /// Not a quadrature encoder of the lines that this image is for, at a 16-bit timer of its clock.
    Encoder(Header),
}

impl From<IoError> for EdgesError {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<ReplayError> for EdgesError {
    fn from(error: ReplayError) -> Self {
        Self::Format(error)
    }
}

impl fmt::Display for EdgesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => error.fmt(f),
            Self::Format(error) => error.fmt(f),
            Self::Encoder(header) => write!(
                f,
                "the edges are of {} lines, {:?}, {} Hz, {:?}; this image has another encoder",
                header.lines, header.wiring, header.clock_hz, header.timer
            ),
        }
    }
}

/// Capture timer and decoder, fed from the file.
pub struct Edges {
    file: File,
    head: Option<Header>,
    lines: u32,
    clock_hz: u32,
    block: [u8; BLOCK],
    /// Bytes in the block: the begin of a header or record that is not whole yet, between two calls.
    filled: usize,
    timebase: Timebase16,
    pub decoder: QuadratureDecoder,
    /// The time as far as it was read.
    pub now: Ticks,
}

impl Edges {
    /// Of an encoder of `lines` lines whose timer counts `clock_hz`; the decoder is its.
    pub fn open(
        path: &str,
        lines: u32,
        clock_hz: u32,
        decoder: QuadratureDecoder,
    ) -> Result<Self, IoError> {
        Ok(Self {
            file: File::open(path, Mode::Read)?,
            head: None,
            lines,
            clock_hz,
            block: [0; BLOCK],
            filled: 0,
            timebase: Timebase16::new(),
            decoder,
            now: 0,
        })
    }

    /// Hands over what has come in since the last time, at most a block of it; whether there may be more.
    pub fn take(&mut self, mut sink: impl FnMut(&Outcome)) -> Result<bool, EdgesError> {
        let room = self.block.get_mut(self.filled..).unwrap_or_default();
        self.filled += self.file.read_some(room)?;
        let full = self.filled == BLOCK;
        let mut rest = self.block.get(..self.filled).unwrap_or_default();
        if self.head.is_none() {
            let Some((head, behind)) = rest.split_first_chunk::<HEADER_LEN>() else {
                return Ok(false);
            };
            let head = Header::parse(head)?;
            let fits = head.wiring == Wiring::Quadrature
                && head.timer == TimerWidth::Bits16
                && (head.lines, head.clock_hz) == (self.lines, self.clock_hz);
            if !fits {
                return Err(EdgesError::Encoder(head));
            }
            (self.head, rest) = (Some(head), behind);
        }
        while let Some((record, behind)) = rest.split_first_chunk::<RECORD_LEN>() {
            rest = behind;
            match Event::parse(record, TimerWidth::Bits16)? {
                Event::Overflow => {
                    self.timebase.overflow();
                    self.now = self.timebase.now(0, false);
                }
                Event::Capture {
                    raw,
                    levels,
                    overflow_pending,
                } => {
                    let ticks = self.timebase.capture_first(raw, overflow_pending);
                    self.now = self.now.max(ticks);
                    sink(&self.decoder.push(Sample { ticks, levels }));
                }
            }
        }
        let taken = self.filled - rest.len();
        self.block.copy_within(taken..self.filled, 0);
        self.filled -= taken;
        Ok(full)
    }
}
