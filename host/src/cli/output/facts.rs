//! Results as text for people.

use std::fmt;

use crate::report;

/// Named results, one a line, the values in one column.
#[derive(Clone, Debug, Default)]
pub struct Facts(Vec<(String, String)>);

impl Facts {
    /// Adds a line.
    pub fn push(&mut self, name: impl Into<String>, value: impl fmt::Display) -> &mut Self {
        // Text copied from a terminal should hold plain spaces, and a value must stay on its line.
        let value = value.to_string().replace(['\u{a0}', '\u{202f}'], " ");
        self.0
            .push((name.into(), value.replace(char::is_control, "?")));
        self
    }

    /// Adds the lines of `other`.
    pub fn append(&mut self, mut other: Self) -> &mut Self {
        self.0.append(&mut other.0);
        self
    }

    /// Adds a line with a value in SI units, three digits.
    pub fn push_si(&mut self, name: impl Into<String>, value: f64, unit: &str) -> &mut Self {
        self.push(name, report::si(value, unit))
    }
}

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.0.iter().map(|(name, _)| name.chars().count());
        let width = names.max().unwrap_or(0);
        self.0
            .iter()
            .try_for_each(|(name, value)| writeln!(f, "{name:width$}  {value}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_in_one_column_and_on_one_line() {
        let mut facts = Facts::default();
        facts.push("µ", "a\nb").push_si("Clock", 8.4e7, "Hz");
        assert_eq!(facts.to_string(), "µ      a?b\nClock  84.0 MHz\n");
    }
}
