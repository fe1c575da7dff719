//! Self-contained HTML reports: one file with inline style and drawings, no script and no network.
//!
//! The library knows nothing of encoders; the commands hand in text, numbers and vectors.
//!
//! ```
//! use quadcal_host::report::{Colour, Level, Report, Tile, plot::{Axis, Series, Xy}};
//!
//! let mut report = Report::new("Calibration", "spindle.csv");
//! report.verdict(Level::Good, "The error is down by 98.9 %.", vec![
//!     Tile::si("Error after", 8.9e-7, "rad", "RMS, turns not used to calibrate"),
//! ]);
//! let plot = Xy::new(Axis::turn(), Axis::new("Error", "rad"))
//!     .series(Series::line("before", &[0.0, 90.0], &[1e-4, -1e-4]).colour(Colour::BEFORE));
//! report.figure(plot, "Error by shaft angle.");
//! assert!(report.render().contains("890"));
//! ```

mod bars;
mod decimate;
mod draw;
mod heat;
mod histogram;
mod number;
mod page;
mod parts;
pub mod plot;
mod polar;
mod scale;
mod source;
mod spectrum;
mod strip;
mod ticks;
mod xy;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use number::{si, si_digits, si_parts};
pub use parts::{Body, Cell, Level, Tile};
pub use plot::{Colour, Plot};
pub use source::{Footer, InputFile};

/// The outcome in one line and the figures that carry it.
#[derive(Clone, Debug)]
struct Verdict {
    level: Level,
    headline: String,
    action: String,
    tiles: Vec<Tile>,
}

/// A report under construction.
#[derive(Clone, Debug)]
pub struct Report {
    title: String,
    subtitle: String,
    verdict: Option<Verdict>,
    body: Body,
    footer: Option<Footer>,
}

impl Report {
    /// An empty report. The title says what was done, the subtitle to what.
    pub fn new(title: impl Into<String>, subtitle: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: subtitle.into(),
            verdict: None,
            body: Body::new(),
            footer: None,
        }
    }

    /// The outcome: one sentence, and the few numbers to be seen first.
    pub fn verdict(
        &mut self,
        level: Level,
        headline: impl Into<String>,
        tiles: Vec<Tile>,
    ) -> &mut Self {
        self.verdict = Some(Verdict {
            level,
            headline: headline.into(),
            action: String::new(),
            tiles,
        });
        self
    }

    /// Says under the verdict's sentence what to do now; nothing without a verdict.
    pub fn action(&mut self, text: impl Into<String>) -> &mut Self {
        if let Some(verdict) = &mut self.verdict {
            verdict.action = text.into();
        }
        self
    }

    /// Starts a section with a heading and paragraphs.
    pub fn section(&mut self, title: impl Into<String>, paragraphs: &[&str]) -> &mut Self {
        self.body.section(title, paragraphs);
        self
    }

    /// Adds a table. Columns that hold only numbers are set flush right.
    pub fn table(
        &mut self,
        caption: impl Into<String>,
        columns: &[&str],
        rows: Vec<Vec<Cell>>,
    ) -> &mut Self {
        self.body.table(caption, columns, rows);
        self
    }

    /// Adds a figure over the page's width.
    pub fn figure(&mut self, plot: impl Into<Plot>, caption: impl Into<String>) -> &mut Self {
        self.body.figure(plot, caption);
        self
    }

    /// Adds two figures beside each other (one above the other on a phone).
    pub fn figure_pair(
        &mut self,
        left: (impl Into<Plot>, &str),
        right: (impl Into<Plot>, &str),
    ) -> &mut Self {
        self.body.figure_pair(left, right);
        self
    }

    /// The part below the verdict, to be added to.
    pub fn body(&mut self) -> &mut Body {
        &mut self.body
    }

    /// Adds a collapsed part.
    pub fn details(&mut self, title: impl Into<String>, body: Body) -> &mut Self {
        self.body.details(title, body);
        self
    }

    /// Says where the report comes from.
    pub fn footer(&mut self, footer: Footer) -> &mut Self {
        self.footer = Some(footer);
        self
    }

    /// The whole page; well-formed as XML too.
    pub fn render(&self) -> String {
        page::render(self).into_string()
    }

    /// Writes the page to `path` at once: to a file beside it that then takes its name.
    ///
    /// # Errors
    /// Whatever the file system says; then `path` is as it was and nothing is left beside it.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let beside = beside(path)?;
        let written = File::create(&beside)
            .and_then(|mut file| {
                file.write_all(self.render().as_bytes())?;
                file.sync_all()
            })
            .and_then(|()| fs::rename(&beside, path));
        if written.is_err() {
            // The first error is the one to report; the file may not even exist.
            let _ = fs::remove_file(&beside);
        }
        written
    }
}

/// A hidden name in the same directory, so that renaming stays within one file system.
fn beside(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::InvalidInput,
            "the report's path names no file",
        )
    })?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(hidden))
}

#[cfg(test)]
mod tests;
