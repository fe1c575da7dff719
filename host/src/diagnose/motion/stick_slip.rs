//! Stick-slip: the shaft stands until a spring is wound up, slips, and stands again (equation in [`super::slip`]).
//!
//! It is recognised by the motion alone: intervals that are far too long come again and again after about the same way, where the
//! twin's speed is steady. Each slip is then fitted for itself, in angle, with its instant of breaking away and its place of rest free,
//! so that the phase of the cycle, which torque noise moves, does not matter; the scatter between slips is the uncertainty.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::MotionFinding;
use super::broke_away::broke_away;
use super::rests::{EDGES_LEAST, SLIPS_LEAST, Slips, slips};
use super::slip::{SlipLaw, Wave};
use super::slip_fit::{Cycle, Fitted, fitted, refitted};
use crate::diagnose::run::Recorded;
use crate::mechanism::Mechanism;
use crate::sim::Simulation;
use crate::twin::{Drive, Noise, StickSlip, Twin};

/// Slips fitted at the most.
const SLIPS_MOST: usize = 48;

/// Stick-slip in one recording; torques over the inertia.
#[derive(Clone, Debug)]
struct Seen {
    spring: f64,
    drop: f64,
    over_rad_s: f64,
    /// Standard errors of the logarithms of spring, drop and speed.
    errors: [f64; 3],
    /// Coulomb friction that explains it.
    coulomb: f64,
    delta_bic: f64,
    /// Whether the drive pulls towards the speed beside the spring.
    beside: bool,
    text: String,
}

/// Stick-slip that the twins of a rig lack.
#[must_use]
pub fn recognised(rig: &[Recorded]) -> Option<MotionFinding> {
    let seen: Vec<(usize, Seen)> = rig
        .par_iter()
        .enumerate()
        .filter_map(|(at, one)| Some((at, looked_at(one)?)))
        .collect();
    // What says most, where there are several.
    let (best, found) = seen
        .iter()
        .max_by(|a, b| a.1.delta_bic.total_cmp(&b.1.delta_bic))?;
    let inertia = rig[*best].twin.shaft.inertia_kg_m2;
    let twins = rig.iter().map(|one| with(&one.twin, found)).collect();
    let [spring, drop, over] = found.errors;
    let (stiffness, stribeck) = (found.spring * inertia, found.drop * inertia);
    let finding = MotionFinding {
        mechanism: Mechanism::StickSlip,
        parameters: vec![
            ("stiffness_n_m_rad", stiffness, stiffness * spring),
            ("stribeck_n_m", stribeck, stribeck * drop),
            ("stribeck_rad_s", found.over_rad_s, found.over_rad_s * over),
            ("coulomb_n_m", found.coulomb * inertia, f64::INFINITY),
        ],
        delta_bic: seen.iter().map(|(_, seen)| seen.delta_bic).sum(),
        text: found.text.clone(),
        twins,
    };
    finding.plausible().then_some(finding)
}

/// A twin with stick-slip in.
fn with(twin: &Twin, found: &Seen) -> Twin {
    let mut twin = twin.clone();
    let inertia = twin.shaft.inertia_kg_m2;
    twin.stick_slip = Some(StickSlip {
        stiffness_n_m_rad: found.spring * inertia,
    });
    twin.shaft.stribeck_n_m = found.drop * inertia;
    twin.shaft.stribeck_rad_s = found.over_rad_s;
    twin.shaft.coulomb_n_m = twin.shaft.coulomb_n_m.max(found.coulomb * inertia);
    if !found.beside {
        twin.shaft.stiffness_n_m_s = 0.0;
    }
    twin
}

fn looked_at(one: &Recorded) -> Option<Seen> {
    let twin = &one.twin;
    let wanders = matches!(twin.noise, Some(Noise::SpeedWander { .. }));
    if !matches!(twin.drive, Drive::Constant { .. }) || twin.stick_slip.is_some() || wanders {
        return None;
    }
    cycle_after_cycle(one).or_else(|| once(one))
}

/// A shaft that broke away once.
fn once(one: &Recorded) -> Option<Seen> {
    let found = broke_away(one)?;
    let law = found.law;
    Some(Seen {
        spring: law.spring,
        drop: law.drop,
        over_rad_s: law.over_rad_s,
        errors: found.errors,
        coulomb: found.coulomb,
        delta_bic: found.delta_bic,
        beside: found.beside,
        text: format!(
            "The shaft stands until {:.3} s, breaks away and swings behind a spring; friction that falls with speed does not stop it \
             again. Coulomb friction only winds the spring up and can't be told from this recording.",
            found.at_s
        ),
    })
}

/// A shaft that sticks and slips on and on.
fn cycle_after_cycle(one: &Recorded) -> Option<Seen> {
    let twin = &one.twin;
    let slips = slips(one)?;
    let cycles = cycles(one, &slips)?;
    let shaft = &twin.shaft;
    let viscous = shaft.viscous_n_m_s / shaft.inertia_kg_m2;
    let stiff = shaft.stiffness_n_m_s / shaft.inertia_kg_m2;
    let (beside, damping, first) = fitted(
        &cycles,
        slips.pull_rad_s,
        [(false, viscous), (true, viscous + stiff)],
    )?;
    let (pull_rad_s, pull_error) = pull(&first)?;
    let all = refitted(&first, pull_rad_s, damping);
    let mut squares: Vec<f64> = all
        .iter()
        .map(|one| one.1.squares / one.0.ways.len() as f64)
        .collect();
    squares.sort_by(f64::total_cmp);
    let usual = *squares.get(squares.len() / 2)?;
    // A slip that a defect or a lost edge spoils says nothing.
    let good: Vec<&(&Cycle, Fitted)> = all
        .iter()
        .filter(|(cycle, fit)| fit.squares < 8.0 * usual * cycle.ways.len() as f64)
        .collect();
    if good.len() < SLIPS_LEAST {
        return None;
    }
    let (mut means, mut errors) = ([0.0; 3], [0.0; 3]);
    for (i, (mean, error)) in means.iter_mut().zip(&mut errors).enumerate() {
        let count = good.len() as f64;
        *mean = good.iter().map(|(_, fit)| fit.at[i]).sum::<f64>() / count;
        let scatter: f64 = good
            .iter()
            .map(|(_, fit)| (fit.at[i] - *mean).powi(2))
            .sum();
        // Few slips know their own scatter badly.
        let own = (scatter / (count - 1.0) / count).sqrt() * (1.0 + 1.5 / (count - 1.0));
        *error = own.hypot(pull_error / pull_rad_s);
    }
    let law = SlipLaw {
        spring: means[0].exp(),
        drop: means[1].exp(),
        over_rad_s: means[2].exp(),
        damping,
        pull_rad_s,
        waves: Vec::new(),
    };
    let slip = law.slip()?;
    // Against a shaft that goes at the mean speed all the time.
    let (mut before, mut after, mut edges) = (0.0, 0.0, 0.0);
    for (cycle, fit) in &good {
        let level = mean(
            cycle
                .ways
                .iter()
                .zip(&cycle.times_s)
                .map(|(way, t)| way - pull_rad_s * t),
        );
        let off = cycle.ways.iter().zip(&cycle.times_s);
        before += off
            .map(|(way, t)| (way - pull_rad_s * t - level).powi(2))
            .sum::<f64>();
        after += fit.squares;
        edges += cycle.ways.len() as f64;
    }
    let delta_bic = edges * (before / after).ln() - (3.0 + 2.0 * good.len() as f64) * edges.ln();
    let (whole, seconds) = (slip.whole(), slip.seconds());
    // Stretch beyond the balance at the stop: twice of it friction must hold.
    let overshoot = law.spring * (whole - pull_rad_s * seconds) - 2.0 * law.drop;
    // A steady shaft with a rhythm in it is no limit cycle.
    (after < 0.02 * before && delta_bic > 50.0).then(|| Seen {
        spring: law.spring,
        drop: law.drop,
        over_rad_s: law.over_rad_s,
        errors,
        coulomb: (0.5 * overshoot).max(0.0) + 0.5 * law.drop,
        delta_bic,
        beside,
        text: format!(
            "The shaft stands and slips: {} slips of {:.2} degrees, one every {:.3} s. Coulomb friction only winds the spring up \
             and can't be told from this recording.",
            slips.ends.len(),
            whole.to_degrees(),
            whole / pull_rad_s
        ),
    })
}

fn cycles(one: &Recorded, slips: &Slips) -> Option<Vec<Cycle>> {
    let mut track = one.track.clone();
    if !track.anchored && !track.placed {
        track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    let errors = Simulation::new(&one.twin).ok()?.true_errors();
    let past = |place: i64| {
        let edge = (place + track.origin).rem_euclid(track.edges) as usize;
        errors.get(edge).copied().unwrap_or(0.0)
    };
    let angle = |place: i64| (place + track.origin) as f64 * TAU / track.edges as f64 - past(place);
    let waves = Wave::of(&one.twin, slips.pull_rad_s);
    let first = |place: i64| {
        let theta = angle(place);
        let turned = waves.iter().map(|wave| {
            let phase_rad = (wave.order * theta + wave.phase_rad) * slips.way as f64;
            Wave { phase_rad, ..*wave }
        });
        turned.collect()
    };
    let each = (slips.ends.len() / SLIPS_MOST).max(1);
    let mut cycles = Vec::new();
    for &(from, to) in slips.ends.iter().step_by(each) {
        let passed = (slips.places[to] - slips.places[from]) * slips.way;
        if to - from + 1 < EDGES_LEAST || passed != (to - from) as i64 {
            continue;
        }
        cycles.push(Cycle {
            start_s: slips.times_s[from],
            start_rad: angle(slips.places[from]) * slips.way as f64,
            times_s: (from..=to)
                .map(|i| slips.times_s[i] - slips.times_s[from])
                .collect(),
            ways: (from..=to)
                .map(|i| (angle(slips.places[i]) - angle(slips.places[from])) * slips.way as f64)
                .collect(),
            waves: first(slips.places[from]),
        });
    }
    (cycles.len() >= SLIPS_LEAST).then_some(cycles)
}

/// Speed of the spring's far end and its standard error: breaking away is always at the same stretch.
fn pull(all: &[(&Cycle, Fitted)]) -> Option<(f64, f64)> {
    let points = || {
        all.iter()
            .map(|(cycle, fit)| (cycle.start_s + fit.at[3], cycle.start_rad + fit.at[4]))
    };
    let (time, angle) = (mean(points().map(|p| p.0)), mean(points().map(|p| p.1)));
    let long: f64 = points().map(|p| (p.0 - time).powi(2)).sum();
    let along: f64 = points().map(|p| (p.0 - time) * (p.1 - angle)).sum();
    let speed = along / long;
    let off: f64 = points()
        .map(|p| (p.1 - angle - speed * (p.0 - time)).powi(2))
        .sum();
    let error = (off / (all.len() as f64 - 2.0) / long).sqrt();
    (speed.is_finite() && speed > 0.0 && error.is_finite()).then_some((speed, error))
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}
