//! What can be wrong with a twin, and where.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A place in a twin's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's name.
    pub name: String,
    /// Line and column from 1, where there is a text: a twin made in code has none.
    pub position: Option<(usize, usize)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        match self.position {
            Some((line, column)) => write!(f, ":{line}:{column}"),
            None => Ok(()),
        }
    }
}

/// A value that is out of range or contradicts another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadValue {
    /// Where it stands.
    pub place: Place,
    /// Its key, from the top: `drive.constant.r_min`, `ripple[2].order`.
    pub key: String,
    /// The value found.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
    /// What to do.
    pub advice: &'static str,
}

impl fmt::Display for BadValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            place,
            key,
            value,
            allowed,
            advice,
        } = self;
        write!(
            f,
            "{place}: {key} = {value}: allowed is {allowed}; {advice}"
        )
    }
}

impl BadValue {
    /// As an error, with line and column of the key in `text`.
    pub(super) fn placed_in(mut self, text: &str) -> TwinError {
        self.place.position = position_of(text, &self.key);
        TwinError::Value(Box::new(self))
    }
}

/// What is wrong with a CSV list of errors.
#[derive(Debug, thiserror::Error)]
pub enum ErrorListFault {
    /// Not a CSV file.
    #[error("{0}; the file needs the header k,e_rad and two numbers a row")]
    Csv(#[from] csv::Error),
    /// A header without the columns.
    #[error("the file needs the header k,e_rad, or is one that quadcal calibrate --csv wrote")]
    Header,
    /// A field that is no number.
    #[error("'{0}' is no number; the file needs the header k,e_rad and two numbers a row")]
    Number(String),
    /// An edge of a class that it can't have, as those before it are numbered.
    #[error(
        "edge {k} is of class '{class}', which the twin's encoder does not have there; check the kind of encoder"
    )]
    Class {
        /// The edge number.
        k: u32,
        /// Its class.
        class: String,
    },
    /// An edge number past the grid.
    #[error("k = {k}: allowed is 0 to {last}; check the line count")]
    OutOfGrid {
        /// The edge number found.
        k: u32,
        /// Last one allowed.
        last: u32,
    },
    /// The same edge twice.
    #[error("k = {0} comes a second time; keep one row for each edge")]
    Twice(u32),
    /// An edge without a row.
    #[error("k = {0} is missing; give one row for each edge")]
    Missing(u32),
    /// An error that is not a finite number.
    #[error("e_rad = {0}: allowed is a finite number of radians; correct the row")]
    NotFinite(f64),
}

/// What is wrong with a CSV file of a drive's speed or torque.
#[derive(Debug, thiserror::Error)]
pub enum CurveFault {
    /// Not a CSV file.
    #[error("{source}; the file needs the header t_s,{column} and two numbers a row")]
    Csv {
        /// The column beside the time.
        column: &'static str,
        /// The CSV reader's word on it.
        source: csv::Error,
    },
    /// A header without the columns.
    #[error("the header lacks a column; the file needs the header t_s,{0}")]
    Header(&'static str),
    /// A field that is no number.
    #[error("{column} = '{found}': not a number; correct the row")]
    Number {
        /// Its column.
        column: &'static str,
        /// What stands there.
        found: String,
    },
    /// A time before the one above, or out of range.
    #[error(
        "t_s = {found}: allowed is {last_s} to 10000000; times start at 0 or later and do not fall"
    )]
    Time {
        /// The time found, s.
        found: f64,
        /// The time above it, s.
        last_s: f64,
    },
    /// A speed or torque out of range.
    #[error("{column} = {found}: allowed is -1000000 to 1000000; correct the row")]
    Value {
        /// Its column.
        column: &'static str,
        /// The value found.
        found: f64,
    },
    /// Too many rows.
    #[error("more than 1000000 rows; leave out points on a straight line")]
    Points,
    /// No row.
    #[error("no row; give one point or more")]
    Empty,
}

/// Why a twin can't be used.
#[derive(Debug, thiserror::Error)]
pub enum TwinError {
    /// The file can't be read.
    #[error("{path}: can't read the twin: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's word on it.
        source: std::io::Error,
    },
    /// More bytes than any twin has.
    #[error("{path}: more than 128 MiB; a twin is a TOML file, lists go into a CSV file beside it", path = path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// A folder in place of a file.
    #[error("{path}: is a folder; name the twin's file in it", path = path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// Something else than text.
    #[error("{path}:{line}: not text; a twin is a TOML file in UTF-8", path = path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// Line from 1 that is none.
        line: usize,
    },
    /// A file without a key in it.
    #[error("{name}: no key is in it")]
    Empty {
        /// The twin's name.
        name: String,
    },
    /// A recording in a twin's place.
    #[error("{name}: a recording, not a twin; give the TOML file that declares the rig")]
    Recording {
        /// The file.
        name: String,
    },
    /// Not TOML, a key that does not exist or is missing, or a value of the wrong type.
    #[error("{place}: {key}: {message}", key = if key.is_empty() { "(top level)" } else { key })]
    Syntax {
        /// Where.
        place: Place,
        /// The innermost key around the place, empty at the top level.
        key: String,
        /// What the TOML reader says.
        message: String,
    },
    /// A value out of range or in conflict with another.
    #[error("{0}")]
    Value(Box<BadValue>),
    /// The file named by `errors.csv` can't be used.
    #[error("{path}:{line}: {fault}", path = path.display())]
    ErrorList {
        /// The CSV file.
        path: PathBuf,
        /// Line from 1.
        line: u64,
        /// What is wrong there.
        fault: ErrorListFault,
    },
    /// A CSV file that a twin names and that can't be read.
    #[error("{path}: {why}", path = path.display())]
    CsvFile {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what to do.
        why: String,
    },
    /// The file named by `drive.profile.csv` or `drive.torque.csv` can't be used.
    #[error("{path}:{line}: {fault}", path = path.display())]
    Curve {
        /// The CSV file.
        path: PathBuf,
        /// Line from 1.
        line: u64,
        /// What is wrong there.
        fault: CurveFault,
    },
    /// What is asked for needs a key that the twin may leave out.
    #[error("{name}: no {key}; {advice}")]
    Lacks {
        /// The twin's name.
        name: String,
        /// The key.
        key: &'static str,
        /// What needs it, and what to add.
        advice: &'static str,
    },
    /// The errors are so large that an edge would come before the one in front of it.
    #[error(
        "{name}: errors: edge {first} comes {by_rad:e} rad after edge {second}; errors of neighbours may differ by less than \
         a step of {step_rad:e} rad, so lower them or the line count"
    )]
    EdgesCross {
        /// The twin's name.
        name: String,
        /// Edge that should come first.
        first: u32,
        /// Edge that should come second.
        second: u32,
        /// How much too late it is.
        by_rad: f64,
        /// The grid's step.
        step_rad: f64,
    },
    /// Gaps that a table of errors has no place for.
    #[error(
        "{name}: encoder.wheel.gaps: a table knows one gap, at the end of the turn; count the places from that gap's end, or \
         simulate only"
    )]
    Gaps {
        /// The twin's name.
        name: String,
    },
    /// Torques that drive the shaft past any speed.
    #[error(
        "{name}: after {at_s:.3e} s the shaft turns faster than 10000000 r/min; lower the torques or the loop's gains, or give the \
         shaft friction"
    )]
    RanAway {
        /// The twin's name.
        name: String,
        /// When.
        at_s: f64,
    },
    /// The twin can't be written as TOML.
    #[error("can't write the twin: {0}")]
    Write(#[from] toml::ser::Error),
}

/// Most bytes of a twin's file: room for a list of the errors of every edge.
const BYTES_MAX: u64 = 128 << 20;

/// The text of a twin's file.
pub(super) fn text_of(path: &Path) -> Result<String, TwinError> {
    let path = path.to_owned();
    if path.is_dir() {
        return Err(TwinError::Folder { path });
    }
    let mut bytes = Vec::new();
    let read = File::open(&path).and_then(|file| file.take(BYTES_MAX + 1).read_to_end(&mut bytes));
    if let Err(source) = read {
        return Err(TwinError::Read { path, source });
    }
    if bytes.len() as u64 > BYTES_MAX {
        return Err(TwinError::TooLarge { path });
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        TwinError::NotText { path, line }
    })
}

/// A TOML reader's error with line, column and key.
pub(super) fn from_toml(error: &toml::de::Error, text: &str, name: &str) -> TwinError {
    let names_recording = [".csv", ".vcd"].iter().any(|end| name.ends_with(end));
    let name = name.to_owned();
    match DeTable::parse(text) {
        Err(_) if names_recording => return TwinError::Recording { name },
        Ok(table) if table.get_ref().is_empty() => return TwinError::Empty { name },
        _ => {}
    }
    // What is missing at the top level has no place, and the reader gives it the file's beginning.
    let missing = error.message().starts_with("missing field");
    let whole = |span: &Range<usize>| span.is_empty() || span.len() >= text.trim_end().len();
    let span = error.span().filter(|span| !(missing && whole(span)));
    TwinError::Syntax {
        place: Place {
            name,
            position: span.as_ref().map(|span| line_column(text, span.start)),
        },
        key: span.map_or_else(String::new, |span| key_around(text, &span)),
        message: error.message().replace('\n', ", "),
    }
}

/// Line and column (in characters), from 1, of a byte offset.
pub(super) fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

/// Position of the value with the dotted `key`, or of the innermost table on the way there.
fn position_of(text: &str, key: &str) -> Option<(usize, usize)> {
    let root = DeTable::parse(text).ok()?;
    let mut table = Some(root.get_ref());
    let mut found: Option<Range<usize>> = None;
    for part in key.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.trim_end_matches(']').parse().ok()),
            None => (part, None),
        };
        let Some((at, value)) = table.and_then(|t| t.iter().find(|(k, _)| k.get_ref() == name))
        else {
            break;
        };
        let value = match index {
            Some(index) => value.get_ref().get::<usize>(index).unwrap_or(value),
            None => value,
        };
        // A table written out as [a.b] has the span of its header only; its key's is the same or better.
        found = Some(if value.get_ref().is_table() {
            at.span()
        } else {
            value.span()
        });
        table = value.get_ref().as_table();
    }
    Some(found.map_or((1, 1), |span| line_column(text, span.start)))
}

/// The innermost key whose key or value lies around `span`, dotted from the top.
fn key_around(text: &str, span: &Range<usize>) -> String {
    let mut path = String::new();
    if let Ok(root) = DeTable::parse(text) {
        descend(root.get_ref(), span, &mut path);
    }
    path
}

fn descend(table: &DeTable<'_>, span: &Range<usize>, path: &mut String) -> bool {
    let around = |s: Range<usize>| s.start <= span.start && span.end <= s.end;
    for (key, value) in table {
        let length = path.len();
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(key.get_ref());
        if descend_value(value, span, path) || around(key.span()) || around(value.span()) {
            return true;
        }
        path.truncate(length);
    }
    false
}

fn descend_value(value: &Spanned<DeValue<'_>>, span: &Range<usize>, path: &mut String) -> bool {
    match value.get_ref() {
        DeValue::Table(table) => descend(table, span, path),
        DeValue::Array(items) => items.iter().enumerate().any(|(i, item)| {
            let length = path.len();
            path.push_str(&format!("[{i}]"));
            let inside = descend_value(item, span, path)
                || (item.span().start <= span.start && span.end <= item.span().end);
            if !inside {
                path.truncate(length);
            }
            inside
        }),
        _ => false,
    }
}
