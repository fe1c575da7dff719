//! A recording as the edges of a disc: when each came, and where on the grid it stands.

use quadcal::estimate::Anchor;
use quadcal::step::{Flags, Outcome, Step};

use crate::recording::Row;
use crate::sensor::{PlanError, SensorPlan};

/// An edge that was captured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// When, s from the recording's clock zero.
    pub time_s: f64,
    /// Where, in edges of the grid from a pass of edge 0 on, turns counted through.
    pub place: i64,
}

/// Edges in a row, none missing, in one direction.
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
    /// Edges that the count was put right by at an index, forward positive; 0 where an edge came out of turn.
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
    /// All stretches, by time.
    pub stretches: Vec<Stretch>,
    /// Where the count was disturbed.
    pub slips: Vec<Slip>,
}

impl Track {
    /// Decodes a recording.
    ///
    /// # Errors
    /// [`PlanError`] when the sensor is out of the core's range, else the first error of the rows.
    pub fn of<E: From<PlanError>>(
        plan: SensorPlan,
        clock_hz: u64,
        rows: impl Iterator<Item = Result<Row, E>>,
    ) -> Result<Self, E> {
        let shape = plan.shape()?;
        let mut decoder = plan.decoder()?;
        #[allow(clippy::cast_precision_loss)]
        let mut walker = Walker {
            track: Self {
                edges: shape.edges().into(),
                classes: shape.classes().into(),
                tick_s: 1.0 / clock_hz as f64,
                anchored: plan.anchor() == Anchor::Index,
                origin: 0,
                stretches: Vec::new(),
                slips: Vec::new(),
            },
            turns: 0,
            last_edge: None,
            open: false,
        };
        for row in rows {
            match decoder.push(row?) {
                Outcome::Step(step) => walker.step(&step),
                Outcome::Glitch(glitch) => walker.slip(glitch.ticks, 0),
                Outcome::Index(index) if index.resync != 0 => {
                    walker.slip(index.ticks, index.resync);
                }
                Outcome::Index(_) | Outcome::Idle => {}
            }
        }
        Ok(walker.track)
    }

    /// Without an index: places are those of a shaft that starts at an angle.
    pub fn starts_at(&mut self, angle_rad: f64) {
        let Some(first) = self.stretches.first() else {
            return;
        };
        let (place, way) = (first.marks[0].place, first.direction);
        let step = std::f64::consts::TAU / self.edges as f64;
        // Between two edges, so the next one is half a step on, give or take; what kind of edge it is says which.
        let next = angle_rad / step + 0.5 * way as f64;
        let lines = ((next - place as f64) / self.classes as f64).round();
        #[allow(clippy::cast_possible_truncation)]
        let origin = lines as i64 * self.classes;
        self.origin = origin;
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

/// Follows the count.
struct Walker {
    track: Track,
    turns: i64,
    last_edge: Option<i64>,
    /// Whether the last stretch goes on.
    open: bool,
}

impl Walker {
    fn step(&mut self, step: &Step) {
        let direction = i64::from(step.direction.sign());
        if step.resync != 0 {
            self.slip(step.ticks, step.resync);
        }
        if step.flags.intersects(Flags::ILLEGAL.with(Flags::ABRUPT)) {
            self.slip(step.ticks, 0);
        }
        let edge = i64::from(step.edge);
        // Over the turn's end the number jumps back, or forth.
        if let Some(last) = self.last_edge {
            let jump = edge - last;
            if 2 * jump.abs() > self.track.edges {
                self.turns -= jump.signum();
            }
        }
        self.last_edge = Some(edge);
        if self.track.anchored && !step.flags.contains(Flags::REFERENCED) {
            return;
        }
        #[allow(clippy::cast_precision_loss)]
        let mark = Mark {
            time_s: step.ticks as f64 * self.track.tick_s,
            place: self.turns * self.track.edges + edge,
        };
        if let Some(stretch) = self.track.stretches.last_mut()
            && self.open
            && stretch.direction == direction
            && (stretch.marks.last()).is_some_and(|last| mark.place == last.place + direction)
        {
            stretch.marks.push(mark);
            return;
        }
        self.open = true;
        self.track.stretches.push(Stretch {
            marks: vec![mark],
            direction,
        });
    }

    fn slip(&mut self, ticks: u64, edges: i32) {
        #[allow(clippy::cast_precision_loss)]
        self.track.slips.push(Slip {
            time_s: ticks as f64 * self.track.tick_s,
            edges,
        });
        self.open = false;
    }
}
