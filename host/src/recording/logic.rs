//! CSV as logic analysers export it: times in seconds as decimals, one row a change.

use std::sync::Arc;

use quadcal::edge::{Levels, Sample};

use super::columns::{Columns, Fields, Role};
use super::decimal::{self, DecimalError};
use super::error::ReadError;
use super::lines::{Line, Lines};
use super::native::{parse_level, pulse};
use super::notes::Notes;
use super::options::ReadOptions;
use super::place::{Place, quote};
use super::{Header, NANOSECOND_HZ, Row};

/// Rows of a logic analyser's CSV, in nanoseconds from the first row.
pub(super) struct Logic {
    lines: Lines,
    file: Arc<str>,
    columns: Columns,
    /// Power of ten that turns the file's times into nanoseconds.
    scale: i32,
    axis: TimeAxis,
}

/// Nanoseconds counted from the first time, which may be negative.
#[derive(Default)]
pub(super) struct TimeAxis {
    /// The first time and the last.
    span: Option<(i64, i64)>,
}

impl TimeAxis {
    /// Ticks of a time; an error where it falls.
    pub fn ticks(
        &mut self,
        ns: i64,
        at: impl Fn() -> Place,
        advice: &'static str,
    ) -> Result<u64, ReadError> {
        let (first, last) = self.span.unwrap_or((ns, ns));
        if ns < last {
            return Err(ReadError::TimeFalls {
                at: at(),
                time: ns.into(),
                previous: last.into(),
                unit: "ns",
                advice,
            });
        }
        self.span = Some((first, ns));
        Ok(ns.abs_diff(first))
    }
}

impl Logic {
    /// Reads up to the column line.
    pub fn open(mut lines: Lines, options: &ReadOptions) -> Result<(Self, Header), ReadError> {
        let file = Arc::clone(lines.file());
        let mut notes = Notes::default();
        let (columns, scale) = loop {
            let Some(line) = lines.next()? else {
                return Err(ReadError::MissingColumn {
                    at: Place::line(&file, lines.number().max(1)),
                    wanted: "Time [s]".to_owned(),
                    found: "no column line".to_owned(),
                });
            };
            if line.is_blank_or_note() {
                notes.take(&line, &file)?;
                continue;
            }
            let columns = Columns::parse(&line, &file, options, "Time [s]", is_time)?;
            let scale = scale(&columns, &line, &file)?;
            break (columns, scale);
        };
        let header = Header {
            clock_hz: NANOSECOND_HZ,
            channels: columns.channels,
            notes: notes.notes,
        };
        let axis = TimeAxis::default();
        Ok((
            Self {
                lines,
                file,
                columns,
                scale,
                axis,
            },
            header,
        ))
    }

    /// Bytes read so far.
    pub fn consumed(&self) -> u64 {
        self.lines.consumed()
    }

    /// The next row, repeated levels included.
    pub fn next_row(&mut self) -> Result<Option<Row>, ReadError> {
        let Self {
            lines,
            file,
            columns,
            scale,
            axis,
        } = self;
        while let Some(line) = lines.next()? {
            if line.is_blank_or_note() {
                continue;
            }
            return parse_row(&line, columns, *scale, axis, file).map(Some);
        }
        Ok(None)
    }
}

fn parse_row(
    line: &Line<'_>,
    columns: &Columns,
    scale: i32,
    axis: &mut TimeAxis,
    file: &Arc<str>,
) -> Result<Row, ReadError> {
    columns.check(line, file)?;
    let mut row = Sample {
        ticks: 0,
        levels: Levels(pulse(columns)),
    };
    let fields = Fields::new(line.bytes, columns.delimiter);
    for ((field, role), name) in fields.zip(&columns.roles).zip(&columns.names) {
        let at = || Place::named(file, line.number, name);
        match *role {
            Role::Time => {
                let ns = parse_seconds(field, scale, line, at)?;
                row.ticks = axis.ticks(ns, at, "sort the rows or correct this one")?;
            }
            Role::Bit(bit) => row.levels.0 |= if parse_level(field, at)? { bit } else { 0 },
            Role::Skip => {}
        }
    }
    Ok(row)
}

/// A decimal time as nanoseconds.
pub(super) fn parse_seconds(
    field: &[u8],
    scale: i32,
    line: &Line<'_>,
    at: impl Fn() -> Place,
) -> Result<i64, ReadError> {
    decimal::parse(field, scale).map_err(|error| {
        let text = quote(field);
        match error {
            DecimalError::Syntax if !line.is_text() => ReadError::NotText {
                at: Place {
                    column: None,
                    ..at()
                },
            },
            DecimalError::Syntax => ReadError::BadTime {
                at: at(),
                text,
                wanted: "a decimal number with a point",
            },
            DecimalError::NotFinite => ReadError::NotFinite { at: at(), text },
            DecimalError::Overflow => ReadError::TimeOverflow { at: at(), text },
        }
    })
}

/// `Time`, alone or with a unit behind it.
pub(super) fn is_time(name: &str) -> bool {
    let bytes = name.as_bytes();
    bytes
        .get(..4)
        .is_some_and(|head| head.eq_ignore_ascii_case(b"time"))
        && !bytes.get(4).is_some_and(u8::is_ascii_alphanumeric)
}

/// Power of ten from the unit in brackets behind the time column's name; seconds where there is none.
fn scale(columns: &Columns, line: &Line<'_>, file: &Arc<str>) -> Result<i32, ReadError> {
    let time = columns.roles.iter().position(|&role| role == Role::Time);
    let name = time.map_or("", |place| columns.names[place].as_str());
    let Some((_, unit)) = name.rsplit_once(['[', '(']) else {
        return Ok(9);
    };
    match unit.trim_end_matches([']', ')']).trim() {
        "s" => Ok(9),
        "ms" => Ok(6),
        "us" | "\u{b5}s" | "\u{3bc}s" => Ok(3),
        "ns" => Ok(0),
        unit => Err(ReadError::BadHeader {
            at: Place::named(file, line.number, name),
            key: "the unit of time".to_owned(),
            value: quote(unit.as_bytes()),
            wanted: "s, ms, us or ns",
        }),
    }
}
