//! A shaft that stood, broke away once and then slides behind a spring: stick-slip that is damped too much to stick again.
//!
//! Its first turn shows the spring by how it swings and the drop of friction by how it breaks away. Both must be needed: without the
//! spring speed only comes up, and without the drop a spring swings about its mean from the start on.

use std::f64::consts::TAU;

use super::slide::{Slide, SlideLaw, SlideNoise};
use super::slide_fit::{NONE, SlideFit, fitted};
use super::slip::Wave;
use crate::diagnose::run::Recorded;
use crate::diagnose::track::Mark;
use crate::sim::Simulation;

/// Turns that are looked at, and edges at the most.
const TURNS: f64 = 1.5;
const EDGES_MOST: usize = 6_000;
/// Edges that laws to begin with are found by, and the law at last.
const EDGES_FIRST: usize = 600;
const EDGES_LAST: usize = 3_000;
/// Edges needed.
const EDGES_LEAST: usize = 100;
/// Share of the mean speed below which it stands or has hardly begun to move.
const SLOW: f64 = 0.6;
/// Evidence, as -2 log likelihood, of spring and drop each.
const EVIDENCE_LEAST: f64 = 50.0;
/// Turns that noise and law are found by, first and at last.
const FIRST: usize = 1;
const LAST: usize = 3;

/// Numbers that are free where the damping is given.
const FREE: [usize; 7] = [0, 1, 2, 3, 4, 6, 7];

/// A shaft that broke away.
#[derive(Clone, Debug)]
pub struct BrokeAway {
    /// How it slides.
    pub law: SlideLaw,
    /// Standard errors of the logarithms of spring, drop and speed.
    pub errors: [f64; 3],
    /// Evidence against the next best law.
    pub delta_bic: f64,
    /// When it broke away, s.
    pub at_s: f64,
    /// Coulomb friction over the inertia, rad/s^2, if the spring was slack at time 0.
    pub coulomb: f64,
    /// Whether the drive pulls towards the speed beside the spring.
    pub beside: bool,
    /// The edges that show it.
    pub slide: Slide,
}

/// The recording's beginning, if the shaft stood there and broke away.
#[must_use]
pub fn broke_away(one: &Recorded) -> Option<BrokeAway> {
    let (slide, at_s) = slide(one)?;
    let shaft = &one.twin.shaft;
    let viscous = shaft.viscous_n_m_s / shaft.inertia_kg_m2;
    let stiff = shaft.stiffness_n_m_s / shaft.inertia_kg_m2;
    let (beside, found) = [(false, viscous), (true, viscous + stiff)]
        .into_iter()
        .filter(|(_, damping)| *damping > 0.0)
        .filter_map(|(beside, damping)| Some((beside, best(&slide, damping)?)))
        .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    let law = SlideLaw::of(&found.at);
    let other = without_spring(&slide, &found)?.min(without_drop(&slide, &found)?);
    let delta_bic = other - found.cost - (slide.ways.len() as f64).ln();
    let known = found.errors[..3].iter().all(|error| *error < 0.5);
    (delta_bic > EVIDENCE_LEAST && known && law.pull_rad_s > 0.0).then(|| BrokeAway {
        errors: [found.errors[0], found.errors[1], found.errors[2]],
        delta_bic,
        at_s,
        // It stood somewhere between two edges.
        coulomb: (law.spring * (law.pull_rad_s * at_s - 0.5 * slide.ways[1]) - law.push).max(0.0),
        law,
        beside,
        slide,
    })
}

/// -2 log likelihood of a shaft that friction lets go and its drive brings up to speed, whatever holds that.
fn without_spring(slide: &Slide, found: &SlideFit) -> Option<f64> {
    let law = SlideLaw::of(&found.at);
    let starts = [0.3, 1.0, 3.0].into_iter().flat_map(|faster| {
        let damping = faster * law.spring.sqrt();
        let steady = damping * law.pull_rad_s;
        [law.drop, 0.1 * steady].map(|drop| {
            let mut at = found.at;
            (at[0], at[1], at[3], at[5]) = (NONE, drop.ln(), steady, damping.ln());
            at
        })
    });
    let fits = starts.filter_map(|at| fitted(slide, at, &[1, 2, 3, 5, 6, 7], found.noise, FIRST));
    fits.map(|fit| fit.cost).reduce(f64::min)
}

/// The same of a shaft on a spring whose friction does not fall.
fn without_drop(slide: &Slide, found: &SlideFit) -> Option<f64> {
    let starts = [0.5, 1.0, 2.0].into_iter().map(|factor: f64| {
        let mut at = found.at;
        (at[0], at[1]) = (at[0] + factor.ln(), NONE);
        at
    });
    let fits = starts.filter_map(|at| fitted(slide, at, &[0, 3, 4, 5, 6, 7], found.noise, FIRST));
    fits.map(|fit| fit.cost).reduce(f64::min)
}

/// The best law with a damping, from where springs and friction come to lie.
fn best(slide: &Slide, damping: f64) -> Option<SlideFit> {
    let thin = slide.thinned(EDGES_FIRST);
    let last = slide.ways.len() - 1;
    let middle = last / 2;
    let pull =
        (slide.ways[last] - slide.ways[middle]) / (slide.times_s[last] - slide.times_s[middle]);
    let seconds = slide.times_s[last];
    let noise = SlideNoise {
        // A hundredth of the speed in the time of a radian.
        acceleration: 1e-4 * pull * pull * pull,
        stamp_s: 1e-4 * seconds / slide.ways.len() as f64,
        angle_rad: 0.0,
    };
    let mean = |from: usize| {
        let (ways, times) = (&slide.ways, &slide.times_s);
        (ways[from + 1] - ways[from]) / (times[from + 1] - times[from])
    };
    let faster = (mean(1) - mean(0)) / slide.times_s[2];
    let begins = (mean(0) - faster * slide.times_s[1]).max(0.1 * mean(0));
    let mut tries = Vec::new();
    for turning in [4.0, 7.0, 12.0, 20.0] {
        for over in [0.25, 0.5] {
            let spring = (turning * pull).powi(2);
            let drop = 0.2 * spring;
            // Where it slides on at last.
            let push = damping * pull - spring * (pull * seconds - slide.ways[last]);
            let start = [
                spring.ln(),
                drop.ln(),
                (over * pull).ln(),
                push,
                pull,
                damping.ln(),
                0.0,
                begins,
            ];
            tries.extend(fitted(&thin, start, &FREE, noise, FIRST));
        }
    }
    let best = tries.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    fitted(slide, best.at, &FREE, best.noise, LAST)
}

/// Edges from the first on, and when that came.
fn slide(one: &Recorded) -> Option<(Slide, f64)> {
    let mut track = one.track.clone();
    if !track.anchored {
        track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    let first = track.stretches.first()?;
    let way = first.direction;
    let most = ((TURNS * track.edges as f64) as usize).min(EDGES_MOST);
    // It may have stood long before the index.
    let marks: Vec<Mark> = track
        .early
        .iter()
        .chain(&first.marks)
        .copied()
        .take(most)
        .collect();
    if marks.len() < EDGES_LEAST.max(track.edges as usize / 2) {
        return None;
    }
    let step = TAU / track.edges as f64;
    let speed = |from: usize, to: usize| {
        ((marks[to].place - marks[from].place) * way) as f64 * step
            / (marks[to].time_s - marks[from].time_s)
    };
    let last = marks.len() - 1;
    let usual = speed(last / 2, last);
    let begins = speed(0, 2);
    let starts_at_rest = marks[0].time_s > 0.0 && begins < SLOW * usual;
    // One that stands again is fitted slip by slip.
    let goes_on = marks[3..].windows(2).all(|pair| {
        (pair[1].time_s - pair[0].time_s) * usual
            < 20.0 * step * ((pair[1].place - pair[0].place) * way) as f64
    });
    if !starts_at_rest || !goes_on || usual.is_nan() || usual <= 0.0 {
        return None;
    }
    let errors = Simulation::new(&one.twin).ok()?.true_errors();
    let angle = |place: i64| {
        let edge = (place + track.origin).rem_euclid(track.edges) as usize;
        let past = errors.get(edge).copied().unwrap_or(0.0);
        ((place + track.origin) as f64 * step - past) * way as f64
    };
    let begin = angle(marks[0].place);
    let waves = Wave::of(&one.twin, usual).into_iter().map(|wave| {
        let phase_rad = (wave.order * begin * way as f64 + wave.phase_rad) * way as f64;
        Wave { phase_rad, ..wave }
    });
    let slide = Slide {
        times_s: marks.iter().map(|m| m.time_s - marks[0].time_s).collect(),
        ways: marks.iter().map(|m| angle(m.place) - begin).collect(),
        waves: waves.collect(),
    };
    Some((slide.thinned(EDGES_LAST), marks[0].time_s))
}
