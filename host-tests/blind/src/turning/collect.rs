//! Takes the marks crossed within a step, in order, and shows them to a speed loop.

use super::noise::Noise;
use super::{Run, marks};
use crate::effect::{Effect, Place};
use crate::step::Step;

impl Run<'_> {
    /// Takes every mark crossed within a step.
    pub(super) fn collect(&mut self, step: &Step) {
        let late = |within: f64, class, travel: f64, speed: f64| {
            if !self.moving {
                return 0.0;
            }
            let place = Place {
                time_s: self.time_s + within,
                inside_s: self.plant.inside_s,
                theta: self.state[0] + travel,
                speed,
                class,
            };
            let each = self.effects.iter().zip(&self.jumps);
            each.map(|(effect, jumps)| effect.late_rad(&place, jumps))
                .sum()
        };
        let way = marks::Way {
            step,
            from_rad: self.state[0],
            time_s: self.time_s,
            forward: self.motion >= 0.0,
            play: self.play,
        };
        let first = self.course.crossings.len();
        self.edges.collect(&way, &late, &mut self.course.crossings);
        if let Some(index) = &mut self.index {
            let slipped: i32 = self
                .effects
                .iter()
                .map(|effect| match effect {
                    Effect::IndexSlip { at_s, edges } if self.plant.inside_s >= *at_s => *edges,
                    _ => 0,
                })
                .sum();
            let slip = f64::from(slipped) * self.rig.encoder.step_rad();
            let late = |within: f64, class, travel: f64, speed: f64| {
                slip + late(within, class, travel, speed)
            };
            let before = self.course.crossings.len();
            index.collect(&way, &late, &mut self.course.crossings);
            if self.course.crossings.len() > before {
                self.course.crossings[first..].sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            }
        }
        for at in first..self.course.crossings.len() {
            let error = self.noise.as_mut().map_or(0.0, Noise::stamp);
            let crossing = &mut self.course.crossings[at];
            crossing.error_s = self.rig.jitter_s * error;
            if let (Some(control), Some(_)) = (&mut self.speed_loop, crossing.class) {
                control.edge(crossing, self.rig);
            }
        }
    }
}
