//! A recording as the edges of a disc: when each came, and where on the grid it stands.

use std::f64::consts::TAU;

use quadcal::estimate::Anchor;

use super::code::Code;
use super::ends::Ends;
use super::index::Moved;
use super::mend::{Fault, Mended, mend};
use super::walk::Walker;
use crate::recording::Row;
use crate::sensor::{PlanError, SensorKind, SensorPlan};

/// An edge that was captured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// When, s from the recording's clock zero.
    pub time_s: f64,
    /// Where, in edges of the grid from a pass of edge 0 on, turns counted through.
    pub place: i64,
}

/// Edges in a row in one direction; one that was not captured, or not at its own time, is left out and counted through.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// The edges, by time.
    pub marks: Vec<Mark>,
    /// 1 forward, -1 in reverse.
    pub direction: i64,
}

/// A disturbance of the count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// When it showed, s.
    pub time_s: f64,
    /// Edges that the index moved by, forward positive; 0 where edges were lost or came in between.
    pub edges: i32,
}

/// A recording.
#[derive(Clone, Debug)]
pub struct Track {
    /// Edges a turn, N.
    pub edges: i64,
    /// Edge classes, C.
    pub classes: i64,
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Whether places are angles of the disc; without an index they count from the first edge.
    pub anchored: bool,
    /// What a place lacks to be an edge of the disc, as far as it is known from elsewhere.
    pub origin: i64,
    /// Whether that was found already.
    pub placed: bool,
    /// Where a task that is known holds captures up.
    pub ends: Option<Ends>,
    /// Samples at which a speed loop saw otherwise than stamps have it, s, once they were decided.
    pub turned: Option<Vec<f64>>,
    /// Edges before the first index, which say where they were once it has come; most of what is looked at begins with the index.
    pub early: Vec<Mark>,
    /// All stretches, by time.
    pub stretches: Vec<Stretch>,
    /// Where the count was disturbed.
    pub slips: Vec<Slip>,
    /// What the capture did wrong, by time.
    pub faults: Vec<Fault>,
    /// Where the index moved against the disc, by time.
    pub moved: Vec<Moved>,
}

impl Track {
    /// Decodes a recording. The first index says where the disc is; from then on edges are counted, past lost and spurious ones, and
    /// whatever the index does.
    ///
    /// # Errors
    /// [`PlanError`] when the sensor is out of the core's range, else the first error of the rows.
    pub fn of<E: From<PlanError>>(
        plan: SensorPlan,
        clock_hz: u64,
        rows: impl Iterator<Item = Result<Row, E>>,
    ) -> Result<Self, E> {
        let shape = plan.shape()?;
        let rows: Vec<Row> = rows.collect::<Result<_, E>>()?;
        let code = Code::of(plan);
        let decoder = match code {
            Some(Code::OneChannel) => None,
            _ => Some(plan.decoder()?),
        };
        let mended = match code {
            Some(code) => mend(code, &rows),
            None => Mended::untouched(&rows),
        };
        let track = Self {
            edges: shape.edges().into(),
            classes: shape.classes().into(),
            tick_s: 1.0 / clock_hz as f64,
            anchored: plan.anchor() == Anchor::Index,
            origin: 0,
            placed: false,
            ends: None,
            turned: None,
            early: Vec::new(),
            stretches: Vec::new(),
            slips: Vec::new(),
            faults: mended.faults,
            moved: Vec::new(),
        };
        let has_z = matches!(
            plan.kind,
            SensorKind::Quadrature {
                index_state: Some(_)
            }
        );
        let mut track = Walker::new(track, decoder, has_z).walk(&mended.pieces);
        track.note_slips();
        Ok(track)
    }

    fn note_slips(&mut self) {
        let faults = self.faults.iter().map(|fault| Slip {
            time_s: fault.ticks as f64 * self.tick_s,
            edges: 0,
        });
        let moved = self.moved.iter().map(|moved| Slip {
            time_s: moved.between_s[1],
            edges: moved.edges,
        });
        self.slips = faults.chain(moved).collect();
        self.slips.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }

    /// Without an index: places are those of a shaft that starts at an angle.
    pub fn starts_at(&mut self, angle_rad: f64) {
        let Some(before) = self.before_first() else {
            return;
        };
        // What kind of edge the first one is says which of those near the angle.
        let lines = ((angle_rad / self.step_rad() - before) / self.classes as f64).round();
        #[allow(clippy::cast_possible_truncation)]
        let origin = lines as i64 * self.classes;
        self.origin = origin;
        self.placed = true;
    }

    /// An angle, rad, at which a shaft starts that makes places as they are; never 0, which says nothing.
    #[must_use]
    pub fn start_rad(&self) -> Option<f64> {
        let steps = self.before_first()? + self.origin as f64;
        Some((steps * self.step_rad()).rem_euclid(TAU))
    }

    /// The middle between the first edge and the one before it, in edges of the grid as they were counted first: a shaft that starts
    /// there has the edge half a step ahead, give or take.
    fn before_first(&self) -> Option<f64> {
        let first = self.stretches.first()?;
        // Hall sensors are counted by the state that they come to, edge 0 leads to state 1.
        let ahead = f64::from(u8::from(self.classes == 6));
        Some(first.marks[0].place as f64 - ahead - 0.5 * first.direction as f64)
    }

    fn step_rad(&self) -> f64 {
        TAU / self.edges as f64
    }

    /// All marks, each with the direction of its stretch.
    #[must_use]
    pub fn directed(&self) -> Vec<(Mark, i64)> {
        let each = self.stretches.iter().flat_map(|stretch| {
            let marks = stretch.marks.iter();
            marks.map(|mark| (*mark, stretch.direction))
        });
        each.collect()
    }

    /// Whether it goes in both directions, each for a while.
    #[must_use]
    pub fn reverses(&self) -> bool {
        let goes = |direction: i64| {
            let there = self.stretches.iter().filter(|s| s.direction == direction);
            8 * there.map(|s| s.marks.len()).max().unwrap_or(0) as i64 > self.edges
        };
        goes(1) && goes(-1)
    }

    /// Turns in all stretches.
    #[must_use]
    pub fn turns(&self) -> f64 {
        let edges: usize = self.stretches.iter().map(|s| s.marks.len()).sum();
        edges as f64 / self.edges as f64
    }

    /// Time of the last edge, s.
    #[must_use]
    pub fn end_s(&self) -> Option<f64> {
        let lasts = self.stretches.iter().filter_map(|s| s.marks.last());
        lasts.map(|mark| mark.time_s).reduce(f64::max)
    }

    /// The stretch with the most edges.
    #[must_use]
    pub fn longest(&self) -> Option<&Stretch> {
        self.stretches
            .iter()
            .max_by_key(|stretch| stretch.marks.len())
    }
}
