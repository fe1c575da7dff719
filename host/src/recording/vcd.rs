//! Value change dumps (IEEE 1364, four states): scalar signals of the header are matched by name, and all changes under one time
//! become one row.

use std::io::{self, ErrorKind};
use std::sync::Arc;

use quadcal::edge::{Levels, Sample};
use vcd::{Command, IdCode, ParseError, Parser, Value};

use super::columns::channel_signals;
use super::error::ReadError;
use super::feed::{Feed, FeedError};
use super::lines::{Input, LINE_LIMIT};
use super::options::ReadOptions;
use super::place::{Place, quote};
use super::vcd_header::{self, Wire};
use super::vcd_time::Timescale;
use super::{Channels, Header, Row};

/// Rows of a VCD.
pub(super) struct Vcd {
    source: Source,
    timescale: Timescale,
    pulses: bool,
    wires: Vec<Wire>,
    /// Time the changes now read belong to, in the file's units.
    time: u64,
    levels: u8,
    /// Bits whose wire has had a definite level.
    definite: u8,
    /// Whether a wire was given a level since the last row.
    touched: bool,
    ended: bool,
}

/// The parser with the file's name.
pub(super) struct Source {
    parser: Parser<Feed>,
    file: Arc<str>,
    /// Whether a `$dumpvars` or the like is open.
    in_dump: bool,
}

impl Source {
    pub fn new(input: Input, file: &Arc<str>) -> Self {
        Self {
            parser: Parser::new(Feed::new(input)),
            file: Arc::clone(file),
            in_dump: false,
        }
    }

    /// The line being read.
    pub fn here(&self) -> Place {
        Place::line(&self.file, self.parser.line())
    }

    /// The next command, or none where the file ends between two.
    pub fn next(&mut self) -> Result<Option<Command>, ReadError> {
        self.parser.reader().renew();
        let command = match self.parser.next() {
            None if self.in_dump => return Err(self.cut("within a $dump section")),
            None => return Ok(None),
            Some(Err(error)) => return Err(self.explain(error)),
            Some(Ok(command)) => command,
        };
        match command {
            Command::Begin(_) => self.in_dump = true,
            Command::End(_) => self.in_dump = false,
            // Digits may be missing from the last time, and nothing follows to tell.
            Command::Timestamp(_) if self.parser.reader().ended_in_a_word() => {
                return Err(self.cut("within a time"));
            }
            _ => {}
        }
        Ok(Some(command))
    }

    /// Error for a file that ends too early.
    pub fn cut(&self, within: &'static str) -> ReadError {
        ReadError::Truncated {
            at: self.here(),
            within,
        }
    }

    fn explain(&mut self, error: io::Error) -> ReadError {
        if error.kind() == ErrorKind::UnexpectedEof || self.parser.reader().ended_in_a_word() {
            return self.cut("within a command");
        }
        let at = self.here();
        let inner = error.get_ref();
        if let Some(parse) = inner.and_then(|e| e.downcast_ref::<ParseError>()) {
            return ReadError::Vcd {
                at,
                reason: quote(parse.kind().to_string().as_bytes()),
            };
        }
        match inner.and_then(|e| e.downcast_ref()) {
            Some(FeedError::TooLong) => ReadError::TooLong {
                at,
                limit: LINE_LIMIT,
            },
            Some(FeedError::NotText) => ReadError::NotText { at },
            None => ReadError::Io { at, source: error },
        }
    }
}

impl Vcd {
    /// Reads up to `$enddefinitions`.
    pub fn open(
        input: Input,
        file: &Arc<str>,
        options: &ReadOptions,
    ) -> Result<(Self, Header), ReadError> {
        let mut source = Source::new(input, file);
        let definitions = vcd_header::read(&mut source, options)?;
        let header = Header {
            clock_hz: definitions.timescale.clock_hz(),
            channels: definitions.channels,
            notes: definitions.notes,
        };
        let vcd = Self {
            source,
            timescale: definitions.timescale,
            pulses: definitions.channels == Channels::Pulses,
            wires: definitions.wires,
            time: 0,
            levels: 0,
            definite: 0,
            touched: false,
            ended: false,
        };
        Ok((vcd, header))
    }

    /// Bytes read so far.
    pub fn consumed(&mut self) -> u64 {
        self.source.parser.reader().consumed()
    }

    /// The next row, repeated levels included; the first comes when every signal has a definite level.
    pub fn next_row(&mut self) -> Result<Option<Row>, ReadError> {
        while !self.ended {
            let (row, time) = match self.source.next()? {
                Some(Command::Timestamp(time)) => (self.take_row()?, time),
                None => {
                    self.ended = true;
                    (self.take_row()?, self.time)
                }
                Some(Command::ChangeScalar(id, value)) => {
                    self.change(id, value)?;
                    continue;
                }
                Some(Command::ChangeVector(id, value)) if value.len() == 1 => {
                    if let Some(value) = value.get(0) {
                        self.change(id, value)?;
                    }
                    continue;
                }
                Some(_) => continue,
            };
            if time < self.time {
                return Err(ReadError::TimeFalls {
                    at: self.source.here(),
                    time: time.into(),
                    previous: self.time.into(),
                    unit: "units of $timescale",
                    advice: "export the recording again",
                });
            }
            self.time = time;
            if row.is_some() {
                return Ok(row);
            }
        }
        Ok(None)
    }

    fn change(&mut self, id: IdCode, value: Value) -> Result<(), ReadError> {
        for wire in self.wires.iter().filter(|wire| wire.id == id) {
            let bit = wire.bit;
            match value {
                // An event has no level: any change is the event.
                _ if self.pulses => self.levels = bit,
                Value::V1 => self.levels |= bit,
                Value::V0 => self.levels &= !bit,
                Value::X | Value::Z if self.definite & bit == 0 => continue,
                unknown => {
                    let mut at = self.source.here();
                    at.column = Some(super::place::ColumnRef::Name(wire.name.clone()));
                    let text = if unknown == Value::X { 'x' } else { 'z' };
                    return Err(ReadError::UnknownLevel { at, text });
                }
            }
            self.definite |= bit;
            self.touched = true;
        }
        Ok(())
    }

    /// The row of the changes since the last time, if there were any and all levels are known.
    fn take_row(&mut self) -> Result<Option<Row>, ReadError> {
        let all = self.wires.iter().fold(0, |bits, wire| bits | wire.bit);
        if !self.touched || self.definite != all {
            return Ok(None);
        }
        self.touched = false;
        let ticks = self
            .timescale
            .ticks(self.time)
            .ok_or_else(|| ReadError::TimeOverflow {
                at: self.source.here(),
                text: self.time.to_string(),
            })?;
        Ok(Some(Sample {
            ticks,
            levels: Levels(self.levels),
        }))
    }
}

/// Name of the event that stands for pulses in a VCD.
pub(super) const PULSE: &str = "pulse";

/// Names of the signals of `channels` as they stand in a VCD, in the order of their bits.
pub(super) fn wire_names(channels: Channels) -> Vec<&'static str> {
    match channels {
        Channels::Pulses => vec![PULSE],
        _ => channel_signals(channels)
            .iter()
            .map(|signal| signal.default_name())
            .collect(),
    }
}
