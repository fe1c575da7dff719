//! A recording as places: for each edge when it came, which edge of the disc it is, and where the count is broken.
//!
//! Nothing here looks at ratios of neighbouring intervals. Every sensor's edges go through one search for the likeliest way of the
//! shaft (see `follow`): what levels allow, what the pattern of a whole turn asks for, and a speed that changes smoothly.

mod coded;
mod find;
mod follow;
mod grid;
mod reversal;
#[cfg(test)]
mod tests;
mod wheel;

use quadcal::edge::Levels;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::recording::Row;

pub use find::{WheelFound, find_wheel};
pub use reversal::{Undecided, turned};

/// Most edges of a grid.
const MOST_EDGES: u32 = 4_000_000;

/// Advantage in log likelihood by which something is so sure that nothing else is thought of any more.
const SURE: f64 = 25.0;

/// A sensor, as declared or found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Channels A and B; edge k is A rise, B rise, A fall, B fall.
    Quadrature {
        /// Lines a turn.
        lines: u32,
        /// Levels of A and B in which a high Z marks line 0; none without an index.
        index: Option<Levels>,
    },
    /// Three Hall sensors; edge 0 is the step of (A, B, C) from 001 to 011, where B rises.
    Hall {
        /// Pole pairs a turn.
        pole_pairs: u32,
    },
    /// One channel. A tooth i that is high rises at edge 2i and falls at 2i + 1; one that is low (see [`Edges::inverted`]) falls at
    /// 2i + 1 and rises at 2i + 2. With single pulses, tooth i is edge i.
    Wheel {
        /// For each tooth place of a turn whether a tooth is there.
        present: Vec<bool>,
        /// Whether rows are both edges of teeth, or pulses whose levels say nothing.
        both_edges: bool,
    },
}

/// Why edges cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PlaceError {
    /// The sensor has no edges, or too many.
    #[error("a sensor of {0} edges a turn is out of range: 1 to {MOST_EDGES}")]
    Edges(u64),
    /// No tooth of the wheel is there.
    #[error("a wheel needs at least one tooth that is there")]
    NoTeeth,
    /// The recording shows no edge that can be placed.
    #[error("none of the {0} rows is an edge that can be placed")]
    NoEdges(usize),
}

/// What happened to the count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountKind {
    /// Edges of the disc are missing from the recording.
    Lost,
    /// Rows are there that no edge of the disc made.
    Extra,
    /// The index stands elsewhere than at its last pass.
    IndexSlip,
}

/// A disturbance of the count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountEvent {
    /// What.
    pub kind: CountKind,
    /// When, s; of lost edges about when the first would have come, of an index that moved when it was seen.
    pub time_s: f64,
    /// After what time it happened, s: of an index that moved that of its last pass before.
    pub after_s: f64,
    /// Where: the first edge lost, the edge before rows too many, or the index's new place.
    pub place: i64,
    /// Level bit of the channel: of the first edge lost or the rows too many.
    pub channel: u8,
    /// Edges lost, rows too many, or edges that the index moved by (forward positive).
    pub edges: i32,
}

impl CountEvent {
    /// One that is seen when it happens.
    const fn at(time_s: f64, kind: CountKind, edges: i32, channel: u8, place: i64) -> Self {
        Self {
            kind,
            time_s,
            after_s: time_s,
            place,
            channel,
            edges,
        }
    }
}

/// Why edges were not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unused {
    /// Pulses far shorter than those of the wheel at the speed beside them.
    Bounces,
    /// Edges that do not follow the pattern of the wheel, as when it rocks back, which one channel cannot show.
    OffPattern,
    /// Before or after a stop, after which one channel does not show which way the shaft goes on.
    EitherWay,
}

/// A stretch of the recording that is not used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub until_s: f64,
    /// Rows in it.
    pub rows: usize,
    /// Why.
    pub why: Unused,
}

/// The edges of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edges {
    /// Times, s from the clock's zero, never falling.
    pub time_s: Vec<f64>,
    /// Places on the grid, turns counted through: edge k of turn n is n N + k.
    pub place: Vec<i64>,
    /// Whether the edge was crossed forward.
    pub forward: Vec<bool>,
    /// Whether the count does not go on from the edge before: the turns, or without an anchor the places, may be wrong by some.
    pub fresh: Vec<bool>,
    /// Edges a turn of the grid, those of missing teeth included: N.
    pub grid_edges: u32,
    /// Edge classes: that of an edge is its place modulo these.
    pub classes: u32,
    /// A tick of the clock, s.
    pub tick_s: f64,
    /// Time of the first row, s: an edge of which the levels before are not known, or how they stood when the recording began.
    pub begins_s: f64,
    /// Whether places modulo N are edges of the disc, known by an index or by gaps.
    pub anchored: bool,
    /// Whether a wheel's teeth are low.
    pub inverted: bool,
    /// Mean log likelihood of an edge: of two wheels for one recording, the one with the higher value fits better.
    pub fit: f64,
    /// Disturbances of the count, by time.
    pub events: Vec<CountEvent>,
    /// What was not used, by time.
    pub unused: Vec<Stretch>,
}

/// Places the edges of a recording.
///
/// # Errors
/// Where the sensor cannot be, or the rows hold none of its edges.
pub fn place(sensor: &Sensor, clock_hz: u64, rows: &[Row]) -> Result<Edges, PlaceError> {
    let (edges, classes) = match sensor {
        Sensor::Quadrature { lines, .. } => (4 * u64::from(*lines), 4),
        Sensor::Hall { pole_pairs } => (6 * u64::from(*pole_pairs), 6),
        Sensor::Wheel {
            present,
            both_edges,
        } => {
            let each = 1 + u32::from(*both_edges);
            if !present.contains(&true) {
                return Err(PlaceError::NoTeeth);
            }
            (u64::from(each) * present.len() as u64, each)
        }
    };
    let grid_edges = u32::try_from(edges)
        .ok()
        .filter(|edges| (1..=MOST_EDGES).contains(edges))
        .ok_or(PlaceError::Edges(edges))?;
    let mut found = Edges {
        grid_edges,
        classes,
        tick_s: 1.0 / clock_hz as f64,
        begins_s: rows
            .first()
            .map_or(0.0, |row| row.ticks as f64 / clock_hz as f64),
        ..Edges::default()
    };
    match sensor {
        Sensor::Quadrature { index, .. } => {
            coded::place(coded::Code::Quadrature, *index, rows, &mut found);
        }
        Sensor::Hall { .. } => coded::place(coded::Code::Hall, None, rows, &mut found),
        Sensor::Wheel {
            present,
            both_edges: true,
        } => wheel::place(present, rows, &mut found),
        Sensor::Wheel { present, .. } => wheel::place_pulses(present, rows, &mut found),
    }
    if found.time_s.is_empty() {
        return Err(PlaceError::NoEdges(rows.len()));
    }
    Ok(found)
}

impl Edges {
    /// Number of edges.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Counts from an index that has stood so many edges further all along; not twice, so false if it does.
    pub fn move_index(&mut self, edges: i64) -> bool {
        let start_s = self.time_s.first().copied().unwrap_or(0.0);
        let mut events = self.events.iter();
        if events.any(|event| event.kind == CountKind::IndexSlip && event.time_s == start_s) {
            return false;
        }
        self.place.iter_mut().for_each(|place| *place += edges);
        self.events
            .iter_mut()
            .for_each(|event| event.place += edges);
        let slip = CountEvent::at(
            start_s,
            CountKind::IndexSlip,
            edges as i32,
            Levels::Z,
            edges,
        );
        self.events.push(slip);
        true
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    fn push(&mut self, ticks: u64, place: i64, forward: bool, fresh: bool) {
        self.time_s.push(self.seconds(ticks));
        self.place.push(place);
        self.forward.push(forward);
        self.fresh.push(fresh);
    }

    fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 * self.tick_s
    }
}

/// The middle of some values; none of no values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
