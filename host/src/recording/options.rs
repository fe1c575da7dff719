//! How a recording is to be read where its content alone does not say.

use std::str::FromStr;

use thiserror::Error;

/// A format of recordings that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// `# clock_hz = ...` header and a `ticks,...` column line.
    Native,
    /// A `Time [s],...` column line, as logic analysers export it.
    Logic,
    /// Value change dump, IEEE 1364, four states.
    Vcd,
    /// One column of seconds: times of pulses or the intervals between them.
    List,
}

/// What the numbers of a one-column list are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ListKind {
    /// Times if the first 64 values rise from each to the next, else intervals. A list that starts with a smooth run-down of that
    /// length rises too: say [`ListKind::Intervals`] for such.
    #[default]
    Auto,
    /// Intervals between pulses: n values make n + 1 pulses, the first at tick 0.
    Intervals,
    /// Times of the pulses; the first becomes tick 0.
    Times,
}

/// A column that readers look for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Signal {
    /// Time or ticks; VCDs have no such signal.
    Time,
    /// Channel A, or the only channel.
    A,
    /// Channel B.
    B,
    /// The index.
    Z,
    /// The third Hall sensor.
    C,
}

impl Signal {
    /// The channels, without the time.
    pub(super) const CHANNELS: [Self; 4] = [Self::A, Self::B, Self::Z, Self::C];

    /// Name a channel goes by when no mapping says otherwise.
    pub(super) fn default_name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::A => "a",
            Self::B => "b",
            Self::Z => "z",
            Self::C => "c",
        }
    }
}

/// A name given to a signal, written `a=Channel 0`; the name is compared without regard to case and outer blanks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mapping {
    /// The signal.
    pub signal: Signal,
    /// Its column in a CSV; in a VCD its name or its path with dots (`top.encoder.a`).
    pub name: String,
}

/// A mapping that is not `CHANNEL=NAME`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("mapping '{0}' is not CHANNEL=NAME with CHANNEL one of time, a, b, z, c")]
pub struct MappingError(String);

impl FromStr for Mapping {
    type Err = MappingError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let error = || MappingError(text.escape_debug().collect());
        let (signal, name) = text.split_once('=').ok_or_else(error)?;
        let signal = match signal.trim().to_ascii_lowercase().as_str() {
            "time" | "ticks" => Signal::Time,
            "a" => Signal::A,
            "b" => Signal::B,
            "z" => Signal::Z,
            "c" => Signal::C,
            _ => return Err(error()),
        };
        match name.trim() {
            "" => Err(error()),
            name => Ok(Self {
                signal,
                name: name.to_owned(),
            }),
        }
    }
}

/// What the caller knows of a recording beyond its content; the default takes everything from the content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Format, or none to find it from content and extension.
    pub format: Option<Format>,
    /// Names of columns or signals that are not the usual ones.
    pub map: Vec<Mapping>,
    /// What a one-column list holds.
    pub list: ListKind,
}

impl ReadOptions {
    /// The name `signal` was mapped to; the last mapping wins.
    pub(super) fn mapped(&self, signal: Signal) -> Option<&str> {
        self.map
            .iter()
            .rev()
            .find(|m| m.signal == signal)
            .map(|m| m.name.as_str())
    }

    /// The name to look for: the mapped one or the usual one.
    pub(super) fn name(&self, signal: Signal) -> &str {
        self.mapped(signal).unwrap_or(signal.default_name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mappings_are_read_as_written_on_a_command_line() {
        assert_eq!(
            "A = Channel 0 ".parse(),
            Ok(Mapping {
                signal: Signal::A,
                name: "Channel 0".into()
            })
        );
        assert_eq!("z=x=y".parse::<Mapping>().unwrap().name, "x=y");
        for text in ["a", "q=1", "a=", "=b", ""] {
            assert!(text.parse::<Mapping>().is_err(), "{text}");
        }
    }
}
