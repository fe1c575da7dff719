//! How far a recording is from what its twin would have recorded, edge by edge.
//!
//! The twin is run without any randomness and its edges are compared where they stand on the disc: an edge that came `u` later
//! than the twin's shows the angle -w u, with w the speed, negative in reverse. Everything that the twin declares, its disc, delays, ripple and profile, is in its edges
//! and so is out of the residual; the start and the mean speed, which nobody knows exactly, are left to the noise model.

use std::f64::consts::TAU;

use super::kalman::Reading;
use super::track::{Mark, Stretch, Track};
use crate::sensor::{PlanError, SensorPlan};
use crate::sim::Simulation;
use crate::twin::{Drive, Duration, Errors, Faults, Noise, Twin, TwinError};

/// Edges that a stretch needs to be looked at.
const EDGES_LEAST: usize = 64;

/// The residual of one stretch.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Edges a turn and classes of the disc.
    pub edges: i64,
    /// Edge classes.
    pub classes: i64,
    /// 1 forward, -1 in reverse.
    pub direction: i64,
    /// Where each edge is on the grid.
    pub places: Vec<i64>,
    /// When it came, s.
    pub times_s: Vec<f64>,
    /// Its angle less the twin's, rad.
    pub angles: Vec<f64>,
    /// What the noise model needs of it.
    pub readings: Vec<Reading>,
}

impl Residual {
    /// Angle of an edge on the grid, rad, turns counted through.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn theta(&self, at: usize) -> f64 {
        self.places[at] as f64 * (TAU / self.edges as f64)
    }

    /// Class of an edge.
    #[must_use]
    pub fn class(&self, at: usize) -> usize {
        usize::try_from(self.places[at].rem_euclid(self.classes)).unwrap_or(0)
    }

    /// Mean speed, rad/s, either way.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn mean_speed(&self) -> f64 {
        let steps = (self.places.len().max(2) - 1) as f64;
        let time = self.times_s[self.times_s.len() - 1] - self.times_s[0];
        steps * TAU / self.edges as f64 / time
    }
}

/// The residuals of a recording's stretches, the short ones left out.
///
/// # Errors
/// [`TwinError`] where the twin can't be run.
pub fn residuals(track: &Track, plan: SensorPlan, twin: &Twin) -> Result<Vec<Residual>, TwinError> {
    let still = still_twin(track, twin);
    let (twins, errors) = simulated(plan, &still)?;
    // A perfect disc on the same shaft, for the speed.
    let perfect = Twin {
        errors: Errors::default(),
        edge_delay: None,
        channel_skew: None,
        ..still
    };
    let (perfect, _) = simulated(plan, &perfect)?;
    let recorded = track.stretches.iter();
    Ok(recorded
        .filter(|stretch| stretch.marks.len() >= EDGES_LEAST)
        .filter_map(|stretch| {
            let pace = Pace {
                marks: &nearest(&perfect, stretch)?.marks,
                direction: stretch.direction,
                reach: reach(track),
                step_rad: step_rad(track),
            };
            compare(track, stretch, nearest(&twins, stretch)?, &pace, &errors)
        })
        .collect())
}

/// Stretches of a twin's edges, and the errors of its disc.
fn simulated(plan: SensorPlan, twin: &Twin) -> Result<(Vec<Stretch>, Vec<f64>), TwinError> {
    let simulation = Simulation::new(twin)?;
    let errors = simulation.true_errors();
    let rows = simulation.map(|event| Ok::<_, PlanError>(event.row));
    let track = Track::of(plan, twin.timer.clock_hz, rows);
    // The plan has decoded the recording, so it decodes this.
    Ok((
        track.map_or_else(|_| Vec::new(), |track| track.stretches),
        errors,
    ))
}

#[allow(clippy::cast_precision_loss)]
fn step_rad(track: &Track) -> f64 {
    TAU / track.edges as f64
}

/// Speed of the twin's shaft along its way.
struct Pace<'a> {
    /// Edges of a perfect disc.
    marks: &'a [Mark],
    direction: i64,
    reach: usize,
    step_rad: f64,
}

impl Pace<'_> {
    /// Speed, rad/s either way, an angle `past_rad` past an edge of the grid. A late edge shows a large angle, so the speed must be
    /// exact: it is taken at the very place.
    #[allow(clippy::cast_precision_loss)]
    fn at(&self, place: i64, past_rad: f64) -> Option<f64> {
        let at = usize::try_from((place - self.marks.first()?.place) * self.direction).ok()?;
        let time = |at: usize| self.marks.get(at).map(|mark| mark.time_s);
        let here = time(at)?;
        let before = here - time(at.checked_sub(self.reach)?)?;
        let after = time(at + self.reach)? - here;
        // Through three points: the times of two equal ways.
        let way = self.reach as f64 * self.step_rad;
        let (slow, fast) = (way / before, way / after);
        let speed = 2.0 * slow * fast / (slow + fast);
        let slope = (fast - slow) / way;
        Some(speed + slope * past_rad * self.direction as f64)
    }
}

/// The twin without randomness, with time stamps as good as exact, at the recording's mean speed where it is to hold one.
fn still_twin(track: &Track, twin: &Twin) -> Twin {
    const FINE_HZ: u64 = 1_000_000_000_000;
    let mut still = twin.clone();
    // A wander also says how strongly the drive holds the speed, which stays.
    still.noise = still.noise.and_then(|noise| match noise {
        Noise::SpeedWander {
            correlation_rad,
            hold_s,
            ..
        } => Some(Noise::SpeedWander {
            rms_fraction: 1e-30,
            correlation_rad,
            hold_s,
        }),
        _ => None,
    });
    still.faults = Faults::default();
    still.timer.jitter_s = 0.0;
    still.timer.clock_hz = FINE_HZ;
    still.timer.bits = 64;
    still.timer.raw_captures = false;
    if let (Drive::Constant { r_min }, Some(longest)) = (&mut still.drive, track.longest()) {
        *r_min = mean_r_min(track, longest);
    }
    #[allow(clippy::cast_precision_loss)]
    let turns: f64 = track
        .stretches
        .iter()
        .map(|stretch| stretch.marks.len() as f64 / track.edges as f64)
        .sum();
    still.duration = match still.duration {
        // Before the index nothing has a place.
        Duration::Turns(declared) => Duration::Turns(declared.max(turns) * 1.02 + 3.0),
        Duration::Seconds(declared) => {
            let last = track.stretches.iter().filter_map(|s| s.marks.last());
            let end = last.map(|mark| mark.time_s).fold(declared, f64::max);
            Duration::Seconds(end * 1.05)
        }
    };
    still
}

#[allow(clippy::cast_precision_loss)]
fn mean_r_min(track: &Track, stretch: &Stretch) -> f64 {
    let marks = &stretch.marks;
    let (first, last) = (marks[0], marks[marks.len() - 1]);
    let turns = (last.place - first.place) as f64 / track.edges as f64;
    60.0 * turns / (last.time_s - first.time_s)
}

/// The simulated stretch in the same direction that is on its way at about the same time.
fn nearest<'a>(simulated: &'a [Stretch], stretch: &Stretch) -> Option<&'a Stretch> {
    let middle = |stretch: &Stretch| stretch.marks[stretch.marks.len() / 2].time_s;
    simulated
        .iter()
        .filter(|twins| twins.direction == stretch.direction && twins.marks.len() >= EDGES_LEAST)
        .min_by(|a, b| {
            let off = |twins: &Stretch| (middle(twins) - middle(stretch)).abs();
            off(a).total_cmp(&off(b))
        })
}

#[allow(clippy::cast_precision_loss)]
fn compare(
    track: &Track,
    stretch: &Stretch,
    twins: &Stretch,
    pace: &Pace<'_>,
    errors: &[f64],
) -> Option<Residual> {
    let first_twin = twins.marks[0].place;
    let first_pace = pace.marks.first()?.place;
    // Whole turns between the counts do not matter to a disc.
    let latest = match stretch.direction {
        1 => first_twin.max(first_pace),
        _ => first_twin.min(first_pace),
    };
    let behind = ((latest - stretch.marks[0].place) * stretch.direction).max(0);
    let turns = (behind + track.edges - 1) / track.edges;
    let shift = turns * track.edges * stretch.direction;
    let mut residual = Residual {
        edges: track.edges,
        classes: track.classes,
        direction: stretch.direction,
        places: Vec::new(),
        times_s: Vec::new(),
        angles: Vec::new(),
        readings: Vec::new(),
    };
    let mut first_late = None;
    for mark in &stretch.marks {
        let place = mark.place + shift;
        let at = usize::try_from((place - first_twin) * stretch.direction).ok()?;
        let edge = usize::try_from(place.rem_euclid(track.edges)).ok()?;
        let (Some(here), Some(speed)) = (twins.marks.get(at), pace.at(place, -errors[edge])) else {
            continue;
        };
        let lateness = mark.time_s - here.time_s;
        let lateness = lateness - *first_late.get_or_insert(lateness);
        let after_s = residual
            .times_s
            .last()
            .map_or(0.0, |last| mark.time_s - last);
        residual.places.push(mark.place);
        residual.times_s.push(mark.time_s);
        residual
            .angles
            .push(-speed * stretch.direction as f64 * lateness);
        residual.readings.push(Reading { after_s, speed });
    }
    (residual.places.len() >= EDGES_LEAST).then_some(residual)
}

/// Edges to either side that a speed is taken over: whole lines, and little of a turn.
fn reach(track: &Track) -> usize {
    let lines = (track.edges / track.classes / 500).max(1);
    usize::try_from(lines * track.classes).unwrap_or(1)
}
