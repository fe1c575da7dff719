//! Progress on stderr for work that takes more than a second.

use std::cell::{Cell, RefCell};
use std::io::{self, IsTerminal};
use std::rc::Rc;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::recording::{ReadError, Recording, Row};

use super::Globals;

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// Steps between looks at the clock, which would cost more than a row.
const STRIDE: u64 = 4096;

/// Parts that a share is counted in.
const SHARES: u64 = 1000;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Bytes,
    Steps(&'static str),
    Share,
}

/// A bar that appears on a terminal once the work has taken a second, and goes away when dropped.
#[derive(Debug)]
pub struct Progress {
    what: String,
    unit: Unit,
    total: Option<u64>,
    patience: Option<Duration>,
    begun: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Progress through `total` things, or without an end if none; `what` is done to them, `unit` names them in the plural.
    pub fn count(
        what: impl Into<String>,
        unit: &'static str,
        total: Option<u64>,
        globals: Globals,
    ) -> Self {
        Self::new(what.into(), Unit::Steps(unit), total, globals)
    }

    /// Progress through work of which only the share done is known.
    pub fn share(what: impl Into<String>, globals: Globals) -> Self {
        Self::new(what.into(), Unit::Share, Some(SHARES), globals)
    }

    /// Says that a share from 0 to 1 is behind us, and what is going on.
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss
    )]
    pub fn at(&mut self, share: f64, what: &str) {
        let done = (share.clamp(0.0, 1.0) * SHARES as f64).round() as u64;
        self.reach(done, |_| what.to_owned());
    }

    fn new(what: String, unit: Unit, total: Option<u64>, globals: Globals) -> Self {
        let seen = !globals.quiet && io::stderr().is_terminal();
        Self {
            what,
            unit,
            total,
            patience: seen.then_some(PATIENCE),
            begun: Instant::now(),
            bar: None,
        }
    }

    /// Says that `done` things are behind us, with a remark beside the bar. Cheap enough for every thousandth step, not for each.
    pub fn reach(&mut self, done: u64, remark: impl FnOnce(Duration) -> String) {
        let elapsed = self.begun.elapsed();
        if self.patience.is_none_or(|patience| elapsed < patience) {
            return;
        }
        let bar = self
            .bar
            .get_or_insert_with(|| bar(&self.what, self.unit, self.total, elapsed));
        let left = self.total.and_then(|total| remaining(elapsed, done, total));
        let left = left.map_or_else(String::new, |left| {
            format!("  {} left", HumanDuration(left))
        });
        bar.set_position(done);
        bar.set_message(remark(elapsed) + &left);
    }

    /// Says that `done` of `total` things are behind us.
    pub fn of(&mut self, done: u64, total: u64) {
        self.total = Some(total);
        self.reach(done, |_| String::new());
    }

    /// Passes the items of `items` on and counts them.
    pub fn watch<I: Iterator>(mut self, items: I) -> impl Iterator<Item = I::Item> {
        (0_u64..).zip(items).map(move |(done, item)| {
            if done.is_multiple_of(STRIDE) {
                self.reach(done, |_| String::new());
            }
            item
        })
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Time that is left at the mean rate so far; the bar itself would measure its rate only from the moment it appears.
fn remaining(elapsed: Duration, done: u64, total: u64) -> Option<Duration> {
    #[allow(clippy::cast_precision_loss)]
    let share = total.saturating_sub(done) as f64 / done as f64;
    Duration::try_from_secs_f64(elapsed.as_secs_f64() * share).ok()
}

fn bar(what: &str, unit: Unit, total: Option<u64>, elapsed: Duration) -> ProgressBar {
    let counts = match (unit, total) {
        (Unit::Bytes, Some(_)) => "{bytes} of {total_bytes}".to_owned(),
        (Unit::Bytes, None) => "{bytes}".to_owned(),
        (Unit::Share, _) => String::new(),
        (Unit::Steps(unit), Some(_)) => format!("{{human_pos}} of {{human_len}} {unit}"),
        (Unit::Steps(unit), None) => format!("{{human_pos}} {unit}"),
    };
    let template = match total {
        Some(_) => format!("{{prefix}} [{{bar:30}}] {{percent}}%  {counts}  {{msg}}"),
        None => format!("{{prefix}} {{spinner}} {counts}  {{msg}}"),
    };
    let style = ProgressStyle::with_template(&template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
    let bar = total.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
    bar.with_style(style)
        .with_prefix(what.to_owned())
        .with_elapsed(elapsed)
}

/// One way through several recordings, with one bar for all.
#[derive(Debug)]
pub struct Pass {
    progress: Rc<RefCell<Progress>>,
    rows: Rc<Cell<u64>>,
    begun: u64,
}

impl Pass {
    /// Through recordings of `total` bytes together; `what` is done to them.
    #[must_use]
    pub fn new(what: &str, total: Option<u64>, globals: Globals) -> Self {
        let progress = Progress::new(what.to_owned(), Unit::Bytes, total, globals);
        Self {
            progress: Rc::new(RefCell::new(progress)),
            rows: Rc::default(),
            begun: 0,
        }
    }

    /// Reads `recording` on, after those before it.
    pub fn watch(&mut self, recording: Recording) -> Watched {
        let before = self.begun;
        self.begun += recording.total_bytes().unwrap_or(0);
        Watched {
            recording,
            progress: Rc::clone(&self.progress),
            rows: Rc::clone(&self.rows),
            before,
        }
    }
}

/// The rows of a recording, with progress by the bytes read.
#[derive(Debug)]
pub struct Watched {
    recording: Recording,
    progress: Rc<RefCell<Progress>>,
    rows: Rc<Cell<u64>>,
    /// Bytes of the recordings before.
    before: u64,
}

impl Watched {
    /// Reads `recording` on.
    #[must_use]
    pub fn new(recording: Recording, globals: Globals) -> Self {
        Pass::new("Reading", recording.total_bytes(), globals).watch(recording)
    }

    /// The recording below.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }
}

impl Iterator for Watched {
    type Item = Result<Row, ReadError>;

    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)]
    fn next(&mut self) -> Option<Self::Item> {
        let rows = self.rows.get() + 1;
        self.rows.set(rows);
        if rows.is_multiple_of(STRIDE) {
            let done = self.before + self.recording.bytes_read();
            self.progress.borrow_mut().reach(done, |elapsed| {
                let rate = (rows as f64 / elapsed.as_secs_f64()) as u64;
                format!("{} rows/s", indicatif::HumanCount(rate))
            });
        }
        self.recording.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(patience: Option<Duration>) -> Progress {
        Progress {
            what: "Testing".into(),
            unit: Unit::Bytes,
            total: Some(10),
            patience,
            begun: Instant::now(),
            bar: None,
        }
    }

    #[test]
    fn short_work_shows_nothing() {
        let mut short = progress(Some(Duration::from_secs(3600)));
        short.reach(5, |_| String::new());
        assert!(short.bar.is_none());
    }

    #[test]
    fn long_work_shows_a_bar_and_hidden_work_never_does() {
        let mut long = progress(Some(Duration::ZERO));
        long.reach(5, |_| String::new());
        assert_eq!(long.bar.as_ref().map(ProgressBar::position), Some(5));
        let mut hidden = progress(None);
        hidden.reach(5, |_| String::new());
        assert!(hidden.bar.is_none());
    }

    #[test]
    fn the_time_left_follows_the_mean_rate() {
        let second = Duration::from_secs(1);
        assert_eq!(remaining(second, 25, 100), Some(3 * second));
        assert_eq!(remaining(second, 100, 100), Some(Duration::ZERO));
        assert_eq!(remaining(second, 0, 100), None);
    }

    #[test]
    fn watching_passes_every_item_on() {
        let quiet = Globals { quiet: true };
        let watched = Progress::count("Counting", "steps", None, quiet).watch(0..10_000);
        assert_eq!(watched.sum::<u32>(), 49_995_000);
    }
}
