//! One line of the table: a figure, what it has to reach, and what it reached.

use std::fmt;

/// A figure of a real recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// What it is.
    pub figure: String,
    /// What it has to reach; none where it is told for comparison.
    pub target: Option<String>,
    /// What it reached.
    pub reached: String,
    /// Whether that is enough.
    pub met: bool,
}

impl Line {
    /// A figure that is only told.
    #[must_use]
    pub fn told(figure: &str, reached: String) -> Self {
        Self {
            figure: figure.to_owned(),
            target: None,
            reached,
            met: true,
        }
    }

    /// A figure with a target.
    #[must_use]
    pub fn judged(figure: &str, target: &str, reached: String, met: bool) -> Self {
        Self {
            figure: figure.to_owned(),
            target: Some(target.to_owned()),
            reached,
            met,
        }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let target = self.target.as_deref().unwrap_or("");
        let missed = if self.met { "" } else { "  MISSED" };
        write!(
            f,
            "{:<58} {:<24} {}{missed}",
            self.figure, target, self.reached
        )
    }
}
