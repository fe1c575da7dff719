//! The column line of a CSV: which field of a row is what.

use std::sync::Arc;

use super::Channels;
use super::error::ReadError;
use super::lines::Line;
use super::options::{ReadOptions, Signal};
use super::place::{Place, quote};

/// What one field of a row holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// The time.
    Time,
    /// The level of the channel with this bit.
    Bit(u8),
    /// Nothing that is read.
    Skip,
}

/// The fields of every row.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub roles: Vec<Role>,
    pub names: Vec<String>,
    pub channels: Channels,
    pub delimiter: u8,
}

impl Columns {
    /// Reads a column line. `is_time` knows the time column's usual name; a row of seconds or ticks alone is pulses.
    pub fn parse(
        line: &Line<'_>,
        file: &Arc<str>,
        options: &ReadOptions,
        time_name: &'static str,
        is_time: fn(&str) -> bool,
    ) -> Result<Self, ReadError> {
        if !line.is_text() {
            return Err(ReadError::NotText {
                at: Place::line(file, line.number),
            });
        }
        let delimiter = delimiter(line.bytes);
        let names = names(line.bytes, delimiter);
        let find = |signal: Signal| -> Result<Option<usize>, ReadError> {
            let wanted = options.mapped(signal).or(match signal {
                Signal::Time => None,
                channel => Some(channel.default_name()),
            });
            let mut places = names.iter().enumerate().filter(|(_, name)| match wanted {
                Some(wanted) => name.to_lowercase() == wanted.trim().to_lowercase(),
                None => is_time(name),
            });
            let first = places.next();
            match (first, places.next()) {
                (_, Some((_, name))) => Err(ReadError::DuplicateColumn {
                    at: Place::named(file, line.number, name),
                }),
                (first, None) => Ok(first.map(|(place, _)| place)),
            }
        };
        let missing = |wanted: &str| ReadError::MissingColumn {
            at: Place::line(file, line.number),
            wanted: quote(wanted.as_bytes()),
            found: found(names.iter().map(String::as_str)),
        };
        let Some(time) = find(Signal::Time)? else {
            return Err(missing(options.mapped(Signal::Time).unwrap_or(time_name)));
        };
        let mut places = [None; 4];
        for (place, signal) in places.iter_mut().zip(Signal::CHANNELS) {
            *place = find(signal)?;
        }
        let others = names
            .iter()
            .enumerate()
            .any(|(n, name)| n != time && !is_side_column(name));
        let present = places.map(|place| place.is_some());
        let channels =
            channels(present, others, options).map_err(|signal| missing(options.name(signal)))?;
        let mut roles = vec![Role::Skip; names.len()];
        for (signal, place) in Signal::CHANNELS.into_iter().zip(places) {
            if let (Some(place), Some(bit)) = (place, bit(channels, signal)) {
                roles[place] = Role::Bit(bit);
            }
        }
        roles[time] = Role::Time;
        Ok(Self {
            roles,
            names,
            channels,
            delimiter,
        })
    }

    /// Checks that a row is text of as many fields as there are columns; a last line without an end that has fewer, or an empty
    /// last one, means that the file is cut off.
    pub fn check(&self, line: &Line<'_>, file: &Arc<str>) -> Result<(), ReadError> {
        let at = || Place::line(file, line.number);
        let wanted = self.roles.len();
        let (found, last) = Fields::new(line.bytes, self.delimiter)
            .fold((0, &b""[..]), |(count, _), field| (count + 1, field));
        if !line.ended && (found < wanted || found == wanted && last.is_empty()) {
            return Err(ReadError::Truncated {
                at: at(),
                within: "within its last row",
            });
        }
        if found == wanted {
            return Ok(());
        }
        Err(if line.is_text() {
            ReadError::Fields {
                at: at(),
                found,
                wanted,
            }
        } else {
            ReadError::NotText { at: at() }
        })
    }
}

/// Which channels a recording has, from the signals that are there (order of [`Signal::CHANNELS`]), or the one it lacks.
///
/// With no channel at all it is pulses, unless there are `others` that a channel could hide behind. Where Z and C are both there,
/// Z is taken, unless only C was mapped.
pub(super) fn channels(
    present: [bool; 4],
    others: bool,
    options: &ReadOptions,
) -> Result<Channels, Signal> {
    let unmet = |(signal, present): &(Signal, bool)| options.mapped(*signal).is_some() && !present;
    if let Some((signal, _)) = Signal::CHANNELS.into_iter().zip(present).find(unmet) {
        return Err(signal);
    }
    let only_c_mapped = options.mapped(Signal::C).is_some() && options.mapped(Signal::Z).is_none();
    match present {
        [false, false, false, false] if !others => Ok(Channels::Pulses),
        [false, ..] => Err(Signal::A),
        [true, false, false, false] => Ok(Channels::Wheel),
        [true, false, ..] => Err(Signal::B),
        [true, true, false, false] => Ok(Channels::Quadrature { index: false }),
        [true, true, true, true] if only_c_mapped => Ok(Channels::Hall),
        [true, true, true, _] => Ok(Channels::Quadrature { index: true }),
        [true, true, false, true] => Ok(Channels::Hall),
    }
}

/// Level bit of `signal` in a recording of `channels`; none where it plays no part.
pub(super) fn bit(channels: Channels, signal: Signal) -> Option<u8> {
    let used = channel_signals(channels);
    used.iter()
        .position(|&s| s == signal)
        .map(|place| 1 << place)
}

/// The signals of a recording, in the order of their bits.
pub(super) fn channel_signals(channels: Channels) -> &'static [Signal] {
    match channels {
        Channels::Quadrature { index: true } => &[Signal::A, Signal::B, Signal::Z],
        Channels::Quadrature { index: false } => &[Signal::A, Signal::B],
        Channels::Hall => &[Signal::A, Signal::B, Signal::C],
        Channels::Wheel => &[Signal::A],
        Channels::Pulses => &[],
    }
}

/// Names for a message, the first few of them.
pub(super) fn found<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let mut names = names.map(|name| quote(name.as_bytes()));
    let mut text = names.by_ref().take(SHOWN).collect::<Vec<_>>().join(", ");
    if text.is_empty() {
        return "none".to_owned();
    }
    if names.next().is_some() {
        text.push_str(", ...");
    }
    text
}

/// The names of a column line, without quotes and outer blanks.
pub(super) fn names(line: &[u8], delimiter: u8) -> Vec<String> {
    Fields::new(line, delimiter)
        .map(|field| {
            String::from_utf8_lossy(field)
                .replace("\"\"", "\"")
                .trim()
                .to_owned()
        })
        .collect()
}

/// Comma, or what the line has in its place.
pub(super) fn delimiter(line: &[u8]) -> u8 {
    [b',', b';', b'\t']
        .into_iter()
        .find(|d| line.contains(d))
        .unwrap_or(b',')
}

/// Columns known to hold no channel, so that a recording with them may be one of pulses.
fn is_side_column(name: &str) -> bool {
    name.get(..6)
        .is_some_and(|head| head.eq_ignore_ascii_case("torque"))
}

/// Fields of a line, blanks and quotes around them taken off; a quoted field may hold the delimiter.
pub(super) struct Fields<'a> {
    rest: Option<&'a [u8]>,
    delimiter: u8,
}

impl<'a> Fields<'a> {
    pub fn new(line: &'a [u8], delimiter: u8) -> Self {
        Self {
            rest: Some(line),
            delimiter,
        }
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let mut quoted = false;
        let end = rest.iter().position(|&b| {
            quoted ^= b == b'"';
            b == self.delimiter && !quoted
        });
        let field = match end {
            Some(end) => {
                self.rest = Some(&rest[end + 1..]);
                &rest[..end]
            }
            None => {
                self.rest = None;
                rest
            }
        };
        let field = field.trim_ascii();
        let inner = field
            .strip_prefix(b"\"")
            .and_then(|f| f.strip_suffix(b"\""));
        Some(inner.map_or(field, <[u8]>::trim_ascii))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_fields_may_hold_the_delimiter() {
        let line = br#" "Time [s]" ,"Channel, 0",b,"say ""x""","#;
        assert_eq!(
            names(line, b','),
            ["Time [s]", "Channel, 0", "b", "say \"x\"", ""]
        );
    }

    #[test]
    fn a_lone_index_or_second_channel_names_what_is_missing() {
        let none = ReadOptions::default();
        assert_eq!(
            channels([false, true, true, false], false, &none),
            Err(Signal::A)
        );
        assert_eq!(
            channels([true, false, true, false], false, &none),
            Err(Signal::B)
        );
        assert_eq!(channels([false; 4], true, &none), Err(Signal::A));
        assert_eq!(channels([false; 4], false, &none), Ok(Channels::Pulses));
        let mapped = ReadOptions {
            map: vec!["z=Index".parse().unwrap()],
            ..ReadOptions::default()
        };
        assert_eq!(
            channels([true, true, false, false], true, &mapped),
            Err(Signal::Z)
        );
    }
}
