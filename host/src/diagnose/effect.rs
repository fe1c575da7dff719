//! What an effect does to the edges of a recording.

use std::borrow::Cow;
use std::f64::consts::TAU;

use super::course::Course;
use super::declared::Asked;
use super::plant::{Motion, Plant, sign};
use super::record::Record;
use crate::effect::number::Sloped;
pub use crate::effect::{Carrier, Effect, Growth, Here, On, Site, along_time, is_exact};

/// What an effect acts on.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The edges.
    pub record: &'a Record,
    /// Errors of its disc as declared, rad.
    pub disc: &'a [f64],
    /// Where the shaft was.
    pub course: &'a Course,
    /// How it answers to a torque.
    pub plant: &'a Plant,
    /// What the drive asks for.
    pub asked: &'a Asked,
}

impl Effect {
    /// What it adds to the grid angle of each edge, rad, for unit of each size.
    pub fn columns(&self, scene: &Scene<'_>) -> Vec<Vec<f64>> {
        match self.site {
            Site::Torque | Site::Drive => {
                let each = self.motions(scene).into_iter();
                each.map(|column| column.iter().map(|[angle, _]| *angle).collect())
                    .collect()
            }
            // Every turn repeats it.
            Site::Disc(_) if self.is_of_disc() => {
                let slots = 0..scene.record.edges as usize;
                let errors = slots.map(|slot| {
                    let here = Here {
                        time_s: 0.0,
                        inside_s: 0.0,
                        angle: scene.record.angle_of(slot),
                        speed: 0.0,
                        way: 0.0,
                    };
                    let by = self.ahead(scene.record.change_of(slot));
                    self.value(here).map(|value| by * value)
                });
                let errors: Vec<[f64; 2]> = errors.collect();
                let each = (0..self.sizes()).map(|size| {
                    let own: Vec<f64> = errors.iter().map(|both| both[size]).collect();
                    scene.record.shown(&own)
                });
                each.collect()
            }
            Site::Disc(_) | Site::Level(_) | Site::Stamp(_) | Site::Declared(_) => {
                let mut columns = vec![vec![0.0; scene.record.len()]; self.sizes()];
                for at in 0..scene.record.len() {
                    // Angle that one unit at its site is at an edge, rad.
                    let mut by = match self.site {
                        Site::Stamp(on) if on.has(scene.record.captured(at)) => {
                            -scene.course.speed[at]
                        }
                        _ => self.ahead(scene.record.change(at)),
                    };
                    if self.growth == Growth::Own {
                        let own = scene.disc.get(scene.record.slot(at));
                        by *= own.copied().unwrap_or(0.0);
                    }
                    if by != 0.0 {
                        let value = self.value(scene.here(at, self));
                        for (column, value) in columns.iter_mut().zip(value) {
                            column[at] = by * value;
                        }
                    }
                }
                columns
            }
        }
    }

    /// What it makes of the shaft's angle and speed at each edge, for unit of each size, where it is a torque.
    pub fn motions(&self, scene: &Scene<'_>) -> Vec<Vec<Motion>> {
        let rate = |speed: f64| match self.carrier {
            Carrier::Order(order) => order * speed,
            Carrier::Tone(f_hz) => TAU * f_hz,
            Carrier::Chirp(f_hz, rate) => {
                let until_s = scene.course.time_s.last().copied().unwrap_or(0.0);
                TAU * (f_hz.abs() + (rate * until_s).abs())
            }
            Carrier::Bump(_, sigma) => speed / sigma,
            _ => 0.0,
        };
        let mut breaks = self.instants_s();
        let turns = matches!(
            self.carrier,
            Carrier::Direction | Carrier::Power(_) | Carrier::Stribeck(_)
        );
        if turns || matches!(self.growth, Growth::Speed(_)) {
            breaks.extend(&scene.course.reversals_s);
        }
        if self.is_friction() {
            breaks.extend(scene.asked.breaks_s());
            breaks.extend(Some(scene.plant.law.off_s).filter(|off_s| off_s.is_finite()));
        }
        breaks.sort_by(f64::total_cmp);
        let law = &scene.plant.law;
        let free = self.site == Site::Drive && law.undriven;
        // What an unknown drive changes is in the free course.
        let plant = match free {
            true => Cow::Owned(scene.plant.free(scene.course)),
            false => Cow::Borrowed(scene.plant),
        };
        // Friction must not see the noise that it is to be told from.
        let foretold = (self.site == Site::Torque || law.undriven)
            && matches!(self.carrier, Carrier::Power(_) | Carrier::Stribeck(_));
        let push = |here: Here| {
            if self.site == Site::Drive && !free {
                if here.inside_s >= law.off_s {
                    return [0.0; 2];
                }
                // What the drive adds to follow: J dw/dt, and damping times what it asks for on top.
                let (asked, rate) = scene.asked.at(here.time_s, here.inside_s);
                let both = self.value(along_time(here));
                let damping = law.damping(here.inside_s, asked);
                return both.map(|Sloped { at: value, slope }| {
                    rate * value + asked * slope + damping * asked * value
                });
            }
            let torques = self.value(here);
            let given = match self.is_friction() && here.inside_s < law.off_s {
                true => self.value(scene.asked.here(here)),
                false => [0.0; 2],
            };
            [0, 1].map(|size| (torques[size] - given[size]) / law.inertia)
        };
        // Nothing moves before it begins.
        let begins_s = match self.carrier {
            Carrier::Window(from_s, _) | Carrier::Settling(from_s, _) => from_s,
            _ => f64::NEG_INFINITY,
        };
        let times = &scene.course.time_s;
        let still = times.partition_point(|time_s| *time_s < begins_s);
        let moving = still.saturating_sub(1)..times.len();
        let responses =
            plant.responses(moving.clone(), scene.course, foretold, push, rate, &breaks);
        let each = responses.into_iter().take(self.sizes());
        each.map(|response| [vec![Motion::default(); moving.start], response].concat())
            .collect()
    }
}

impl Scene<'_> {
    /// The instant of an edge as an effect sees it: errors of the disc go with the grid, all else with the shaft, a run-out as well. Time
    /// and angle are those at which the edge was there, before any delay.
    #[inline]
    pub fn here(&self, at: usize, effect: &Effect) -> Here {
        let runs_out = matches!(effect.carrier, Carrier::Order(order) if order.fract() != 0.0);
        let late_s = self.course.late_s[at];
        let angle = match effect.site {
            Site::Disc(_) if !runs_out => self.record.grid_rad(at),
            _ => self.course.angle[at] - self.course.speed[at] * late_s,
        };
        let time_s = self.course.time_s[at] - late_s;
        Here {
            time_s,
            inside_s: time_s,
            angle,
            speed: self.course.speed[at],
            way: sign(self.course.speed[at]),
        }
    }
}

#[cfg(test)]
mod tests;
