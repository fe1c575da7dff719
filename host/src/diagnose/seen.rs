//! How far a recording is from what its twin would have recorded, edge by edge.
//!
//! The twin is run without any randomness and its edges are compared where they stand on the disc: an edge that came `u` later
//! than the twin's shows the angle -w u, with w the signed speed. So an angle is positive where the shaft, or the mark on it, is
//! ahead. Everything that the twin declares, its disc, delays, ripple and profile, is in its edges and so is out of the residual;
//! the mean speed, which nobody knows exactly, and the start are taken from the recording.

use std::f64::consts::TAU;

use super::kalman::Reading;
use super::shaft::{Leap, ShaftLaw};
use super::still::Still;
use super::track::{Mark, Stretch, Track};
use crate::sensor::SensorPlan;
use crate::twin::{Twin, TwinError};

/// Edges that a stretch needs to be looked at.
pub const EDGES_LEAST: usize = 16;

/// The residual of one recording, one entry an edge.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Edges a turn.
    pub edges: i64,
    /// Edge classes.
    pub classes: i64,
    /// Errors of the twin's disc, rad, for every edge of the grid.
    pub errors: Vec<f64>,
    /// Where each edge is on the grid, turns counted through.
    pub places: Vec<i64>,
    /// When it came, s.
    pub times_s: Vec<f64>,
    /// Speed of the twin there, rad/s, negative in reverse.
    pub speeds: Vec<f64>,
    /// How much less an error of the disc shows than it is: the speed without the twin's rhythms over that with them.
    pub shows: Vec<f64>,
    /// Its angle less the twin's, rad.
    pub angles: Vec<f64>,
    /// What the noise model needs of it.
    pub readings: Vec<Reading>,
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
            errors: still.errors.clone(),
            ..Self::default()
        };
        if track.reverses() || twin.speed_loop().is_some() {
            seen.compare_by_time(track, twin, &still, &law);
            return Ok(seen);
        }
        let mut before: Option<&Stretch> = None;
        for stretch in &track.stretches {
            if stretch.marks.len() < EDGES_LEAST {
                continue;
            }
            // A reversal goes on from the last edge; a stretch of the same direction comes after a disturbance.
            let goes_on = before.is_some_and(|before| before.direction != stretch.direction);
            seen.compare(track, stretch, &still, &law, !goes_on);
            before = Some(stretch);
        }
        Ok(seen)
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
        self.places[at] as f64 * (TAU / self.edges as f64)
    }

    /// Class of an edge.
    #[must_use]
    pub fn class(&self, at: usize) -> usize {
        usize::try_from(self.places[at].rem_euclid(self.classes)).unwrap_or(0)
    }

    /// Edge of the disc.
    #[must_use]
    pub fn edge(&self, at: usize) -> usize {
        usize::try_from(self.places[at].rem_euclid(self.edges)).unwrap_or(0)
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

    fn compare(
        &mut self,
        track: &Track,
        stretch: &Stretch,
        still: &Still,
        law: &ShaftLaw,
        fresh: bool,
    ) {
        let Some((twins, pace)) = still.alongside(stretch) else {
            return;
        };
        let shift = turns_apart(track, stretch, twins, pace) * track.edges;
        let way = stretch.direction as f64;
        let swing = still.swinging(stretch);
        let mut fresh = fresh;
        for mark in &stretch.marks {
            let place = mark.place + shift;
            let edge = (place + still.origin).rem_euclid(track.edges);
            let edge = usize::try_from(edge).unwrap_or(0);
            let past = still.errors.get(edge).copied().unwrap_or(0.0);
            let (Some(here), Some(speed)) =
                (time_at(twins, place), speed_at(pace, place, -past, still.reach))
            else {
                continue;
            };
            let lateness = mark.time_s - here;
            let swung = swing.and_then(|swing| speed_at(swing, place, -past, still.fine));
            let after_s = self.times_s.last().map_or(0.0, |last| mark.time_s - last);
            self.places.push(mark.place + still.origin);
            self.times_s.push(mark.time_s);
            self.speeds.push(speed * way);
            self.shows.push(swung.map_or(1.0, |swung| speed / swung));
            self.angles.push(-speed * way * lateness);
            self.readings.push(Reading {
                leap: Leap {
                    after_s,
                    damping: law.damping(mark.time_s, speed),
                },
                speed,
                fresh,
            });
            fresh = false;
        }
    }
}

/// Whole turns that the twin's count is ahead, so that it covers the stretch: they do not matter to a disc.
fn turns_apart(track: &Track, stretch: &Stretch, twins: &Stretch, pace: &Stretch) -> i64 {
    let firsts = (twins.marks[0].place, pace.marks[0].place);
    let latest = match stretch.direction {
        1 => firsts.0.max(firsts.1),
        _ => firsts.0.min(firsts.1),
    };
    let behind = ((latest - stretch.marks[0].place) * stretch.direction).max(0);
    (behind + track.edges - 1) / track.edges * stretch.direction
}

/// Time at which a stretch passed a place.
fn time_at(stretch: &Stretch, place: i64) -> Option<f64> {
    let at = usize::try_from((place - stretch.marks[0].place) * stretch.direction).ok()?;
    stretch.marks.get(at).map(|mark: &Mark| mark.time_s)
}

/// Speed, rad/s either way, an angle `past_rad` past an edge of a perfect disc's grid. A late edge shows a large angle, so the speed
/// must be exact: it is taken at the very place.
fn speed_at(pace: &Stretch, place: i64, past_rad: f64, reach: Reach) -> Option<f64> {
    let here = time_at(pace, place)?;
    let edges = reach.edges * pace.direction;
    let before = here - time_at(pace, place - edges)?;
    let after = time_at(pace, place + edges)? - here;
    // Through three points: the times of two equal ways.
    let (slow, fast) = (reach.way_rad / before, reach.way_rad / after);
    let speed = 2.0 * slow * fast / (slow + fast);
    let slope = (fast - slow) / reach.way_rad;
    Some(speed + slope * past_rad * pace.direction as f64)
}

/// Edges to either side that a speed is taken over.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Edges: whole lines, and little of a turn.
    pub edges: i64,
    /// The angle they make.
    pub way_rad: f64,
}

impl Reach {
    /// So many edges of so many a turn.
    #[must_use]
    pub fn of(edges: i64, a_turn: i64) -> Self {
        Self {
            edges,
            way_rad: edges as f64 * TAU / a_turn as f64,
        }
    }
}
