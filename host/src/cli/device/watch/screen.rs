//! The chart on a terminal, drawn over and over in the same place.

use std::io;

use console::Term;

use super::super::chart::{capacity, draw, range};
use super::course::{Course, Sample};

/// Characters left of a chart.
const SCALE: usize = 12;

/// Lines that are no chart.
const WORDS: usize = 3;

/// The terminal.
pub(super) struct Screen {
    term: Term,
    /// Lines drawn.
    lines: usize,
}

impl Screen {
    pub(super) fn new() -> Self {
        Self {
            term: Term::buffered_stdout(),
            lines: 0,
        }
    }

    /// Draws the course so far in place of what was drawn before.
    pub(super) fn draw(&mut self, sample: &Sample, course: &Course) -> io::Result<()> {
        let (rows, columns) = self.term.size();
        let picture = picture(sample, course, rows.into(), columns.into());
        self.term.clear_last_lines(self.lines)?;
        self.lines = picture.len();
        for line in picture {
            self.term.write_line(&line)?;
        }
        self.term.flush()
    }
}

/// Both charts with one scale, in lines that fit a terminal of this size.
fn picture(sample: &Sample, course: &Course, rows: usize, columns: usize) -> Vec<String> {
    let columns = columns.max(SCALE + 10);
    let width = (columns - SCALE - 1).min(120);
    let height = (rows.saturating_sub(WORDS + 1) / 2).clamp(2, 8);
    let shown = course.kept.len().saturating_sub(capacity(width));
    let values = |of: usize| -> Vec<f64> {
        let kept = course.kept.iter().skip(shown);
        kept.map(|pair| pair[of]).collect()
    };
    let both = [values(0), values(1)];
    let scale = range(both.iter().flatten());
    let mut lines = Vec::new();
    let titles = ["before correction", "after correction"];
    for ((values, title), scatter) in both.iter().zip(titles).zip(course.scatter()) {
        let scatter = scatter.map_or_else(String::new, |value| format!(", scatter {value:.3}"));
        lines.push(format!("Speed {title}, r/min{scatter}"));
        for (index, line) in draw(values, width, height, scale).into_iter().enumerate() {
            let label = match index {
                0 => format!("{:.2}", scale[1]),
                index if index + 1 == height => format!("{:.2}", scale[0]),
                _ => String::new(),
            };
            lines.push(format!("{label:>width$} |{line}", width = SCALE - 2));
        }
    }
    let angle = sample.angle_rad.to_degrees();
    let from = if sample.referenced {
        ""
    } else {
        " from the start"
    };
    lines.push(format!(
        "{:.1} s  {:.3} r/min  {angle:.3}°{from}  {} faults  Ctrl-C ends",
        sample.time_s,
        sample.rev_per_min_after,
        sample.faults.total()
    ));
    // A line that wraps would put the next picture in the wrong place.
    let cut = |line: String| line.chars().take(columns - 1).collect();
    lines.into_iter().map(cut).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadcal::wire::Live;

    #[test]
    fn the_picture_fits_the_terminal_and_tells_rough_from_smooth() {
        let mut course = Course::new(1_000_000);
        let mut sample = course.push(&Live::default());
        for step in 0..200_i64 {
            sample = course.push(&Live {
                ticks: 1000 * step as u64,
                speed: 1 << 43,
                speed_raw: (1 << 43) + (step % 3 - 1) * (1 << 36),
                ..Live::default()
            });
        }
        for (rows, columns) in [(24, 80), (10, 40), (4, 5), (100, 300)] {
            let lines = picture(&sample, &course, rows, columns);
            let widest = lines.iter().map(|line| line.chars().count()).max().unwrap();
            assert!(widest < columns.max(22), "{columns}: {widest}");
            assert!(
                lines.len() <= rows.max(2 * 2 + WORDS),
                "{rows}: {}",
                lines.len()
            );
        }
        let lines = picture(&sample, &course, 24, 80);
        let inked = |part: &[String]| {
            part.iter()
                .filter(|line| line.chars().any(|c| c > '\u{2800}'))
                .count()
        };
        assert!(inked(&lines[1..9]) >= 2, "{lines:#?}");
        assert_eq!(inked(&lines[10..18]), 1, "{lines:#?}");
    }
}
