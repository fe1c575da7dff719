//! Edges, directions and speeds of a recording, counted as its rows pass.

use quadcal::edge::Levels;
use serde::Serialize;

use crate::recording::{Channels, Row};

/// Edges over which a speed is taken: whole cycles of quadrature and of Hall sensors, so that their own errors average out.
pub const SPAN: u64 = 60;

/// What is counted.
#[derive(Clone, Debug)]
pub struct Tally {
    channels: Channels,
    before: Option<Levels>,
    /// Changes of a channel other than Z; of pulses, the pulses.
    pub edges: u64,
    /// Which way a quadrature encoder turned; empty for others.
    pub steps: Steps,
    first: u64,
    last: u64,
    span_start: Option<u64>,
    slowest: u64,
    fastest: u64,
}

/// Steps of a quadrature encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Steps {
    /// A before B.
    pub forward: u64,
    /// B before A.
    pub backward: u64,
    /// A and B at once, which hides an edge.
    pub skipped: u64,
}

/// Edges a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// Over the slowest [`SPAN`] edges.
    pub lowest: f64,
    /// From the first edge to the last.
    pub mean: f64,
    /// Over the fastest [`SPAN`] edges.
    pub highest: f64,
}

impl Tally {
    /// Nothing counted yet.
    pub fn new(channels: Channels) -> Self {
        Self {
            channels,
            before: None,
            edges: 0,
            steps: Steps::default(),
            first: 0,
            last: 0,
            span_start: None,
            slowest: 0,
            fastest: u64::MAX,
        }
    }

    /// Counts one row.
    pub fn push(&mut self, row: &Row) {
        let before = self.before.replace(row.levels);
        let is_edge = match (self.channels, before) {
            (Channels::Pulses, _) => true,
            // The first row is where the levels stand, no change.
            (_, None) => false,
            (Channels::Quadrature { .. }, Some(before)) => self.steps.push(before, row.levels),
            (Channels::Hall | Channels::Wheel, Some(before)) => before != row.levels,
        };
        if is_edge {
            self.edge(row.ticks);
        }
    }

    fn edge(&mut self, ticks: u64) {
        if self.edges == 0 {
            self.first = ticks;
        }
        self.last = ticks;
        if self.edges.is_multiple_of(SPAN)
            && let Some(start) = self.span_start.replace(ticks)
        {
            self.slowest = self.slowest.max(ticks - start);
            self.fastest = self.fastest.min(ticks - start);
        }
        self.edges += 1;
    }

    /// Rates on a clock of `clock_hz`; none of a recording shorter than [`SPAN`] edges, or where times do not tell edges apart.
    #[allow(clippy::cast_precision_loss)]
    pub fn rates(&self, clock_hz: u64) -> Option<Rates> {
        if self.edges <= SPAN || self.fastest == 0 {
            return None;
        }
        let rate = |edges: u64, ticks: u64| edges as f64 * clock_hz as f64 / ticks as f64;
        Some(Rates {
            lowest: rate(SPAN, self.slowest),
            mean: rate(self.edges - 1, self.last - self.first),
            highest: rate(SPAN, self.fastest),
        })
    }
}

impl Rates {
    /// The same in revolutions a minute of an encoder with `edges` a turn.
    pub fn per_minute(self, edges: u32) -> Self {
        let scale = 60.0 / f64::from(edges);
        Self {
            lowest: self.lowest * scale,
            mean: self.mean * scale,
            highest: self.highest * scale,
        }
    }
}

impl Steps {
    /// Counts a change of A and B, and says whether there was one.
    fn push(&mut self, before: Levels, now: Levels) -> bool {
        match (before.a() != now.a(), before.b() != now.b()) {
            (false, false) => return false,
            (true, true) => self.skipped += 1,
            // Forward, A changes away from B and B changes to A.
            (true, false) if now.a() != now.b() => self.forward += 1,
            (false, true) if now.a() == now.b() => self.forward += 1,
            _ => self.backward += 1,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: [u8; 4] = [1, 3, 2, 0];

    fn tally(rows: impl Iterator<Item = (u64, u8)>) -> Tally {
        let mut tally = Tally::new(Channels::Quadrature { index: true });
        rows.for_each(|(ticks, levels)| {
            tally.push(&Row {
                ticks,
                levels: Levels(levels),
            });
        });
        tally
    }

    #[test]
    fn steps_are_told_by_direction_and_the_index_is_no_edge() {
        let there = FORWARD.iter().chain(&[1, 5, 1]);
        let back = [0, 2, 3, 1, 2];
        let levels = there.chain(&back).copied();
        let tally = tally((0..).zip(levels));
        let expected = Steps {
            forward: 4,
            backward: 4,
            skipped: 1,
        };
        assert_eq!(tally.steps, expected);
        assert_eq!(tally.edges, 9);
    }

    #[test]
    fn rates_hold_the_slow_and_the_fast_part() {
        // 1000 edges at 10 ticks, then 1000 at 40.
        let rows = (0..2000_u64).map(|n| {
            let ticks = if n < 1000 {
                n * 10
            } else {
                10_000 + (n - 1000) * 40
            };
            (ticks, FORWARD[(n % 4) as usize])
        });
        let rates = tally(rows).rates(1000).unwrap();
        assert_eq!((rates.lowest, rates.highest), (25.0, 100.0));
        assert!((rates.mean - 40.0).abs() < 0.1, "{rates:?}");
        assert_eq!(rates.per_minute(100).highest, 60.0);
    }

    #[test]
    fn a_short_recording_has_no_rates() {
        let rows = (0..SPAN).map(|n| (n, FORWARD[(n % 4) as usize]));
        assert_eq!(tally(rows).rates(1000), None);
    }
}
