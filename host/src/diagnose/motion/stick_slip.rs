//! Stick-slip: the shaft stands until a spring is wound up, slips, and stands again (equation in [`super::slip`]).
//!
//! It is recognised by the motion alone: intervals that are far too long come again and again after about the same way, where the
//! twin's speed is steady. Each slip is then fitted for itself, in angle, with its instant of breaking away and its place of rest free,
//! so that the phase of the cycle, which torque noise moves, does not matter; the scatter between slips is the uncertainty.

use rayon::prelude::*;

use super::MotionFinding;
use super::agreement::{Agreement, agreement, once as once_agrees};
use super::broke_away::broke_away;
use super::cycles::{cycles, mean, pull};
use super::rests::{SLIPS_LEAST, slips};
use super::slide::{Slide, SlideLaw, SlideNoise};
use super::slip::SlipLaw;
use super::slip_fit::{Cycle, Fitted, fitted, refitted};
use super::slip_law::Law;
use crate::diagnose::board::{FITTED, PARTS};
use crate::diagnose::run::Recorded;
use crate::diagnose::track::Track;
use crate::mechanism::Mechanism;
use crate::sensor::PlanError;
use crate::sim::Simulation;
use crate::twin::{Drive, Noise, StickSlip, Twin};

/// Stick-slip in one recording; torques over the inertia.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) spring: f64,
    pub(super) drop: f64,
    pub(super) over_rad_s: f64,
    /// Standard errors of the logarithms of spring, drop and speed.
    pub(super) errors: [f64; 3],
    /// Coulomb friction that explains it.
    pub(super) coulomb: f64,
    pub(super) delta_bic: f64,
    /// Whether the drive pulls towards the speed beside the spring.
    pub(super) beside: bool,
    /// Slips that show it.
    pub(super) slips: usize,
    /// From slip to slip, s.
    pub(super) period_s: f64,
    pub(super) text: String,
    pub(super) left: Left,
}

/// What says how well it agrees.
#[derive(Clone, Debug)]
pub(super) enum Left {
    /// The law of all slips, and of the earlier ones.
    Cycles { law: Law, early: Option<Law> },
    /// Of a shaft that broke away once.
    Once(Box<Agreement>),
}

/// Stick-slip that the twins of a rig lack.
#[must_use]
pub fn recognised(rig: &[Recorded]) -> Option<(MotionFinding, Agreement)> {
    let seen: Vec<(usize, Seen)> = rig
        .par_iter()
        .enumerate()
        .filter_map(|(at, one)| Some((at, looked_at(one)?)))
        .collect();
    let (finding, found) = of_all(rig, &seen)?;
    let agreement = match &found.left {
        Left::Cycles { law, early } => agreement(rig, &vec![*law; rig.len()], early.as_ref(), None),
        Left::Once(agreement) => agreement.as_ref().clone(),
    };
    Some((finding, agreement))
}

/// A finding from what recordings of a rig show, by their numbers, and the one of them that says most; none where no rig has its
/// numbers.
pub(super) fn of_all<'a>(
    rig: &[Recorded],
    seen: &'a [(usize, Seen)],
) -> Option<(MotionFinding, &'a Seen)> {
    let (best, found) = seen
        .iter()
        .max_by(|a, b| a.1.delta_bic.total_cmp(&b.1.delta_bic))?;
    let inertia = rig[*best].twin.shaft.inertia_kg_m2;
    let mended = rig.par_iter().map(|one| {
        let twin = with(&one.twin, found);
        match &found.left {
            Left::Cycles { .. } => sticks_from_its_start(one, twin),
            Left::Once(_) => twin,
        }
    });
    let twins: Vec<Twin> = mended.collect();
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
    finding.plausible().then_some((finding, found))
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

/// The same with more Coulomb friction, if it takes more to stop the shaft once: a simulated run starts at speed, and where friction
/// has fallen by then a shaft may turn on evenly as well as stick. How much more does not show in the slips.
fn sticks_from_its_start(one: &Recorded, twin: Twin) -> Twin {
    let more = |factor: f64| {
        let mut more = twin.clone();
        more.shaft.coulomb_n_m *= factor;
        more
    };
    let sticks = |twin: &Twin| again(one, twin, 1).is_some_and(|run| slips(&run).is_some());
    let all = [1.0, 2.0, 4.0, 8.0, 16.0].map(more);
    all.into_iter().find(sticks).unwrap_or(twin)
}

/// A run of a twin with other noise, read as its recording was; none where it can't be run.
pub(super) fn again(one: &Recorded, twin: &Twin, seed: u64) -> Option<Recorded> {
    // Errors that the twin draws are those of its seed.
    let other = Twin {
        seed: twin.seed.wrapping_add(seed),
        ..twin.clone()
    };
    let rows = Simulation::new(&other)
        .ok()?
        .map(|event| Ok::<_, PlanError>(event.row));
    Some(Recorded {
        file: one.file.clone(),
        plan: one.plan,
        track: Track::of(one.plan, twin.timer.clock_hz, rows).ok()?,
        twin: other,
    })
}

fn looked_at(one: &Recorded) -> Option<Seen> {
    let twin = &one.twin;
    let wanders = matches!(twin.noise, Some(Noise::SpeedWander { .. }));
    if !matches!(twin.drive, Drive::Constant { .. }) || twin.stick_slip.is_some() || wanders {
        return None;
    }
    cycle_after_cycle(one, dampings(twin)).or_else(|| once(one))
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
        slips: 1,
        period_s: f64::INFINITY,
        text: format!(
            "The shaft stands until {:.3} s, breaks away and swings behind a spring; friction that falls with speed does not stop it \
             again. Coulomb friction only winds the spring up and can't be told from this recording.",
            found.at_s
        ),
        left: Left::Once(Box::new(slid(&law, &found.slide, found.at_s))),
    })
}

/// How a slide agrees with its law, which goes on by itself from the first edge.
fn slid(law: &SlideLaw, slide: &Slide, at_s: f64) -> Agreement {
    // A filter that learns nothing from any edge.
    let none = SlideNoise {
        acceleration: 0.0,
        stamp_s: 0.0,
        angle_rad: 1.0,
    };
    let after = law.white(slide, none).map(|(off, _)| off);
    let each = slide.ways.iter().zip(&slide.times_s);
    let before: Vec<f64> = each
        .map(|(way, time)| way - law.pull_rad_s * time)
        .collect();
    let times_s: Vec<f64> = slide.times_s.iter().map(|time| at_s + time).collect();
    once_agrees(&times_s, &before, &after.unwrap_or_default())
}

/// Damping of a twin's shaft, 1/s: without what pulls it towards the drive's speed, and with it.
pub(super) fn dampings(twin: &Twin) -> [(bool, f64); 2] {
    let shaft = &twin.shaft;
    let viscous = shaft.viscous_n_m_s / shaft.inertia_kg_m2;
    let stiff = shaft.stiffness_n_m_s / shaft.inertia_kg_m2;
    [(false, viscous), (true, viscous + stiff)]
}

/// A shaft that sticks and slips on and on, with one of two dampings.
pub(super) fn cycle_after_cycle(one: &Recorded, dampings: [(bool, f64); 2]) -> Option<Seen> {
    let slips = slips(one)?;
    let cycles = cycles(one, &slips)?;
    let (beside, damping, first) = fitted(&cycles, slips.pull_rad_s, dampings)?;
    let (pull_rad_s, pull_error) = pull(&first)?;
    let all = refitted(&first, pull_rad_s, damping);
    let mut squares: Vec<f64> = all
        .iter()
        .map(|one| one.1.squares / one.0.ways.len() as f64)
        .collect();
    squares.sort_by(f64::total_cmp);
    let usual = *squares.get(squares.len() / 2)?;
    let good = unspoilt(&all, usual);
    if good.len() < SLIPS_LEAST {
        return None;
    }
    let shared = Law::of(&good, pull_rad_s, damping);
    let errors = shared
        .errors
        .map(|error| error.hypot(pull_error / pull_rad_s));
    let law = SlipLaw {
        spring: shared.logs[0].exp(),
        drop: shared.logs[1].exp(),
        over_rad_s: shared.logs[2].exp(),
        damping,
        pull_rad_s,
        waves: Vec::new(),
    };
    let slip = law.slip()?;
    let early = unspoilt(&all[..(FITTED * all.len() / PARTS)], usual);
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
        slips: good.len(),
        period_s: whole / pull_rad_s,
        text: format!(
            "The shaft stands and slips: {} slips of {:.2} degrees, one every {:.3} s. Coulomb friction only winds the spring up \
             and can't be told from this recording.",
            slips.ends.len(),
            whole.to_degrees(),
            whole / pull_rad_s
        ),
        left: Left::Cycles {
            law: shared,
            early: (early.len() > 1).then(|| Law::of(&early, pull_rad_s, damping)),
        },
    })
}

/// Slips without those that are far off the usual square: what a defect or a lost edge spoils says nothing.
fn unspoilt<'a>(all: &'a [(&'a Cycle, Fitted)], usual: f64) -> Vec<(&'a Cycle, &'a Fitted)> {
    let good = all
        .iter()
        .filter(|(cycle, fit)| fit.squares < 8.0 * usual * cycle.ways.len() as f64);
    good.map(|(cycle, fit)| (*cycle, fit)).collect()
}
