//! One-column lists of seconds: the pulses of a toothed wheel or a single channel.

use std::collections::VecDeque;
use std::sync::Arc;

use quadcal::edge::{Levels, Sample};

use super::error::ReadError;
use super::lines::Lines;
use super::logic::{TimeAxis, parse_seconds};
use super::notes::Notes;
use super::options::{ListKind, ReadOptions};
use super::place::Place;
use super::{Channels, Header, NANOSECOND_HZ, Row};

/// Values that [`ListKind::Auto`] looks at.
const LOOK_AHEAD: usize = 64;

/// Power of ten that turns seconds into nanoseconds.
const SECONDS: i32 = 9;

/// Pulses of a one-column list, in nanoseconds from the first pulse.
pub(super) struct List {
    lines: Lines,
    /// Values read ahead to tell times from intervals.
    ahead: VecDeque<Value>,
    /// What stopped the look-ahead, reported once the values before it are used up.
    stopped: Option<ReadError>,
    kind: ListKind,
    axis: TimeAxis,
    /// Time of the last pulse of an interval list; none before its first pulse.
    time: Option<u64>,
    waiting: Option<u64>,
}

/// One number of the list.
#[derive(Clone, Debug)]
struct Value {
    ns: i64,
    line: u64,
    text: String,
}

impl List {
    /// Reads far enough to know what the values are.
    pub fn open(lines: Lines, options: &ReadOptions) -> Result<(Self, Header), ReadError> {
        let mut notes = Notes::default();
        let mut list = Self {
            lines,
            ahead: VecDeque::with_capacity(LOOK_AHEAD),
            stopped: None,
            kind: options.list,
            axis: TimeAxis::default(),
            time: None,
            waiting: None,
        };
        while list.ahead.len() < LOOK_AHEAD {
            match list.read_value(Some(&mut notes)) {
                Ok(Some(value)) => list.ahead.push_back(value),
                Ok(None) => break,
                Err(error) => {
                    list.stopped = Some(error);
                    break;
                }
            }
        }
        if list.kind == ListKind::Auto {
            let rising = list
                .ahead
                .iter()
                .zip(list.ahead.iter().skip(1))
                .all(|(a, b)| a.ns < b.ns);
            list.kind = if rising && list.ahead.len() > 1 {
                ListKind::Times
            } else {
                ListKind::Intervals
            };
        }
        let header = Header {
            clock_hz: NANOSECOND_HZ,
            channels: Channels::Pulses,
            notes: notes.notes,
        };
        Ok((list, header))
    }

    /// What the values were taken for; never [`ListKind::Auto`].
    pub fn kind(&self) -> ListKind {
        self.kind
    }

    /// Bytes read so far.
    pub fn consumed(&self) -> u64 {
        self.lines.consumed()
    }

    /// The next pulse.
    pub fn next_row(&mut self) -> Result<Option<Row>, ReadError> {
        let pulse = |ticks| Sample {
            ticks,
            levels: Levels(Levels::A),
        };
        if let Some(ticks) = self.waiting.take() {
            return Ok(Some(pulse(ticks)));
        }
        let Some(value) = self.next_value()? else {
            return Ok(None);
        };
        let file = self.lines.file();
        let at = || Place::numbered(file, value.line, 1);
        if self.kind == ListKind::Times {
            let advice = "correct the row, or read the list as intervals";
            return self
                .axis
                .ticks(value.ns, at, advice)
                .map(|ticks| Some(pulse(ticks)));
        }
        let interval = u64::try_from(value.ns).map_err(|_| ReadError::NegativeInterval {
            at: at(),
            text: value.text.clone(),
        })?;
        let start = self.time;
        let end =
            start
                .unwrap_or(0)
                .checked_add(interval)
                .ok_or_else(|| ReadError::TimeOverflow {
                    at: at(),
                    text: value.text.clone(),
                })?;
        self.time = Some(end);
        if start.is_some() {
            return Ok(Some(pulse(end)));
        }
        // The first interval has a pulse at either end.
        self.waiting = Some(end);
        Ok(Some(pulse(0)))
    }

    fn next_value(&mut self) -> Result<Option<Value>, ReadError> {
        if let Some(value) = self.ahead.pop_front() {
            return Ok(Some(value));
        }
        match self.stopped.take() {
            Some(error) => Err(error),
            None => self.read_value(None),
        }
    }

    /// The next number of the file. A title on the first line is passed over, and heeded.
    fn read_value(&mut self, mut notes: Option<&mut Notes>) -> Result<Option<Value>, ReadError> {
        let file = Arc::clone(self.lines.file());
        let mut first = notes.is_some() && self.ahead.is_empty();
        while let Some(line) = self.lines.next()? {
            if line.is_blank_or_note() {
                if let Some(notes) = notes.as_deref_mut() {
                    notes.take(&line, &file)?;
                }
                continue;
            }
            let field = line.bytes.trim_ascii();
            if std::mem::take(&mut first)
                && let Some(kind) = title(field)
            {
                if self.kind == ListKind::Auto {
                    self.kind = kind;
                }
                continue;
            }
            let at = || Place::numbered(&file, line.number, 1);
            let ns = parse_seconds(field, SECONDS, &line, at)?;
            return Ok(Some(Value {
                ns,
                line: line.number,
                text: super::place::quote(field),
            }));
        }
        Ok(None)
    }
}

/// What the title of a list says of its values; none where the line is no title.
pub(super) fn title(line: &[u8]) -> Option<ListKind> {
    let line = line.trim_ascii();
    let line = line.strip_prefix(b"\"").unwrap_or(line);
    let starts = |name: &[u8]| {
        line.get(..name.len())
            .is_some_and(|head| head.eq_ignore_ascii_case(name))
    };
    match line {
        _ if line.contains(&b',') => None,
        _ if starts(b"interval") => Some(ListKind::Intervals),
        _ if starts(b"time") => Some(ListKind::Times),
        _ => None,
    }
}
