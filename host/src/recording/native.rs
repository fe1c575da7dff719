//! The native CSV: integer ticks, levels, and a header that says how long a tick is.

use std::sync::Arc;

use quadcal::edge::{Levels, Sample};

use super::columns::{Columns, Fields, Role, found};
use super::error::ReadError;
use super::lines::{Line, Lines};
use super::notes::Notes;
use super::options::ReadOptions;
use super::place::{Place, quote};
use super::{Header, Row};

/// Rows of a native CSV.
pub(super) struct Native {
    lines: Lines,
    file: Arc<str>,
    columns: Columns,
    clock: Clock,
}

/// Times so far, and how raw captures become them.
struct Clock {
    /// Bits of the timer whose raw captures the rows hold; none when they are times already.
    timer_bits: Option<u32>,
    /// Time of the row above.
    last: u64,
}

impl Native {
    /// Reads the header and the column line.
    pub fn open(mut lines: Lines, options: &ReadOptions) -> Result<(Self, Header), ReadError> {
        let file = Arc::clone(lines.file());
        let mut notes = Notes::default();
        let columns = loop {
            let Some(line) = lines.next()? else {
                return Err(ReadError::MissingColumn {
                    at: Place::line(&file, lines.number().max(1)),
                    wanted: "ticks".to_owned(),
                    found: "no column line".to_owned(),
                });
            };
            if line.is_blank_or_note() {
                notes.take(&line, &file)?;
            } else {
                break Columns::parse(&line, &file, options, "ticks", |name| {
                    name.eq_ignore_ascii_case("ticks")
                })?;
            }
        };
        let Some(clock_hz) = notes.clock_hz else {
            return Err(ReadError::NoClock {
                at: Place::line(&file, lines.number()),
                wanted: "# clock_hz = 84000000",
            });
        };
        let header = Header {
            clock_hz,
            channels: columns.channels,
            notes: notes.notes,
        };
        let clock = Clock {
            timer_bits: notes.timer_bits,
            last: 0,
        };
        Ok((
            Self {
                lines,
                file,
                columns,
                clock,
            },
            header,
        ))
    }

    /// Bytes read so far.
    pub fn consumed(&self) -> u64 {
        self.lines.consumed()
    }

    /// Place of the torque column of a name, and what parts the fields of a row.
    pub fn torque_column(&self, name: &str) -> Result<(usize, u8), ReadError> {
        let columns = &self.columns;
        let wanted = name.trim().to_lowercase();
        let mut places = columns.names.iter().enumerate();
        let place = places.find(|(_, name)| name.to_lowercase() == wanted);
        match place {
            Some((place, _)) => Ok((place, columns.delimiter)),
            None => Err(ReadError::MissingTorque {
                at: Place::line(&self.file, self.lines.number()),
                wanted: quote(name.as_bytes()),
                found: found(columns.names.iter().map(String::as_str)),
            }),
        }
    }

    /// The next row, repeated levels included.
    pub fn next_row(&mut self) -> Result<Option<Row>, ReadError> {
        let row = self.next_with(|_| Ok(()))?;
        Ok(row.map(|(row, ())| row))
    }

    /// The next row, repeated levels included, and what `more` finds in its line.
    #[inline]
    pub fn next_with<T>(
        &mut self,
        more: impl Fn(&Line<'_>) -> Result<T, ReadError>,
    ) -> Result<Option<(Row, T)>, ReadError> {
        let Self {
            lines,
            file,
            columns,
            clock,
        } = self;
        while let Some(line) = lines.next()? {
            let (raw, levels) = match parse_plain(line.bytes, columns) {
                Some(row) => row,
                None if line.is_blank_or_note() => continue,
                None => parse_any(&line, columns, file)?,
            };
            let ticks = clock.extend(raw, &line, file)?;
            let more = more(&line)?;
            let row = Sample {
                ticks,
                levels: Levels(levels),
            };
            return Ok(Some((row, more)));
        }
        Ok(None)
    }
}

impl Clock {
    /// Time of a row. A raw capture smaller than the one above counts as one wrap of the timer, so of a pause longer than the timer's
    /// period whole periods are lost: nothing in the recording shows them.
    #[inline]
    fn extend(&mut self, raw: u64, line: &Line<'_>, file: &Arc<str>) -> Result<u64, ReadError> {
        let at = || Place::named(file, line.number, "ticks");
        let time = match self.timer_bits {
            None if raw < self.last => {
                return Err(ReadError::TimeFalls {
                    at: at(),
                    time: raw.into(),
                    previous: self.last.into(),
                    unit: "ticks",
                    advice: "if these are raw captures that wrap, add '# timer_bits = 16' or 32 to the header",
                });
            }
            None => raw,
            Some(bits) => {
                let period = 1 << bits;
                if raw >= period {
                    return Err(ReadError::BadTime {
                        at: at(),
                        text: raw.to_string(),
                        wanted: "within the header's timer_bits",
                    });
                }
                let step = raw.wrapping_sub(self.last) & (period - 1);
                self.last
                    .checked_add(step)
                    .ok_or_else(|| ReadError::TimeOverflow {
                        at: at(),
                        text: raw.to_string(),
                    })?
            }
        };
        self.last = time;
        Ok(time)
    }
}

/// A row without blanks and quotes, which is what machines write; none for every other, wrong ones included.
#[inline]
fn parse_plain(line: &[u8], columns: &Columns) -> Option<(u64, u8)> {
    /// Every number of so many digits fits a `u64`.
    const SAFE_DIGITS: usize = 19;
    let mut rest = line;
    let mut ticks = 0u64;
    let mut levels = 0;
    for (number, role) in columns.roles.iter().enumerate() {
        if number > 0 {
            let (&first, after) = rest.split_first()?;
            if first != columns.delimiter {
                return None;
            }
            rest = after;
        }
        match *role {
            Role::Time => {
                let before = rest.len();
                while let Some((digit @ b'0'..=b'9', after)) = rest.split_first() {
                    ticks = ticks.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
                    rest = after;
                }
                if !(1..=SAFE_DIGITS).contains(&(before - rest.len())) {
                    return None;
                }
            }
            Role::Bit(bit) => {
                let (&level, after) = rest.split_first()?;
                match level {
                    b'0' => {}
                    b'1' => levels |= bit,
                    _ => return None,
                }
                rest = after;
            }
            Role::Skip => {
                let end = rest
                    .iter()
                    .position(|&b| b == columns.delimiter)
                    .unwrap_or(rest.len());
                if rest[..end].contains(&b'"') {
                    return None;
                }
                rest = &rest[end..];
            }
        }
    }
    rest.is_empty().then_some((ticks, levels | pulse(columns)))
}

/// Any row, or what is wrong with it.
#[cold]
fn parse_any(line: &Line<'_>, columns: &Columns, file: &Arc<str>) -> Result<(u64, u8), ReadError> {
    if !line.is_text() {
        return Err(ReadError::NotText {
            at: Place::line(file, line.number),
        });
    }
    columns.check(line, file)?;
    let mut ticks = 0;
    let mut levels = pulse(columns);
    let fields = Fields::new(line.bytes, columns.delimiter);
    for ((field, role), name) in fields.zip(&columns.roles).zip(&columns.names) {
        let at = || Place::named(file, line.number, name);
        match *role {
            Role::Time => ticks = parse_ticks(field, at)?,
            Role::Bit(bit) => levels |= if parse_level(field, at)? { bit } else { 0 },
            Role::Skip => {}
        }
    }
    Ok((ticks, levels))
}

fn parse_ticks(field: &[u8], at: impl Fn() -> Place) -> Result<u64, ReadError> {
    use super::decimal::{DecimalError, parse};
    if !field.is_empty() && field.iter().all(u8::is_ascii_digit) {
        let text = String::from_utf8_lossy(field);
        return text.parse().map_err(|_| ReadError::TimeOverflow {
            at: at(),
            text: quote(field),
        });
    }
    Err(match parse(field, 0) {
        Err(DecimalError::NotFinite) => ReadError::NotFinite {
            at: at(),
            text: quote(field),
        },
        _ => ReadError::BadTime {
            at: at(),
            text: quote(field),
            wanted: "a whole number of ticks from 0 up",
        },
    })
}

/// The level in a field.
pub(super) fn parse_level(field: &[u8], at: impl Fn() -> Place) -> Result<bool, ReadError> {
    match field {
        b"0" => Ok(false),
        b"1" => Ok(true),
        _ => Err(ReadError::BadLevel {
            at: at(),
            text: quote(field),
        }),
    }
}

/// Pulses have no level column: each row is one.
pub(super) fn pulse(columns: &Columns) -> u8 {
    u8::from(columns.channels == super::Channels::Pulses)
}
