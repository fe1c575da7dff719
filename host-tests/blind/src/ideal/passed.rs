//! Edges that a run passed, and the filter of the noise over them.

use crate::capture::arrivals;
use crate::effect::Effect;
use crate::rig::{Profile, Rig};
use crate::turning::{Course, Crossing};
use crate::whiten::{Edge, Whitener};

/// Edges of one recording.
pub(crate) struct Passed {
    pub(crate) whitener: Whitener,
    /// Edge of the turn, for each.
    pub(crate) k: Vec<usize>,
    /// Time of each, s.
    pub(crate) time: Vec<f64>,
    /// Shaft angle of each, rad.
    pub(crate) angle: Vec<f64>,
    /// Shaft speed at each, rad/s.
    pub(crate) speed: Vec<f64>,
    pub(crate) noise: Vec<Edge>,
    pub(crate) density: f64,
    /// Whether nothing drives the shaft in the end.
    pub(crate) runs_down: bool,
}

impl Passed {
    /// Of crossings with their times of arrival. The torque noise moves the shaft as if the rig had no ripples.
    pub fn new<'a>(rig: &Rig, edges: impl Iterator<Item = (&'a Crossing, f64)>) -> Self {
        Self::along(rig, edges, |_, _| 0.0)
    }

    /// Of a run as it was recorded: every edge that it passed. About a turn the shaft is slow enough for ripples to hold it or to
    /// throw it over, so they are springs to what noise does.
    pub fn recorded(rig: &Rig, course: &Course, effects: &[Effect]) -> Self {
        let times = arrivals(course, rig, effects);
        let edges = course.crossings.iter().zip(times);
        let edges = edges.filter(|(crossing, _)| crossing.class.is_some());
        let play: f64 = effects.iter().map(Effect::play_rad).sum();
        let angle = |crossing: &Crossing| {
            let k = crossing.place.rem_euclid(rig.encoder.edges() as i64) as usize;
            let late = if crossing.forward { play } else { -play };
            crossing.place as f64 * rig.encoder.step_rad() - rig.disc_rad[k] + 0.5 * late
        };
        let slope = |from: &Crossing, to: &Crossing| {
            let angle = 0.5 * (angle(from) + angle(to));
            let each = (rig.ripples.iter())
                .map(|r| r.torque_n_m * r.order * libm::cos(r.order * angle + r.phase_rad));
            each.sum::<f64>() / rig.inertia
        };
        Self::along(rig, edges, slope)
    }

    fn along<'a>(
        rig: &Rig,
        edges: impl Iterator<Item = (&'a Crossing, f64)>,
        slope: impl Fn(&Crossing, &Crossing) -> f64,
    ) -> Self {
        let count = rig.encoder.edges() as i64;
        let stamp = rig.stamp_rms_s();
        let density = rig.noise_psd / (rig.inertia * rig.inertia);
        let mut passed = Self {
            whitener: Whitener::new(&[], density),
            k: Vec::new(),
            time: Vec::new(),
            angle: Vec::new(),
            speed: Vec::new(),
            noise: Vec::new(),
            density,
            runs_down: matches!(rig.profile, Profile::RunDown { .. }),
        };
        let mut last: Option<(&Crossing, f64)> = None;
        for (crossing, time) in edges {
            let (from, since) = last.unwrap_or((crossing, 0.0));
            passed.noise.push(Edge {
                since_s: (time - since).max(0.0),
                damping: rig.noise_damping(crossing.time_s),
                slope: slope(from, crossing),
                own_rad2: (crossing.speed * stamp).powi(2).max(1e-24),
            });
            passed.k.push(crossing.place.rem_euclid(count) as usize);
            passed.time.push(time);
            passed
                .angle
                .push(crossing.place as f64 * rig.encoder.step_rad());
            passed.speed.push(crossing.speed);
            last = Some((crossing, time));
        }
        passed.whitener = Whitener::new(&passed.noise, density);
        passed
    }
}
