//! How far a recording is from what its twin would have recorded, edge by edge.
//!
//! The angle of each edge on the disc is compared with the angle of the twin's shaft at the same time (see [`super::turning`]), so an
//! angle is positive where the shaft, or the mark on it, is ahead. Everything that the twin declares, its disc, delays, ripple and
//! profile, is out of the residual; the mean speed, which nobody knows exactly, and the start are taken from the recording.

use std::f64::consts::TAU;

use super::kalman::Reading;
use super::shaft::ShaftLaw;
use super::still::Still;
use super::track::Track;
use crate::sensor::SensorPlan;
use crate::twin::{Twin, TwinError};

/// The residual of one recording, one entry an edge.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Edges a turn.
    pub edges: i64,
    /// Edge classes.
    pub classes: i64,
    /// By how much a place is ahead of the twin's number of its edge: Hall sensors are counted by the state that they come to.
    pub shift: i64,
    /// Errors of the twin's disc, rad, for every edge of the grid.
    pub errors: Vec<f64>,
    /// Where each edge is on the grid, turns counted through.
    pub places: Vec<i64>,
    /// When it came, s.
    pub times_s: Vec<f64>,
    /// Speed of the twin there, rad/s, negative in reverse.
    pub speeds: Vec<f64>,
    /// Its angle less the twin's, rad.
    pub angles: Vec<f64>,
    /// What the noise model needs of it.
    pub readings: Vec<Reading>,
    /// Whether the shaft is pushed now and then by what the twin does not have (see [`super::pushed`]).
    pub pushed: bool,
}

impl Seen {
    /// Compares a recording with its twin.
    ///
    /// # Errors
    /// [`TwinError`] where the twin can't be run.
    pub fn of(track: &Track, plan: SensorPlan, twin: &Twin) -> Result<Self, TwinError> {
        let still = Still::of(track, plan, twin)?;
        let law = ShaftLaw::of(twin);
        let mut seen = Self {
            edges: track.edges,
            classes: track.classes,
            shift: still.shift,
            errors: still.errors.clone(),
            ..Self::default()
        };
        seen.compare(track, twin, &still, &law);
        if !track.anchored {
            seen.align();
        }
        Ok(seen)
    }

    /// Without an index the start says which edge is the first, give or take a line: the known errors fit best where they belong.
    fn align(&mut self) {
        const LINES: i64 = 3;
        if self.errors.iter().all(|error| *error == 0.0) {
            return;
        }
        let error = |place: i64| {
            let edge = (place - self.shift).rem_euclid(self.edges);
            self.errors.get(edge as usize).copied().unwrap_or(0.0)
        };
        let roughness = |lines: i64| -> f64 {
            let moved = |at: usize| {
                let place = self.places[at];
                self.angles[at] + error(place) - error(place + lines * self.classes)
            };
            let steps = (1..self.len().min(20_000)).map(|at| moved(at) - moved(at - 1));
            steps.map(|step| step * step).sum()
        };
        let each = (-LINES..=LINES).map(|lines| (lines, roughness(lines)));
        let Some((lines, least)) = each.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return;
        };
        if lines == 0 || least > 0.8 * roughness(0) {
            return;
        }
        let shift = lines * self.classes;
        let moves: Vec<f64> = self
            .places
            .iter()
            .map(|place| error(*place) - error(place + shift))
            .collect();
        for ((angle, place), by) in self.angles.iter_mut().zip(&mut self.places).zip(moves) {
            *angle += by;
            *place += shift;
        }
    }

    /// Edges compared.
    #[must_use]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether nothing could be compared.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Angle of an edge on the grid, rad, turns counted through.
    #[must_use]
    pub fn theta(&self, at: usize) -> f64 {
        (self.places[at] - self.shift) as f64 * (TAU / self.edges as f64)
    }

    /// True angle of an edge as the twin's disc has it, rad.
    #[must_use]
    pub fn true_theta(&self, at: usize) -> f64 {
        self.theta(at) - self.errors.get(self.edge(at)).copied().unwrap_or(0.0)
    }

    /// Class of an edge.
    #[must_use]
    pub fn class(&self, at: usize) -> usize {
        usize::try_from(self.places[at].rem_euclid(self.classes)).unwrap_or(0)
    }

    /// Edge of the disc.
    #[must_use]
    pub fn edge(&self, at: usize) -> usize {
        usize::try_from((self.places[at] - self.shift).rem_euclid(self.edges)).unwrap_or(0)
    }

    /// Whether the course follows the recording here, as a push that nobody knows sends it anywhere.
    #[must_use]
    pub fn follows(&self, at: usize) -> bool {
        self.pushed && self.readings[at].jolt > 0.0
    }

    /// Turns compared.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.len() as f64 / self.edges as f64
    }

    /// Time from first to last edge, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        match (self.times_s.first(), self.times_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Mean speed, rad/s, either way.
    #[must_use]
    pub fn mean_speed(&self) -> f64 {
        self.speeds.iter().map(|speed| speed.abs()).sum::<f64>() / self.len().max(1) as f64
    }

    /// Least and greatest signed speed, rad/s.
    #[must_use]
    pub fn speed_range(&self) -> [f64; 2] {
        let each = self.speeds.iter();
        each.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], speed| {
            [low.min(*speed), high.max(*speed)]
        })
    }
}
