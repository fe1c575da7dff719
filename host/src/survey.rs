//! One pass over a recording before anything is learned from it: how long, how fast, and how many edges a turn it shows.

use std::collections::HashMap;

use quadcal::edge::Levels;

use crate::pattern::{INTERVALS_MAX, Repeat, relative};
use crate::recording::{Channels, Header, ReadError, Row};
use crate::time_step::TimeStep;

/// What a recording shows of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Clock and channels.
    pub header: Header,
    /// Rows, that is changes of level or pulses.
    pub rows: u64,
    /// Time of the first row, ticks.
    pub first: u64,
    /// Time of the last row, ticks.
    pub last: u64,
    /// Index pulses seen.
    pub index_pulses: u64,
    /// The step of the time stamps.
    pub time_step: TimeStep,
    /// Rows with Z high, by the state of A and B (bit 0 A, bit 1 B).
    index_votes: [u64; 4],
    /// Quadrature edges between index pulses in the same direction, and how often each number was found.
    spans: HashMap<u32, u64>,
    /// The latest intervals between rows, of a sensor without an index.
    intervals: Vec<f64>,
}

impl Survey {
    /// Reads all of `rows`.
    ///
    /// # Errors
    /// The first error of the recording.
    pub fn of(
        header: Header,
        rows: impl Iterator<Item = Result<Row, ReadError>>,
    ) -> Result<Self, ReadError> {
        let quadrature = matches!(header.channels, Channels::Quadrature { index: true });
        let mut survey = Self {
            time_step: TimeStep::new(header.clock_hz),
            header,
            rows: 0,
            first: 0,
            last: 0,
            index_pulses: 0,
            index_votes: [0; 4],
            spans: HashMap::new(),
            intervals: Vec::new(),
        };
        let mut counter = IndexCounter::default();
        for row in rows {
            let row = row?;
            if survey.rows == 0 {
                survey.first = row.ticks;
            }
            #[allow(clippy::cast_precision_loss)]
            if !quadrature && survey.rows > 0 && survey.intervals.len() < INTERVALS_MAX {
                survey.intervals.push((row.ticks - survey.last) as f64);
            }
            survey.rows += 1;
            survey.time_step.push(row.ticks);
            survey.last = row.ticks;
            if quadrature {
                survey.count(&mut counter, row.levels);
            }
        }
        Ok(survey)
    }

    fn count(&mut self, counter: &mut IndexCounter, levels: Levels) {
        if levels.z() {
            self.index_votes[usize::from(levels.0 & 3)] += 1;
        }
        let Some(span) = counter.push(levels) else {
            return;
        };
        self.index_pulses += 1;
        if let Some(span) = span {
            *self.spans.entry(span).or_default() += 1;
        }
    }

    /// Length of the recording in seconds.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn seconds(&self) -> f64 {
        (self.last - self.first) as f64 / self.header.clock_hz as f64
    }

    /// Lines a turn of a quadrature encoder, from the edges between index pulses: the number found most often, if it is a
    /// whole number of lines and was found in at least half of all cases.
    #[must_use]
    pub fn lines(&self) -> Option<u32> {
        let (&edges, &found) = self
            .spans
            .iter()
            .max_by_key(|&(&edges, &found)| (found, edges))?;
        let all: u64 = self.spans.values().sum();
        (edges > 0 && edges.is_multiple_of(4) && 2 * found >= all).then_some(edges / 4)
    }

    /// How the intervals of a sensor without an index repeat, at the shortest turn that explains them; edges come in
    /// multiples of `classes`. Up to 30 lines are looked for: in longer ones, rhythms of the machine's work look like a turn.
    #[must_use]
    pub fn repeat(&self, classes: u32) -> Option<Repeat> {
        const LINES_MOST: usize = 30;
        let classes = classes as usize;
        Repeat::shortest(&relative(self.settled()), classes, LINES_MOST * classes)
    }

    /// How the intervals repeat at a given number of edges.
    #[must_use]
    pub fn repeat_at(&self, edges: u32) -> Option<Repeat> {
        Repeat::of(&relative(self.settled()), edges as usize)
    }

    /// The intervals without a first eighth, in which a shaft often starts.
    fn settled(&self) -> &[f64] {
        &self.intervals[self.intervals.len() / 8..]
    }

    /// State of A and B that marks the index: A high and B low, where edge 0 of the grid has just passed, or, if Z is never
    /// high there, the state in which it most often is.
    #[must_use]
    pub fn index_state(&self) -> Levels {
        let usual = Levels::A;
        if self.index_votes[usize::from(usual)] > 0 {
            return Levels(usual);
        }
        let best = (0..4_u8).max_by_key(|&state| self.index_votes[usize::from(state)]);
        Levels(best.unwrap_or(usual))
    }
}

/// Counts quadrature steps between rising edges of Z.
#[derive(Default)]
struct IndexCounter {
    before: Option<Levels>,
    count: i64,
    forward: bool,
    at_index: Option<(i64, bool)>,
}

impl IndexCounter {
    /// `Some` at an index pulse, with the edges since the one before if the shaft did not turn back in between.
    fn push(&mut self, levels: Levels) -> Option<Option<u32>> {
        let before = self.before.replace(levels)?;
        let sector = |levels: Levels| match (levels.a(), levels.b()) {
            (true, false) => 0_u8,
            (true, true) => 1,
            (false, true) => 2,
            (false, false) => 3,
        };
        let moved = (sector(levels) + 4 - sector(before)) % 4;
        match moved {
            1 => (self.count, self.forward) = (self.count + 1, true),
            3 => (self.count, self.forward) = (self.count - 1, false),
            // Two edges in one row: in the direction of motion.
            2 => self.count += if self.forward { 2 } else { -2 },
            _ => {}
        }
        if before.z() || !levels.z() {
            return None;
        }
        let earlier = self.at_index.replace((self.count, self.forward));
        let span = earlier
            .filter(|&(_, forward)| forward == self.forward)
            .map(|(count, _)| count.abs_diff(self.count));
        Some(
            span.and_then(|span| u32::try_from(span).ok())
                .filter(|&span| span > 0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn survey(lines: u32, turns: u32, drop: &[usize]) -> Survey {
        let header = Header {
            clock_hz: 1000,
            channels: Channels::Quadrature { index: true },
            notes: Vec::new(),
        };
        let states = [Levels::A, Levels::A | Levels::B, Levels::B, 0];
        let mut rows = Vec::new();
        for edge in 0..4 * lines * turns {
            let levels = states[(edge % 4) as usize];
            let ticks = u64::from(edge) * 10;
            if edge % (4 * lines) == 0 {
                rows.push(Row {
                    ticks: ticks.saturating_sub(5),
                    levels: Levels(Levels::Z),
                });
                rows.push(Row {
                    ticks,
                    levels: Levels(levels | Levels::Z),
                });
                rows.push(Row {
                    ticks: ticks + 5,
                    levels: Levels(levels),
                });
            } else {
                rows.push(Row {
                    ticks,
                    levels: Levels(levels),
                });
            }
        }
        let rows = rows
            .into_iter()
            .enumerate()
            .filter(|(i, _)| !drop.contains(i))
            .map(|(_, row)| Ok(row));
        Survey::of(header, rows).unwrap()
    }

    #[test]
    fn lines_are_found_between_index_pulses() {
        let survey = survey(25, 6, &[]);
        assert_eq!(survey.lines(), Some(25));
        assert_eq!(survey.index_state(), Levels(Levels::A));
    }

    #[test]
    fn one_turn_with_lost_lines_does_not_hide_the_others() {
        let dropped: Vec<usize> = (40..44).collect();
        assert_eq!(survey(25, 6, &dropped).lines(), Some(25));
    }
}
