//! The ideal detector: what size of an effect could be told from noise at all.
//!
//! It knows everything but whether the effect is there: its shape, the spectrum of the torque noise, the size of the stamps'
//! error. Then the best that can be done is a matched filter. Its signal is the difference, edge by edge, of the noiseless times
//! with and without the effect, in rad; divided by the true noise (see [`crate::whiten`]) its length is d', the distance of the
//! two hypotheses in standard deviations. What no one knows beforehand is taken out of the signal first, by least squares in the
//! whitened signal: an offset of the angle, the mean speed, and the disc's whole pattern where the twin does not give it. The size
//! that the ideal detector needs is the one with d' = 5.
//!
//! Where an effect has look-alikes, their signals of any size are taken out as well: the d' that is left says how surely the
//! recordings tell it from them.
//!
//! Effects that add no signal but variance have d' from the Fisher information of the innovations' variances; what comes in whole
//! counts (lost edges, glitches, an index that slips) needs one.

mod alike;
mod project;
#[cfg(test)]
mod tests;
mod variance;

use std::borrow::Cow;
use std::collections::HashMap;

use crate::capture::arrivals;
use crate::effect::Effect;
use crate::rig::{Profile, Rig};
use crate::turning::{Course, turn_evenly};
use crate::whiten::{Edge, Whitener};

/// d' at which an effect counts as detectable.
pub const DETECTABLE: f64 = 5.0;

/// Way at either end of a run that is left out, rad: as far as an effect moves an edge.
const END_RAD: f64 = 0.06;

/// Edges at the end of a run that say how it would go on.
const SLOPE: usize = 40;

/// What the ideal detector has of one recording: base run without noise, and the noise's filter.
pub(crate) struct Sight {
    course: Course,
    /// Times and speeds of a run without ripples.
    course_speed: Vec<(f64, f64)>,
    times: Vec<f64>,
    pub(crate) whitener: Whitener,
    /// Which of the base run's crossings are edges.
    edges: Vec<usize>,
    /// How often the place of each was passed before.
    visit: Vec<u32>,
    /// Edge of the turn, for each.
    pub(crate) k: Vec<usize>,
    /// Time of each.
    pub(crate) time: Vec<f64>,
    /// Shaft angle of each, rad.
    pub(crate) angle: Vec<f64>,
    pub(crate) speed: Vec<f64>,
    pub(crate) noise: Vec<Edge>,
    pub(crate) density: f64,
}

/// The ideal detector for the recordings of a rig.
pub struct Ideal<'a> {
    rigs: Cow<'a, [Rig]>,
    sights: Vec<Sight>,
}

impl<'a> Ideal<'a> {
    /// The detector; runs each rig once without effects and noise.
    #[must_use]
    pub fn new(rigs: &'a [Rig]) -> Self {
        let mut rigs = Cow::Borrowed(rigs);
        if rigs
            .iter()
            .any(|rig| matches!(rig.profile, Profile::Loop { .. }))
        {
            // Which interval a sample sees hangs on a hair, so on a rough disc the answer of a loop to a small effect is not small.
            // An even disc shows the answer that a signal has on average.
            for rig in rigs.to_mut() {
                rig.disc_rad.fill(0.0);
            }
        }
        Self {
            sights: rigs.iter().map(Sight::new).collect(),
            rigs,
        }
    }

    /// d' of an effect.
    #[must_use]
    pub fn distance(&self, effect: &Effect) -> f64 {
        if let Some(distance) = variance::distance(effect, &self.rigs, &self.sights) {
            return distance;
        }
        project::length(&self.residual(effect))
    }

    /// d' that is left of an effect when its look-alikes, of any size, have explained what they can: how surely its name is the
    /// right one. None where it has no look-alike that moves edges as it does.
    #[must_use]
    pub fn separation(&self, effect: &Effect) -> Option<f64> {
        let others = alike::look_alikes(effect, &self.rigs);
        if others.is_empty() {
            return None;
        }
        let mut signal = self.residual(effect);
        let others = others.iter().map(|other| self.residual(other)).collect();
        project::take_out(&mut signal, others);
        Some(project::length(&signal))
    }

    fn residual(&self, effect: &Effect) -> Vec<f64> {
        let signals: Vec<Vec<f64>> = (self.rigs.iter().zip(&self.sights))
            .map(|(rig, sight)| sight.signal(rig, effect))
            .collect();
        project::residual(&self.rigs, &self.sights, &signals)
    }

    /// RMS by which an effect moves the edges, rad, in the recording where it moves them most.
    #[must_use]
    pub fn rms(&self, effect: &Effect) -> f64 {
        let each = self.rigs.iter().zip(&self.sights).map(|(rig, sight)| {
            let signal = sight.signal(rig, effect);
            let mean = signal.iter().sum::<f64>() / signal.len() as f64;
            let sum: f64 = signal.iter().map(|s| (s - mean) * (s - mean)).sum();
            (sum / signal.len() as f64).sqrt()
        });
        each.fold(0.0, f64::max)
    }

    /// The factor on an effect's size that makes it just detectable; none where no size does.
    #[must_use]
    pub fn factor(&self, effect: &Effect) -> Option<f64> {
        if effect.size() == 0.0 {
            // Counted, not sized.
            return Some(1.0);
        }
        let mut factor = 1.0;
        // Signals are close to linear in size: a few secant steps through 0 settle what is not.
        for _ in 0..6 {
            let distance = self.distance(&effect.scaled(factor));
            if !(distance.is_finite() && distance > 0.0) {
                return None;
            }
            // Variance goes as the square of a size.
            let power = if is_variance(effect) { 0.5 } else { 1.0 };
            let more = (DETECTABLE / distance).powf(power);
            factor *= more.clamp(1e-4, 1e4);
            if (more - 1.0).abs() < 1e-3 {
                return Some(factor);
            }
        }
        Some(factor)
    }
}

impl Sight {
    fn new(rig: &Rig) -> Self {
        let course = turn_evenly(rig, &[]);
        let calm = Rig {
            ripples: Vec::new(),
            ..rig.clone()
        };
        let course_speed = turn_evenly(&calm, &[]).crossings;
        let course_speed = course_speed.iter().map(|c| (c.time_s, c.speed)).collect();
        let times = arrivals(&course, &[]);
        let mut edges: Vec<usize> = (0..course.crossings.len())
            .filter(|&at| course.crossings[at].class.is_some())
            .collect();
        let mut visits: HashMap<i64, u32> = HashMap::new();
        let visit = |at: &usize| {
            let count = visits.entry(course.crossings[*at].place).or_insert(0);
            *count += 1;
            *count - 1
        };
        let mut visit: Vec<u32> = edges.iter().map(visit).collect();
        // Edges at the very ends may not be met with an effect. What they might have said must not be made up.
        let ends = 1 + (END_RAD / rig.encoder.step_rad()).ceil() as usize;
        edges.truncate(edges.len().saturating_sub(ends));
        edges.drain(..ends.min(edges.len()));
        visit.truncate(ends + edges.len());
        visit.drain(..ends.min(visit.len()));
        let count = rig.encoder.edges() as i64;
        let stamp = rig.stamp_rms_s();
        let mut last = 0.0;
        let mut noise = Vec::with_capacity(edges.len());
        for &at in &edges {
            let crossing = &course.crossings[at];
            noise.push(Edge {
                since_s: (times[at] - last).max(0.0),
                damping: rig.noise_damping(crossing.time_s),
                own_rad2: (crossing.speed * stamp).powi(2).max(1e-24),
            });
            last = times[at];
        }
        let density = rig.noise_psd / (rig.inertia * rig.inertia);
        let crossing = |at: &usize| &course.crossings[*at];
        Self {
            whitener: Whitener::new(&noise, density),
            k: (edges.iter().map(crossing))
                .map(|c| c.place.rem_euclid(count) as usize)
                .collect(),
            time: edges.iter().map(|&at| times[at]).collect(),
            angle: (edges.iter().map(crossing))
                .map(|c| c.place as f64 * rig.encoder.step_rad())
                .collect(),
            speed: edges.iter().map(|at| crossing(at).speed).collect(),
            times,
            edges,
            visit,
            noise,
            density,
            course,
            course_speed,
        }
    }

    /// Speed without the rig's ripples at a time. A shaft that lags keeps the ripples' places, so its lag in time, at this speed, is
    /// smooth; at the speed with ripples it would seem to swing.
    fn smooth(&self, time_s: f64) -> f64 {
        let after = self.course_speed.partition_point(|(at, _)| *at <= time_s);
        let at = |i: usize| {
            self.course_speed
                .get(i.min(self.course_speed.len().saturating_sub(1)))
        };
        match (at(after.saturating_sub(1)), at(after)) {
            (Some(&(t0, v0)), Some(&(t1, v1))) if t1 > t0 => {
                let share = ((time_s - t0) / (t1 - t0)).clamp(0.0, 1.0);
                v0 + share * (v1 - v0)
            }
            (Some(&(_, v)), _) => v,
            _ => 0.0,
        }
    }

    /// Angle by which the effect moves each edge, rad: 0 where the effect keeps an edge from being met.
    fn signal(&self, rig: &Rig, effect: &Effect) -> Vec<f64> {
        let changed = changed(rig, effect);
        let effects = std::slice::from_ref(effect);
        let course = turn_evenly(&changed, effects);
        let times = arrivals(&course, effects);
        // An edge is the same if it is the nth time that its place is passed.
        let mut met: HashMap<(i64, u32), f64> = HashMap::with_capacity(times.len());
        let mut visits: HashMap<i64, u32> = HashMap::new();
        for (crossing, &time) in course.crossings.iter().zip(&times) {
            if crossing.class.is_some() {
                let visit = visits.entry(crossing.place).or_insert(0);
                met.insert((crossing.place, *visit), time);
                *visit += 1;
            }
        }
        let each = self.edges.iter().zip(&self.visit).map(|(&at, &visit)| {
            let crossing = &self.course.crossings[at];
            let time = met.get(&(crossing.place, visit));
            time.map(|time| (time - self.times[at]) * self.smooth(crossing.time_s))
        });
        let signal: Vec<Option<f64>> = each.collect();
        // Few are not met, as at a reversal: the difference beside one holds.
        let met_last = signal.iter().rposition(Option::is_some);
        let mut last = signal.iter().flatten().next().copied().unwrap_or(0.0);
        let filled = signal.into_iter().map(|value| {
            last = value.unwrap_or(last);
            last
        });
        let mut filled: Vec<f64> = filled.collect();
        // A run that the effect slows down ends before: it goes on as it went, or its end would be an effect.
        if let Some(end) = met_last.filter(|end| *end > SLOPE) {
            let from = end - SLOPE;
            let slope = (filled[end] - filled[from]) / (self.time[end] - self.time[from]);
            for at in end + 1..filled.len() {
                filled[at] = filled[end] + slope * (self.time[at] - self.time[end]);
            }
        }
        filled
    }
}

pub use variance::is_variance;

/// The rig that really turns: an effect may take the place of what the twin declares.
#[must_use]
pub fn changed(rig: &Rig, effect: &Effect) -> Rig {
    let mut rig = rig.clone();
    if let Effect::ClosedLoop {
        kp_n_m_s,
        ki_n_m,
        f_hz,
    } = *effect
    {
        rig.profile = Profile::Loop {
            speed: rig.profile.start(),
            f_hz,
            kp_n_m_s,
            ki_n_m,
        };
        rig.stiffness = 0.0;
    }
    rig
}
