//! One recording as the engine sees it: edges with their time, their angle on the grid, and how the level changed.

use std::f64::consts::TAU;

use super::edges::Edges;
use super::held_up::{Held, Task};
pub use crate::effect::Change;
use crate::twin::Twin;

/// Part of a turn by which the first edge may be behind the angle that its twin starts at.
const LEAD_TURNS: f64 = 0.02;

/// A recording.
#[derive(Clone, Debug)]
pub struct Record {
    /// Time of each edge, s on the recording's clock.
    pub time_s: Vec<f64>,
    /// Place on the grid, edges, turns counted through.
    pub place: Vec<i64>,
    /// 1 forward, -1 in reverse.
    pub way: Vec<f64>,
    /// Edges a turn, N.
    pub edges: i64,
    /// Edge classes.
    pub classes: i64,
    /// RMS error of each stamp beside the others', s.
    pub doubt_s: Vec<f64>,
    /// Those that a declared task held up.
    pub held: Vec<Held>,
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Whether places are angles of the disc.
    pub anchored: bool,
}

impl Record {
    /// The edges of a recording, their turns counted from the one in which its twin starts; without an index or a gap, from the angle at
    /// which it does.
    #[must_use]
    pub fn of(edges: &Edges, twin: &Twin) -> Self {
        let (grid, classes) = (i64::from(edges.grid_edges), i64::from(edges.classes));
        let way = |forward: bool| if forward { 1.0 } else { -1.0 };
        let first = edges.place.first().map_or(0, |place| *place);
        let start_turns = twin.shaft.initial_angle_rad / TAU;
        let shift = if edges.anchored {
            let lead = first as f64 / grid as f64 - start_turns + LEAD_TURNS;
            -(lead.floor() as i64) * grid
        } else {
            // The shaft starts between the first edge and the one before it; the edge's class says which of those nearby it is.
            let starts = match (edges.time_s.as_slice(), edges.forward.first()) {
                ([first_s, second_s, ..], Some(forward)) => {
                    // The first row, if it is an edge, is an interval earlier.
                    let earlier = (first_s - edges.begins_s) / (second_s - first_s);
                    (0.5 + earlier.clamp(0.0, 1.0)) * way(*forward)
                }
                _ => 0.0,
            };
            let before = first as f64 - starts;
            ((start_turns * grid as f64 - before) / classes as f64).round() as i64 * classes
        };
        let time_s = &edges.time_s;
        let held = Task::of(twin).map(|task| {
            let near_s = twin.timer.jitter_s.hypot(edges.tick_s);
            task.held(time_s, near_s)
        });
        Self {
            time_s: time_s.clone(),
            doubt_s: vec![0.0; time_s.len()],
            held: held.unwrap_or_default(),
            place: edges.place.iter().map(|place| place + shift).collect(),
            way: edges.forward.iter().map(|forward| way(*forward)).collect(),
            edges: grid,
            classes,
            tick_s: edges.tick_s,
            anchored: edges.anchored,
        }
    }

    /// Edges.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Angle of an edge on the grid, rad, turns counted through.
    #[must_use]
    pub fn grid_rad(&self, at: usize) -> f64 {
        self.place[at] as f64 * self.step_rad()
    }

    /// A step of the grid, rad.
    #[must_use]
    pub fn step_rad(&self) -> f64 {
        TAU / self.edges as f64
    }

    /// The edge of the disc, 0 to N - 1.
    #[must_use]
    pub fn slot(&self, at: usize) -> usize {
        self.place[at].rem_euclid(self.edges) as usize
    }

    /// Edge class, 0 to C - 1.
    #[must_use]
    pub fn class(&self, at: usize) -> usize {
        self.place[at].rem_euclid(self.classes) as usize
    }

    /// What changes at an edge, as passed forward.
    #[must_use]
    pub fn change(&self, at: usize) -> Change {
        change(self.class(at), self.classes)
    }

    /// What changes at an edge, as it was captured: in reverse a rise is a fall.
    #[must_use]
    pub fn captured(&self, at: usize) -> Change {
        let change = self.change(at);
        Change {
            rises: change.rises == (self.way[at] > 0.0),
            ..change
        }
    }

    /// Channels.
    #[must_use]
    pub fn channels(&self) -> u8 {
        channels(self.classes)
    }

    /// Time from the first edge to the last, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Turns travelled, either way.
    #[must_use]
    pub fn turns(&self) -> f64 {
        let ways = self.place.windows(2).map(|pair| pair[1].abs_diff(pair[0]));
        ways.sum::<u64>() as f64 / self.edges as f64
    }
}

/// What changes at an edge of a class, as passed forward.
#[must_use]
pub fn change(class: usize, classes: i64) -> Change {
    let (channel, rises) = match classes {
        4 => (class % 2, class < 2),
        // B rise, C fall, A rise, B fall, C rise, A fall: edge 0 is the step from 001 to 011.
        6 => ([1, 2, 0][class % 3], class.is_multiple_of(2)),
        2 => (0, class == 0),
        _ => (0, true),
    };
    Change {
        channel: channel as u8,
        rises,
    }
}

/// Channels of a sensor with so many classes.
#[must_use]
pub const fn channels(classes: i64) -> u8 {
    match classes {
        4 => 2,
        6 => 3,
        _ => 1,
    }
}
