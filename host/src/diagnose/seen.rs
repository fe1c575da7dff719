//! How far a recording is from what its twin would have recorded, edge by edge.
//!
//! The angle of each edge on the disc is compared with the angle of the twin's shaft at the same time (see [`super::turning`]), so an
//! angle is positive where the shaft, or the mark on it, is ahead. Everything that the twin declares, its disc, delays, ripple and
//! profile, is out of the residual; the mean speed, which nobody knows exactly, and the start are taken from the recording.

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use super::kalman::Reading;
use super::run_out::RunOuts;
use super::shaft::{ShaftLaw, Stride};
use super::still::Still;
use super::swing::Torques;
use super::ties::Tie;
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
    /// Errors of the disc that are known, rad, for every edge of the grid: the twin's, and what was learned since.
    pub errors: Vec<f64>,
    /// How much further along the twin's marks lie forward than in reverse, rad.
    pub(super) play_rad: f64,
    /// Where each edge is on the grid, turns counted through.
    pub places: Vec<i64>,
    /// When it came, s.
    pub times_s: Vec<f64>,
    /// Speed of the twin there without its swing, rad/s, negative in reverse.
    pub speeds: Vec<f64>,
    /// Acceleration of the twin's shaft over the interval before it, rad/s^2.
    pub(super) bends: Vec<f64>,
    /// Variance of the speed that friction makes over the interval before it against the twin's way, (rad/s)^2.
    pub(super) rubbed: Vec<f64>,
    /// Its angle less the twin's, rad.
    pub angles: Vec<f64>,
    /// What the noise model needs of it.
    pub readings: Vec<Reading>,
    /// Whether the shaft is pushed now and then by what the twin does not have (see [`super::pushed`]).
    pub pushed: bool,
    /// Speed below which the twin's ripple may send the shaft to and fro, rad/s.
    pub(super) slow: f64,
    /// Samples of a speed loop that may have seen an edge or not.
    pub ties: Vec<Tie>,
    /// By how much the comparators' levels move each edge, rad; empty before they are taken off.
    pub(super) level_off: Vec<f64>,
    /// The twin's run-outs, and by how much they move each edge, rad; empty where there are none.
    pub(super) run_outs: RunOuts,
    pub(super) run_off: Vec<f64>,
    /// The twin's torques, and the angles that they give, rad.
    pub(super) torques: Torques,
    pub(super) swings: Vec<f64>,
    /// Speeds that they give, rad/s; empty where `speeds` was measured.
    pub(super) swung: Vec<f64>,
    /// The speed that the shaft really has at each edge, rad/s (see [`super::pace`]).
    pub(super) pace: Vec<f64>,
    /// Whether `speeds` is the recording's own in place of the twin's.
    pub(super) measured: bool,
    /// The play that leaves the smoothest motion, rad, once it was asked for; worked out by one thread alone.
    pub(super) smoothest: OnceLock<f64>,
    /// How the shaft goes over the interval before each edge, once it was asked for.
    pub(super) strides: OnceLock<Arc<Vec<Stride>>>,
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
        if track.anchored {
            seen.take_off(twin, &law);
        } else {
            seen.align(twin, &law);
        }
        Ok(seen)
    }

    /// Without an index the start says which edge is the first, give or take a line: what the twin knows of the turn fits best where
    /// it belongs.
    fn align(&mut self, twin: &Twin, law: &ShaftLaw) {
        const LINES: i64 = 3;
        // Evidence that moves the start, as a difference of logarithms of likelihood.
        const SURE: f64 = 15.0;
        let moved = |lines: i64| {
            let mut moved = self.clone();
            moved.shift_by(lines * self.classes);
            moved.take_off(twin, law);
            moved
        };
        let here = moved(0);
        let usual = here.roughness();
        let turned = twin.ripple.len() + twin.gear_mesh.len() + twin.bearing.len() > 0;
        if !turned && self.errors.iter().all(|error| *error == 0.0) {
            *self = here;
            return;
        }
        let others = (-LINES..=LINES).filter(|lines| *lines != 0).map(moved);
        let best = others.min_by(|a, b| a.roughness().total_cmp(&b.roughness()));
        *self = match best {
            Some(best) if 0.5 * self.len() as f64 * (usual / best.roughness()).ln() > SURE => best,
            _ => here,
        };
    }

    /// Moves the count of edges against the disc.
    fn shift_by(&mut self, edges: i64) {
        let error = |place: i64| {
            let edge = (place - self.shift).rem_euclid(self.edges);
            self.errors.get(edge as usize).copied().unwrap_or(0.0)
        };
        let moves: Vec<f64> = self
            .places
            .iter()
            .map(|place| error(*place) - error(*place + edges))
            .collect();
        for ((angle, place), by) in self.angles.iter_mut().zip(&mut self.places).zip(moves) {
            *angle += by;
            *place += edges;
        }
    }

    /// Sum of squares by which edges are off the straight way between their neighbours: a speed that is off does not show.
    fn roughness(&self) -> f64 {
        let off = |at: usize| {
            let (before, after) = (self.times_s[at - 1], self.times_s[at + 1]);
            let share = (self.times_s[at] - before) / (after - before).max(f64::MIN_POSITIVE);
            self.angles[at] - (1.0 - share) * self.angles[at - 1] - share * self.angles[at + 1]
        };
        let whole = (1..self.len().saturating_sub(1)).filter(|at| {
            // Where it turns round or the count was lost, neighbours are none; a swing to and fro is rougher than any disc.
            self.places[at + 1].abs_diff(self.places[at - 1]) == 2
                && self.speeds[*at].abs() >= self.slow
        });
        whole.map(off).map(|off| off * off).sum()
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

    /// True angle of an edge as the twin's disc and its run-out have it, rad.
    #[must_use]
    pub fn true_theta(&self, at: usize) -> f64 {
        self.mark_theta(at) - self.run_off.get(at).copied().unwrap_or(0.0)
    }

    /// The same without the run-out.
    #[must_use]
    pub(super) fn mark_theta(&self, at: usize) -> f64 {
        let error = self.errors.get(self.edge(at)).copied().unwrap_or(0.0);
        let level = self.level_off.get(at).copied().unwrap_or(0.0);
        self.theta(at) - error - level + self.play_rad * self.side(at)
    }

    /// Half of the way it goes at an edge: 0.5 forward, -0.5 in reverse.
    #[must_use]
    pub fn side(&self, at: usize) -> f64 {
        0.5_f64.copysign(self.speeds[at])
    }

    /// Speed of the shaft at an edge, rad/s: what a delay makes of the angle.
    #[must_use]
    pub fn true_speed(&self, at: usize) -> f64 {
        self.pace.get(at).copied().unwrap_or(self.speeds[at])
    }

    /// Whether it goes both ways.
    #[must_use]
    pub fn reverses(&self) -> bool {
        let [low, high] = self.speed_range();
        low < 0.0 && high > 0.0
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

    /// How the shaft goes over the interval before each edge.
    #[must_use]
    pub fn strides(&self) -> &[Stride] {
        let strides = || self.readings.iter().map(|reading| reading.leap.stride());
        self.strides.get_or_init(|| Arc::new(strides().collect()))
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

    /// How far the shaft gets ahead of the twin's or behind it, rad, less what goes on evenly from the first edge to the last.
    #[must_use]
    pub fn astray_rad(&self) -> f64 {
        let (Some(first), Some(last)) = (self.angles.first(), self.angles.last()) else {
            return 0.0;
        };
        let (begin_s, seconds) = (self.times_s[0], self.seconds().max(f64::MIN_POSITIVE));
        let each = self.angles.iter().zip(&self.times_s);
        each.map(|(angle, time)| {
            (angle - first - (last - first) * (time - begin_s) / seconds).abs()
        })
        .fold(0.0, f64::max)
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
