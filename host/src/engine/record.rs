//! One recording as the engine sees it: edges with their time, their angle on the grid, and how the level changed.

use std::f64::consts::TAU;

use crate::diagnose::track::Track;
use crate::twin::Twin;

/// Part of a turn by which the first edge may be behind the angle that its twin starts at.
const LEAD_TURNS: f64 = 0.02;

/// What changes at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// 0 is A.
    pub channel: u8,
    /// Whether the level rises when the mark is passed forward.
    pub rises: bool,
}

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
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Whether places are angles of the disc.
    pub anchored: bool,
}

impl Record {
    /// The edges of a track.
    #[must_use]
    pub fn of(track: &Track, twin: &Twin) -> Self {
        let mut track = track.clone();
        if !track.anchored && !track.placed {
            track.starts_at(twin.shaft.initial_angle_rad);
        }
        // Hall sensors are counted by the state that they come to, edge 0 leads to state 1.
        let ahead = i64::from(track.classes == 6);
        let early = track.early.iter().map(|mark| (*mark, 1));
        let mut directed: Vec<_> = early.chain(track.directed()).collect();
        let classes = directed.iter().skip(1).zip(&directed);
        // Edges before the first index go the way their places do.
        let ways: Vec<i64> = classes
            .map(|(next, this)| (next.0.place - this.0.place).signum())
            .collect();
        for (one, way) in directed.iter_mut().zip(ways).take(track.early.len()) {
            one.1 = if way < 0 { -1 } else { 1 };
        }
        // Turns count from the one in which the shaft starts.
        let first = directed
            .first()
            .map_or(0, |(mark, _)| mark.place + track.origin - ahead);
        let lead = (first as f64 / track.edges as f64 - twin.shaft.initial_angle_rad / TAU
            + LEAD_TURNS)
            .floor();
        let turns = if track.anchored {
            lead as i64 * track.edges
        } else {
            0
        };
        let mut record = Self {
            time_s: Vec::with_capacity(directed.len()),
            place: Vec::with_capacity(directed.len()),
            way: Vec::with_capacity(directed.len()),
            edges: track.edges,
            classes: track.classes,
            tick_s: track.tick_s,
            anchored: track.anchored,
        };
        for (mark, direction) in directed {
            record.time_s.push(mark.time_s);
            record.place.push(mark.place + track.origin - ahead - turns);
            record.way.push(direction as f64);
        }
        record
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
