//! Writing recordings row by row, as native CSV and as VCD.

use std::io::{self, Write};

use thiserror::Error;
use vcd::{IdCode, TimescaleUnit, Value, VarType, Writer};

pub use super::atomic::AtomicFile;

use super::columns::channel_signals;
use super::vcd::wire_names;
use super::vcd_time::writing_exponent;
use super::{Channels, Header, Row};

/// Bytes gathered before they are handed on.
const BUFFER: usize = 64 * 1024;

/// Why a recording cannot be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The writer below failed.
    #[error("cannot write the recording: {0}")]
    Io(#[from] io::Error),
    /// A row is before the one above, which no reader would take.
    #[error("row at tick {ticks} comes before the row above, at tick {previous}")]
    TimeFalls {
        /// Time of the row.
        ticks: u64,
        /// Time of the row above.
        previous: u64,
    },
    /// The time is past what the format holds.
    #[error("tick {ticks} is past the 64-bit times of a VCD")]
    TimeOverflow {
        /// Time of the row.
        ticks: u64,
    },
    /// The clock is 0, or too fast for a VCD's finest timescale.
    #[error("a clock of {clock_hz} Hz cannot be written")]
    Clock {
        /// The header's clock.
        clock_hz: u64,
    },
}

/// Rows gathered into larger writes, and the check of their order.
struct Out<W> {
    writer: W,
    buffer: Vec<u8>,
    last: u64,
}

impl<W: Write> Out<W> {
    fn new(writer: W) -> Self {
        Self {
            writer,
            buffer: Vec::with_capacity(BUFFER + 256),
            last: 0,
        }
    }

    fn step(&mut self, row: &Row) -> Result<(), WriteError> {
        if row.ticks < self.last {
            return Err(WriteError::TimeFalls {
                ticks: row.ticks,
                previous: self.last,
            });
        }
        self.last = row.ticks;
        if self.buffer.len() >= BUFFER {
            self.writer.write_all(&self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }

    fn finish(mut self) -> Result<W, WriteError> {
        self.writer.write_all(&self.buffer)?;
        self.writer.flush()?;
        Ok(self.writer)
    }
}

/// Writes the native CSV. What is not [finished](Self::finish) may be missing at the end.
pub struct NativeWriter<W> {
    out: Out<W>,
    channels: usize,
}

impl<W: Write> NativeWriter<W> {
    /// Takes the header; its notes are written as they are but for `clock_hz`, which is the header's own, and `timer_bits`, as
    /// rows hold whole times.
    ///
    /// # Errors
    /// [`WriteError::Clock`] for a clock of 0.
    pub fn new(writer: W, header: &Header) -> Result<Self, WriteError> {
        let clock_hz = header.clock_hz;
        if clock_hz == 0 {
            return Err(WriteError::Clock { clock_hz });
        }
        let mut out = Out::new(writer);
        for (key, value) in notes(header) {
            writeln!(out.buffer, "# {key} = {value}")?;
        }
        out.buffer.extend(b"ticks");
        let signals = channel_signals(header.channels);
        for signal in signals {
            write!(out.buffer, ",{}", signal.default_name())?;
        }
        out.buffer.push(b'\n');
        Ok(Self {
            out,
            channels: signals.len(),
        })
    }

    /// Writes one row.
    ///
    /// # Errors
    /// [`WriteError::TimeFalls`], or the writer's own.
    pub fn row(&mut self, row: &Row) -> Result<(), WriteError> {
        self.out.step(row)?;
        push_decimal(&mut self.out.buffer, row.ticks);
        for bit in 0..self.channels {
            self.out
                .buffer
                .extend([b',', b'0' + (row.levels.0 >> bit & 1)]);
        }
        self.out.buffer.push(b'\n');
        Ok(())
    }

    /// Writes what is gathered and gives the writer back.
    ///
    /// # Errors
    /// The writer's own.
    pub fn finish(self) -> Result<W, WriteError> {
        self.out.finish()
    }
}

/// Writes a VCD with one timestamp a row. Clocks that are no power of ten are written in a finer timescale, and a comment names them
/// so that reading gives the same ticks back. What is not [finished](Self::finish) may be missing at the end.
pub struct VcdWriter<W> {
    out: Out<W>,
    wires: Vec<IdCode>,
    clock_hz: u64,
    units_hz: u64,
    pulses: bool,
    last: Option<u8>,
}

impl<W: Write> VcdWriter<W> {
    /// Takes the header; its notes become comments.
    ///
    /// # Errors
    /// [`WriteError::Clock`] for a clock of 0 or above 5e14 Hz (1e15 Hz is fine).
    pub fn new(writer: W, header: &Header) -> Result<Self, WriteError> {
        let clock_hz = header.clock_hz;
        let exponent = writing_exponent(clock_hz).filter(|_| clock_hz > 0);
        let exponent = exponent.ok_or(WriteError::Clock { clock_hz })?;
        let mut out = Out::new(writer);
        let mut vcd = Writer::new(&mut out.buffer);
        for (key, value) in notes(header) {
            // The text must not end the comment it stands in.
            vcd.comment(&format!("{key} = {value}").replace('$', "_"))?;
        }
        let (quantity, unit) = timescale(exponent);
        vcd.timescale(quantity, unit)?;
        vcd.add_module("encoder")?;
        let pulses = header.channels == Channels::Pulses;
        let kind = if pulses {
            VarType::Event
        } else {
            VarType::Wire
        };
        let wires = wire_names(header.channels)
            .into_iter()
            .map(|name| vcd.add_var(kind, 1, name, None))
            .collect::<io::Result<_>>()?;
        vcd.upscope()?;
        vcd.enddefinitions()?;
        Ok(Self {
            out,
            wires,
            clock_hz,
            units_hz: 10u64.pow(exponent),
            pulses,
            last: None,
        })
    }

    /// Writes one row: its time and the levels that changed.
    ///
    /// # Errors
    /// [`WriteError::TimeFalls`], [`WriteError::TimeOverflow`], or the writer's own.
    pub fn row(&mut self, row: &Row) -> Result<(), WriteError> {
        self.out.step(row)?;
        let (ticks, clock) = (row.ticks, u128::from(self.clock_hz));
        let scaled = u128::from(ticks) * u128::from(self.units_hz);
        let time = u64::try_from((scaled + clock / 2) / clock)
            .map_err(|_| WriteError::TimeOverflow { ticks })?;
        let changed = match self.last {
            Some(last) if !self.pulses => last ^ row.levels.0,
            _ => u8::MAX,
        };
        self.last = Some(row.levels.0);
        let mut vcd = Writer::new(&mut self.out.buffer);
        vcd.timestamp(time)?;
        for (bit, &wire) in self.wires.iter().enumerate() {
            if changed >> bit & 1 == 1 {
                let level = self.pulses || row.levels.0 >> bit & 1 == 1;
                vcd.change_scalar(wire, Value::from(level))?;
            }
        }
        Ok(())
    }

    /// Writes what is gathered and gives the writer back.
    ///
    /// # Errors
    /// The writer's own.
    pub fn finish(self) -> Result<W, WriteError> {
        self.out.finish()
    }
}

/// The notes to write: each on one line, the clock among them.
fn notes(header: &Header) -> Vec<(String, String)> {
    let one_line = |text: &str| text.replace(char::is_control, " ");
    let clock = ("clock_hz".to_owned(), header.clock_hz.to_string());
    let mut notes: Vec<_> = header
        .notes
        .iter()
        .filter(|(key, _)| key != "timer_bits")
        .map(|(key, value)| match key.as_str() {
            "clock_hz" => clock.clone(),
            _ => (one_line(key), one_line(value)),
        })
        .collect();
    if !notes.contains(&clock) {
        notes.insert(0, clock);
    }
    notes
}

/// Units of 10^-`exponent` s as VCD writes them.
fn timescale(exponent: u32) -> (u32, TimescaleUnit) {
    use TimescaleUnit::{FS, MS, NS, PS, S, US};
    let unit = [S, MS, US, NS, PS, FS][exponent.div_ceil(3).min(5) as usize];
    (10u32.pow((3 - exponent % 3) % 3), unit)
}

fn push_decimal(buffer: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    buffer.extend(&digits[start..]);
}
