//! Where in a file something is, and how a piece of it is quoted.

use std::fmt;
use std::sync::Arc;

/// Longest piece of a file that is quoted in a message, in characters.
const QUOTE_LIMIT: usize = 40;

/// A column of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ColumnRef {
    /// By its name in the column line, or by the signal's name in a VCD.
    Name(String),
    /// By its place in the line, the first being 1.
    Number(usize),
}

/// Where in a file something is wrong; prints as `FILE`, `FILE:LINE` or `FILE:LINE:COLUMN`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Name of the file, as it was given.
    pub file: Arc<str>,
    /// Line, the first being 1.
    pub line: Option<u64>,
    /// Column, where one is to blame.
    pub column: Option<ColumnRef>,
}

impl Place {
    pub(super) fn file(file: &Arc<str>) -> Self {
        Self {
            file: Arc::clone(file),
            line: None,
            column: None,
        }
    }

    pub(super) fn line(file: &Arc<str>, line: u64) -> Self {
        Self {
            line: Some(line),
            ..Self::file(file)
        }
    }

    pub(super) fn named(file: &Arc<str>, line: u64, column: &str) -> Self {
        Self {
            column: Some(ColumnRef::Name(column.to_owned())),
            ..Self::line(file, line)
        }
    }

    pub(super) fn numbered(file: &Arc<str>, line: u64, column: usize) -> Self {
        Self {
            column: Some(ColumnRef::Number(column)),
            ..Self::line(file, line)
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_one_line(f, &self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        match &self.column {
            Some(ColumnRef::Name(name)) => write!(f, ":{}", quote(name.as_bytes())),
            Some(ColumnRef::Number(number)) => write!(f, ":{number}"),
            None => Ok(()),
        }
    }
}

/// Control characters in a file name must not break the message into lines.
fn write_one_line(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    text.chars().try_for_each(|c| {
        if c.is_control() {
            write!(f, "?")
        } else {
            write!(f, "{c}")
        }
    })
}

/// A piece of a file made fit for a one-line message: control characters escaped, cut at 40 characters.
pub(super) fn quote(bytes: &[u8]) -> String {
    let head = &bytes[..bytes.len().min(4 * QUOTE_LIMIT)];
    let text = String::from_utf8_lossy(head);
    let mut out: String = text
        .chars()
        .take(QUOTE_LIMIT)
        .flat_map(|c| {
            let escaped: Vec<char> = if c.is_control() {
                c.escape_default().collect()
            } else {
                vec![c]
            };
            escaped
        })
        .collect();
    if text.chars().count() > QUOTE_LIMIT || head.len() < bytes.len() {
        out.push_str("...");
    }
    out
}
