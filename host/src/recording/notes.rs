//! The `# key = value` lines at the head of a CSV.

use std::sync::Arc;

use super::error::ReadError;
use super::lines::Line;
use super::place::{Place, quote};

/// What the `#` lines say.
#[derive(Default)]
pub(super) struct Notes {
    pub notes: Vec<(String, String)>,
    pub clock_hz: Option<u64>,
    pub timer_bits: Option<u32>,
    bytes: usize,
}

impl Notes {
    /// Most bytes of header lines that are kept.
    const LIMIT: usize = 1024 * 1024;

    /// Takes in a `#` line; blank lines and lines without `=` say nothing.
    pub fn take(&mut self, line: &Line<'_>, file: &Arc<str>) -> Result<(), ReadError> {
        let Ok(text) = std::str::from_utf8(line.bytes) else {
            return Err(ReadError::NotText {
                at: Place::line(file, line.number),
            });
        };
        let Some((key, value)) = text.trim().trim_start_matches('#').split_once('=') else {
            return Ok(());
        };
        let (key, value) = (key.trim(), value.trim());
        self.bytes += text.len();
        if self.bytes > Self::LIMIT {
            return Err(ReadError::TooLong {
                at: Place::line(file, line.number),
                limit: Self::LIMIT,
            });
        }
        let bad = |wanted| ReadError::BadHeader {
            at: Place::named(file, line.number, key),
            key: quote(key.as_bytes()),
            value: quote(value.as_bytes()),
            wanted,
        };
        match key {
            "clock_hz" => {
                let hz = value
                    .replace('_', "")
                    .parse()
                    .ok()
                    .filter(|&hz: &u64| hz > 0);
                let hz = hz.ok_or_else(|| bad("a whole number of hertz above 0"))?;
                if self.clock_hz.is_some_and(|earlier| earlier != hz) {
                    return Err(bad("given once"));
                }
                self.clock_hz = Some(hz);
            }
            "timer_bits" => {
                let bits = value.parse().ok().filter(|bits| matches!(bits, 16 | 32));
                self.timer_bits = Some(bits.ok_or_else(|| bad("16 or 32"))?);
            }
            _ => {}
        }
        self.notes.push((key.to_owned(), value.to_owned()));
        Ok(())
    }
}
