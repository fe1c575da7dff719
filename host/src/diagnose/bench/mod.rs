//! A recording beside its twin: the residual, its noise, and the filter that makes both white.

mod ties;

use std::sync::Arc;

use super::columns::{Columns, Kept};
use super::corners::Corner;
use super::course::Course;
use super::declared::{self, Declared};
use super::effect::{Effect, Scene, Site};
use super::filter::Noise;
use super::held_up::{self, Task};
use super::lsq;
use super::noise::{self, Free, Rest, Tails};
use super::plant::{Gains, Hold, Jolt, Law, Leaps, Motion, Plant};
use super::record::Record;
use super::speed_loop::Unsaid;
use super::spread::Spread;
use crate::sim;
use crate::twin::{Drive, Twin, TwinError};

/// Torques with their sizes.
pub type Torques = Vec<(Effect, Vec<f64>)>;

/// What was found of a rig that bears on its course and its law.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// By how much each edge is off on top of what the twin says, rad; empty where none is.
    pub off: Vec<f64>,
    /// How much later each stamp is than the twin says, s; empty where none is.
    pub late_s: Vec<f64>,
    /// How an unknown drive holds the shaft.
    pub hold: Hold,
    /// The speed loop that drives it, where the twin says nothing of a drive.
    pub speed_loop: Option<Unsaid>,
    /// Torques once or several times a turn, with their sizes.
    pub torques: Torques,
    /// Corners of the speed of a drive of which the twin says nothing.
    pub corners: Vec<Corner>,
}

/// One recording with its twin.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Its place among the rig's recordings.
    pub place: u8,
    /// The edges.
    pub record: Record,
    /// The twin.
    pub twin: Twin,
    /// Errors of its disc as the recording counts edges, rad.
    pub disc: Vec<f64>,
    /// How sure that disc is.
    pub spread: Spread,
    /// What the course and the law go by that the twin does not say.
    pub found: Found,
    /// Where the shaft was.
    pub course: Course,
    /// Its law.
    pub plant: Plant,
    /// What the twin says of each edge.
    pub declared: Declared,
    /// The filter's steps: many, and the same in any noise.
    pub leaps: Arc<Leaps>,
    /// The gains for the present noise.
    pub gains: Gains,
    /// 1 / deviation of each innovation, 1/rad.
    pub scales: Vec<f64>,
    /// Weight of each edge: less where the noise is more.
    pub weights: Vec<f64>,
    /// Weight of each edge on top: less where it is far out of noise with long tails.
    pub tails: Vec<f64>,
    /// Grid angles less all that the twin says, rad.
    pub own: Vec<f64>,
    /// The same as far as the twin was given: numbers that are corrected count as declared.
    pub residual: Vec<f64>,
    /// What unit of each correction does to each edge, rad; empty where the twin does not declare it.
    pub tangents: Vec<Vec<f64>>,
    /// What ties of a speed loop decided the other way do to each edge, rad; empty without a loop.
    tied: Vec<f64>,
    /// The present noise.
    noise: Noise,
    /// Columns along this course.
    pub kept: Kept,
}

impl Bench {
    /// Compares a recording with its twin.
    pub fn new(record: Record, twin: &Twin, errors: &[f64], noise: &Noise) -> Self {
        Self::about(record, twin, errors, &Found::default(), noise)
    }

    /// The same about what was found of its course and its law.
    fn about(
        mut record: Record,
        twin: &Twin,
        errors: &[f64],
        found: &Found,
        noise: &Noise,
    ) -> Self {
        let disc = record.pick(errors);
        let law = Law::of(twin).held(found.hold);
        let mut off = record.shown(&disc);
        lsq::add(&mut off, 1.0, &found.off);
        held_up::release(&mut record, &off);
        let mut course = Course::new(&record, &off);
        let mut plant = Plant::new(law.clone(), &course);
        let looped = found.speed_loop.as_ref();
        let mut declared = Declared::new(&record, twin, looped, &disc, &course, &plant);
        // Once more about the course without what shifts edges, as torques bend it.
        off.clone_from(&declared.off);
        lsq::add(&mut off, 1.0, &found.off);
        held_up::release(&mut record, &off);
        let scene = Scene {
            record: &record,
            disc: &disc,
            course: &course,
            plant: &plant,
            asked: &declared::Asked::of(twin),
        };
        let known = bent(&scene, found, &declared.response);
        course = Course::bent(&record, &off, &known);
        course.late_s = declared::late_s(twin, &record);
        lsq::add(&mut course.late_s, 1.0, &found.late_s);
        plant = Plant::new(law, &course);
        declared = Declared::new(&record, twin, looped, &disc, &course, &plant);
        let leaps = leaps(twin, found, &course, &plant);
        let gains = leaps.filter(0..record.len(), noise);
        let own = unsaid(&record, &declared);
        Self {
            scales: gains.scales(),
            weights: vec![1.0; record.len()],
            tails: vec![1.0; record.len()],
            tied: vec![0.0; record.len()],
            twin: twin.clone(),
            place: 0,
            record,
            disc,
            spread: Spread::default(),
            found: found.clone(),
            course,
            plant,
            declared,
            leaps,
            gains,
            residual: own.clone(),
            own,
            tangents: Vec::new(),
            noise: *noise,
            kept: Kept::default(),
        }
    }

    /// Whether a drive that the twin declares holds a speed.
    pub fn is_held(&self) -> bool {
        let law = &self.plant.law;
        self.twin.drive != Drive::Unknown && law.stiffness + law.viscous > 0.0
    }

    /// The present noise.
    pub const fn noise(&self) -> Noise {
        self.noise
    }

    /// Goes by a torque noise that is held for a time, s; its gains are set with the noise.
    pub fn hold_noise(&mut self, hold_s: f64) {
        self.plant.law.hold_s = hold_s;
        self.leaps = leaps(&self.twin, &self.found, &self.course, &self.plant);
    }

    /// Goes by a drive whose speed has these corners.
    pub fn bend(&mut self, corners: Vec<Corner>) {
        self.found.corners = corners;
        self.leaps = leaps(&self.twin, &self.found, &self.course, &self.plant);
        let noise = self.noise;
        self.set_noise(&noise);
    }

    /// Goes by another noise.
    pub fn set_noise(&mut self, noise: &Noise) {
        self.noise = *noise;
        self.gains = self.leaps.filter(0..self.record.len(), noise);
        self.scales = self.gains.scales();
    }

    /// The same of its record as it is now, beside a twin whose disc has these errors and in a noise: what goes by them is worked out
    /// anew, about what was found.
    #[must_use]
    pub fn anew(&self, twin: &Twin, errors: &[f64], noise: &Noise) -> Self {
        let mut other = Self::about(self.record.clone(), twin, errors, &self.found, noise);
        other.stays(self);
        other
    }

    /// Takes other edges of its recording, until all is worked out anew.
    pub fn take(&mut self, record: Record) {
        self.found.off.clear();
        self.found.late_s.clear();
        self.weights = vec![1.0; record.len()];
        self.tails.clone_from(&self.weights);
        self.record = record;
    }

    /// The same along other edges of its recording.
    ///
    /// # Errors
    /// [`TwinError`] for a disc that can't be.
    pub fn along(&self, record: Record) -> Result<Self, TwinError> {
        let mut other = self.clone();
        other.take(record);
        Ok(other.anew(&self.twin, &sim::true_errors(&self.twin)?, &self.noise))
    }

    /// Counts edges of the disc from another one of it on, so many before the present first one.
    ///
    /// # Errors
    /// [`TwinError`] for a disc that can't be.
    pub fn turn(&mut self, by: i64) -> Result<(), TwinError> {
        let errors = sim::true_errors(&self.twin)?;
        self.record.place.iter_mut().for_each(|place| *place += by);
        *self = self.anew(&self.twin, &errors, &self.noise);
        Ok(())
    }

    /// The same where a task holds edges up, or none does.
    #[must_use]
    pub fn held_up_by(&self, task: Option<Task>, noise: &Noise) -> Option<Self> {
        let mut other = self.clone();
        let (twin, record) = (&mut other.twin, &mut other.record);
        twin.capture_latency = task.map(Task::declared);
        held_up::restore(record);
        let near_s = twin.timer.jitter_s.max(noise.stamp_s).hypot(record.tick_s);
        record.held = task.map_or_else(Vec::new, |task| task.held(&record.time_s, near_s));
        let errors = sim::true_errors(&other.twin).ok()?;
        Some(other.anew(&other.twin, &errors, noise))
    }

    /// Sum of what the course within the intervals leaves open of the speed beside torques, rad/s.
    pub fn open(&self, torques: &Torques) -> f64 {
        let jolts = jolts(&self.twin, torques, &self.course, &self.plant);
        let unseen = self.noise.unseen;
        let each = jolts.iter();
        each.map(|jolt| jolt.known[1].abs().max(unseen * jolt.unseen))
            .sum()
    }

    /// Angles that torques which are held from sample to sample make of a shaft that nothing else pushes, rad.
    pub fn sampled(&self, rate_hz: f64, samples: &[f64]) -> Vec<f64> {
        let asked = declared::Asked::of(&self.twin);
        let motions = declared::sampled(rate_hz, samples, &self.scene(&asked));
        motions.iter().map(|[angle, _]| *angle).collect()
    }

    fn scene<'a>(&'a self, asked: &'a declared::Asked) -> Scene<'a> {
        Scene {
            record: &self.record,
            disc: &self.disc,
            course: &self.course,
            plant: &self.plant,
            asked,
        }
    }

    /// Keeps what of the same recording does not change with its twin or its course.
    fn stays(&mut self, before: &Self) {
        self.place = before.place;
        self.spread.clone_from(&before.spread);
        self.weights.clone_from(&before.weights);
        self.tails.clone_from(&before.tails);
    }

    /// Weighs each edge by the level of the noise about it, as residual angles show it.
    pub fn level(&mut self, rest: &[f64]) {
        let mut white = rest.to_vec();
        self.gains.whiten(&mut white);
        let levels = noise::levels(&white, self.record.edges as usize);
        self.weights = levels.iter().map(|level| level.recip()).collect();
    }

    /// Weighs each edge by how far out it is, as residual angles show it.
    pub fn weigh(&mut self, rest: &[f64], tails: Tails) {
        let mut white = rest.to_vec();
        self.gains.whiten(&mut white);
        let each = white.iter_mut().zip(&self.weights);
        each.for_each(|(white, weight)| *white *= weight);
        self.tails = tails.weights(&white);
    }

    /// Takes off residual angles what an unknown start makes of them: angle, speed and how that fades.
    pub fn less_start(&self, rest: &mut [f64]) {
        let times = &self.record.time_s;
        let line: Vec<f64> = times.iter().map(|time| time - times[0]).collect();
        let fades = self.plant.fading(&self.course);
        let fades: Vec<f64> = fades.iter().map(|[angle, _]| *angle).collect();
        let one = vec![1.0; rest.len()];
        let solved = lsq::solve(&[&one, &line, &fades], rest);
        rest.copy_from_slice(&solved.left);
    }

    /// Takes errors of the disc's edges off angles.
    pub fn less_errors(&self, angles: &mut [f64], errors: &[f64]) {
        lsq::add(angles, -1.0, &self.record.shown(errors));
    }

    /// Residual angles that rounding to ticks alone would leave, had the shaft gone as the filter has it beside a residual.
    pub fn rounded(&self, rest: &[f64], stamp_s: f64) -> Vec<f64> {
        // Errors of the stamps as smoothed: R S^-1 y.
        let mut scores = rest.to_vec();
        self.gains.whiten(&mut scores);
        self.gains.transposed(&mut scores);
        let each = scores.iter().zip(&self.record.time_s);
        each.zip(&self.course.speed)
            .map(|((score, time_s), speed)| {
                let error_s = speed * stamp_s * stamp_s * score;
                let ticks = (time_s + error_s) / self.record.tick_s;
                speed * self.record.tick_s * (ticks - ticks.round())
            })
            .collect()
    }

    /// The residual beside a changed twin, about the same course; none where there is no such twin. A change that bears on how the shaft
    /// answers changes the filter too: these are the angles whose innovations by the present filter are those of the changed one.
    pub fn beside(&self, twin: &Twin) -> Option<Vec<f64>> {
        let same_disc =
            twin.errors == self.twin.errors && twin.local_defect == self.twin.local_defect;
        let disc = if same_disc {
            self.disc.clone()
        } else {
            self.record.pick(&sim::true_errors(twin).ok()?)
        };
        let law = Law::of(twin).held(self.found.hold);
        let other = (law != self.plant.law).then(|| Plant::new(law, &self.course));
        let plant = other.as_ref().unwrap_or(&self.plant);
        let looped = self.found.speed_loop.as_ref();
        let declared = Declared::new(&self.record, twin, looped, &disc, &self.course, plant);
        let mut rest = unsaid(&self.record, &declared);
        lsq::add(&mut rest, -1.0, &self.tied);
        if let Some(plant) = &other {
            let leaps = leaps(twin, &self.found, &self.course, plant);
            let gains = leaps.filter(0..rest.len(), &self.noise);
            gains.whiten(&mut rest);
            let scales = gains.scales().into_iter().zip(&self.scales);
            for (white, (theirs, own)) in rest.iter_mut().zip(scales) {
                *white = match theirs > 0.0 {
                    true => *white * own / theirs,
                    false => 0.0,
                };
            }
            self.gains.colour(&mut rest);
        }
        rest.iter().all(|rest| rest.is_finite()).then_some(rest)
    }

    /// A row of angles, white and weighed.
    pub fn white(&self, angles: &[f64]) -> Vec<f64> {
        self.white_rows(vec![angles.to_vec()]).swap_remove(0)
    }

    /// Rows of angles, white and weighed.
    pub fn white_rows(&self, mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        self.gains.whiten_rows(&mut rows);
        rows.iter_mut().for_each(|row| self.weighed(row));
        rows
    }

    /// The transposed of [`Self::white`].
    pub fn score(&self, white: &[f64]) -> Vec<f64> {
        self.score_rows(vec![white.to_vec()]).swap_remove(0)
    }

    /// The transposed of [`Self::white_rows`].
    pub fn score_rows(&self, mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        rows.iter_mut().for_each(|row| self.weighed(row));
        self.gains.transposed_rows(&mut rows);
        rows
    }

    /// A sum that another noise has otherwise, or other weights.
    pub fn mark(&self) -> f64 {
        let each = self.scales.iter().zip(&self.weights).zip(&self.tails);
        each.map(|((scale, weight), tail)| scale * weight * tail)
            .sum()
    }

    /// A row times the weights of edges.
    fn weighed(&self, row: &mut [f64]) {
        let weights = self.weights.iter().zip(&self.tails);
        let each = row.iter_mut().zip(weights);
        each.for_each(|(value, (weight, tail))| *value *= weight * tail);
    }

    /// What an effect does to each edge, rad, for unit of each size.
    pub fn columns(&self, effect: &Effect) -> Columns {
        if let Site::Declared(at) = effect.site {
            let tangent = self.tangents.get(usize::from(at)).cloned();
            let none = vec![0.0; self.record.len()];
            return vec![tangent.filter(|some| !some.is_empty()).unwrap_or(none)].into();
        }
        self.kept.of(effect, || {
            if effect.only.is_some_and(|only| only != self.place) {
                return vec![vec![0.0; self.record.len()]; effect.sizes()];
            }
            let asked = declared::Asked::of(&self.twin);
            effect.columns(&self.scene(&asked))
        })
    }
}

/// Grid angles less all that a twin says, rad.
fn unsaid(record: &Record, declared: &Declared) -> Vec<f64> {
    let each = 0..record.len();
    each.map(|at| record.grid_rad(at) - declared.off[at] - declared.response[at][0])
        .collect()
}

/// How the shaft goes from the speed that it starts with, pushed by torques that the twin declares and those that were found.
fn bent(scene: &Scene<'_>, found: &Found, declared: &[Motion]) -> Vec<Motion> {
    let mut motions = declared.to_vec();
    let start = scene.course.speed.first().copied().unwrap_or(0.0);
    let fading = scene.plant.fading(scene.course);
    for (motion, fading) in motions.iter_mut().zip(fading) {
        lsq::add(motion, start, &fading);
    }
    for (effect, sizes) in &found.torques {
        declared::push(&mut motions, scene, effect, sizes);
    }
    motions
}

/// What torques leave open of the course within intervals: those that the twin declares and those that were found.
fn jolts(twin: &Twin, found: &Torques, course: &Course, plant: &Plant) -> Vec<Jolt> {
    let all = declared::effects(twin);
    let waves = all.iter().chain(found);
    let waves = waves.filter_map(|(effect, sizes)| declared::wave(effect, sizes, &plant.law));
    declared::jolts(&waves.collect::<Vec<_>>(), course, plant)
}

/// The filter's steps, with what the course leaves open.
fn leaps(twin: &Twin, found: &Found, course: &Course, plant: &Plant) -> Arc<Leaps> {
    let mut leaps = Leaps::of(plant, course);
    leaps.jolt(&jolts(twin, &found.torques, course, plant));
    leaps.bend(&found.corners, &course.time_s);
    Arc::new(leaps)
}

/// The noise that fits several benches best beside residual angles.
pub fn fit_noise(benches: &[Bench], rest: &[Vec<f64>], start: Noise, free: Free) -> (Noise, f64) {
    let ticks = benches.iter().map(|bench| bench.record.tick_s);
    let tick_s = ticks.fold(0.0, f64::max);
    noise::fit(&rests(benches, rest), tick_s / 12_f64.sqrt(), start, free)
}

/// The part of a row of all recordings that is of each.
pub fn parts<'a>(
    benches: &'a [Bench],
    mut row: &'a [f64],
) -> impl Iterator<Item = (&'a Bench, &'a [f64])> {
    benches.iter().map(move |bench| {
        let own = row.split_off(..bench.record.len());
        (bench, own.unwrap_or_default())
    })
}

/// Residual angles with what the likelihood of their noise needs.
pub fn rests<'a>(benches: &'a [Bench], rest: &'a [Vec<f64>]) -> Vec<Rest<'a>> {
    let each = benches.iter().zip(rest);
    each.map(|(bench, rest)| Rest {
        leaps: &bench.leaps,
        angles: rest,
        weights: &bench.weights,
    })
    .collect()
}
