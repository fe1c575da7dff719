//! One recording as the ideal detector has it, and what an effect changes in it.

use std::collections::HashMap;

use super::changed;
use super::passed::Passed;
use crate::capture::arrivals;
use crate::effect::{Effect, Place};
use crate::rig::{Profile, Rig};
use crate::turning::{Course, Crossing, turn_evenly};

/// Way at either end of a run that is left out, rad: as far as an effect moves an edge.
pub const END_RAD: f64 = 0.06;

/// Edges at the end of a run that say how it would go on.
const SLOPE: usize = 40;

/// Part of the speed without ripples by which they may change it.
const HELD: f64 = 0.5;

/// How much longer an effect on the speed is followed than the base run.
const LONGER: f64 = 1.5;

/// What the ideal detector has of one recording: base run without noise, and the noise's filter.
pub(crate) struct Sight {
    course: Course,
    /// Times and speeds of a run without ripples.
    course_speed: Vec<(f64, f64)>,
    times: Vec<f64>,
    /// Which of the base run's crossings are edges.
    edges: Vec<usize>,
    /// How often the place of each was passed before.
    visit: Vec<u32>,
    pub(crate) passed: Passed,
}

impl Sight {
    pub fn new(rig: &Rig) -> Self {
        let course = turn_evenly(rig, &[]);
        let calm = Rig {
            ripples: Vec::new(),
            ..rig.clone()
        };
        let course_speed = turn_evenly(&calm, &[]).crossings;
        let course_speed = course_speed.iter().map(|c| (c.time_s, c.speed)).collect();
        let times = arrivals(&course, rig, &[]);
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
        let each = edges.iter().map(|&at| (&course.crossings[at], times[at]));
        Self {
            passed: Passed::new(rig, each),
            times,
            edges,
            visit,
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
    pub fn signal(&self, rig: &Rig, effect: &Effect) -> Vec<f64> {
        let mut changed = changed(rig, effect);
        let effects = std::slice::from_ref(effect);
        if effect.is_slow() {
            // Long enough to be where the base run is at its last edge, and when.
            changed.turns *= LONGER;
            changed.longest_s *= LONGER;
            return self.lag(rig, &turn_evenly(&changed, effects));
        }
        if let Some(shift) = self.shift(&changed, effect) {
            return shift;
        }
        let course = turn_evenly(&changed, effects);
        let times = arrivals(&course, &changed, effects);
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
            let time = met.get(&(crossing.place, visit))?;
            let smooth = self.smooth(crossing.time_s);
            // Where ripples hold the shaft or throw it over, a lag in time is no angle at the speed without them.
            let held = (crossing.speed - smooth).abs() > HELD * smooth.abs();
            (!held).then(|| (time - self.times[at]) * smooth)
        });
        let signal: Vec<Option<f64>> = each.collect();
        // Few are not met, as at a reversal: the difference beside one holds. Where the shaft stands, a push may have it wait elsewhere,
        // and go on earlier or later: of an unknown course that says nothing. A play does show there.
        let joins = effect.play_rad() == 0.0;
        let met_last = signal.iter().rposition(Option::is_some);
        let first = signal.iter().flatten().next().copied().unwrap_or(0.0);
        let (mut last, mut apart, mut goes_on) = (first, 0.0, true);
        let filled = signal.into_iter().map(|value| {
            if let Some(value) = value {
                if joins && !goes_on {
                    apart = value - last;
                }
                last = value - apart;
            }
            goes_on = value.is_some();
            last
        });
        let mut filled: Vec<f64> = filled.collect();
        // A run that the effect slows down ends before: it goes on as it went, or its end would be an effect.
        if let Some(end) = met_last.filter(|end| *end > SLOPE) {
            let from = end - SLOPE;
            let slope =
                (filled[end] - filled[from]) / (self.passed.time[end] - self.passed.time[from]);
            for at in end + 1..filled.len() {
                filled[at] = filled[end] + slope * (self.passed.time[at] - self.passed.time[end]);
            }
        }
        filled
    }

    /// The same where the effect leaves the shaft's course as it is and only moves marks.
    fn shift(&self, rig: &Rig, effect: &Effect) -> Option<Vec<f64>> {
        let disc = effect.disc(rig.encoder);
        let late =
            [0, 1, 2].map(|channel| [true, false].map(|rises| effect.delay_s(channel, rises)));
        let delays = late.as_flattened().iter().any(|late_s| *late_s != 0.0);
        let sees_edges = matches!(rig.profile, Profile::Loop { .. });
        if sees_edges || !effect.moves_marks() && !delays && disc.is_none() {
            return None;
        }
        let jumps = effect.jumps(rig.longest_s, 2.0 * rig.turns + 10.0);
        let each = self.edges.iter().zip(&self.passed.k).map(|(&at, &k)| {
            let crossing = &self.course.crossings[at];
            let place = Place {
                time_s: crossing.time_s,
                inside_s: crossing.time_s,
                theta: crossing.place as f64 * rig.encoder.step_rad(),
                speed: crossing.speed,
                class: crossing.class,
            };
            let late_s = effect.delay_s(crossing.bit.trailing_zeros() as usize, crossing.high);
            let moved = effect.late_rad(&place, &jumps) + late_s * crossing.speed;
            disc.as_ref().map_or(0.0, |disc| disc[k]) + moved
        });
        Some(each.collect())
    }

    /// Angle by which the shaft of another course lags at the time of each edge of an even disc: edge by edge a drive that goes off
    /// at a time would seem to go off at a place.
    fn lag(&self, rig: &Rig, other: &Course) -> Vec<f64> {
        let step = rig.encoder.step_rad();
        let marks: Vec<&Crossing> = (other.crossings.iter())
            .filter(|crossing| crossing.class.is_some())
            .collect();
        let each = self
            .passed
            .time
            .iter()
            .zip(&self.passed.angle)
            .map(|(&time, &angle)| {
                let after = marks.partition_point(|mark| mark.time_s <= time);
                let (Some(from), Some(to)) =
                    (marks.get(after.saturating_sub(1)), marks.get(after.max(1)))
                else {
                    return None;
                };
                // Hermite's cubic by the speeds at both marks.
                let h = to.time_s - from.time_s;
                let x = (time - from.time_s) / h;
                let (low, high) = (from.place as f64 * step, to.place as f64 * step);
                let there = low
                    + (high - low) * x * x * (3.0 - 2.0 * x)
                    + h * x * (1.0 - x) * (from.speed * (1.0 - x) - to.speed * x);
                Some(angle - there)
            });
        let mut last = 0.0;
        each.map(|lag| {
            last = lag.unwrap_or(last);
            last
        })
        .collect()
    }
}
