//! One case: what is drawn, how large it is made, and what the truth says.

use serde_json::{Value, json};

use super::effects::{self, CATALOGUE};
use super::family::Family;
use super::hidden::{look_alike, masked};
use super::kind::Kind;
use super::limits::plausible;
use super::outside;
use super::record::{happens_once, record, undeclared};
use super::rigs::{Shape, rigs};
use super::settle::settle;
use crate::capture::Row;
use crate::effect::Effect;
use crate::ideal::{DETECTABLE, Ideal, is_variance, shows_play};
use crate::random::Dice;
use crate::rig::{Profile, Rig};

/// Sizes of effects, in those that the ideal detector needs.
const TIMES: [f64; 4] = [3.0, 5.0, 10.0, 30.0];
/// Draws of a rig before the effect is made smaller.
const DRAWS: usize = 25;

/// A case ready to be written.
#[derive(Clone, Debug)]
pub struct Case {
    /// A rig and its recording, for each run.
    pub runs: Vec<(Rig, Vec<Row>)>,
    /// The sealed truth.
    pub truth: Value,
}

/// An effect with its size in those that the ideal detector needs.
#[derive(Clone, Debug)]
pub(super) struct Sized {
    pub(super) effect: Effect,
    pub(super) times: f64,
    pub(super) distance: f64,
    pub(super) ideal: f64,
    pub(super) separation: Option<f64>,
}

/// What a case is made of.
pub(super) struct Drawn {
    pub(super) rigs: Vec<Rig>,
    pub(super) effects: Vec<Sized>,
    /// Ids that this recording can't tell apart.
    pub(super) alike: Vec<&'static str>,
    /// RMS of the pattern over that of the effect.
    pub(super) mask: Option<f64>,
}

/// Draws a case. The same seed, kind and number give the same case.
#[must_use]
pub fn case(seed: u64, place: usize, kind: Kind, number: usize) -> Case {
    again(seed, place, None, (kind, number), 0)
}

/// The case as [`case`] draws it, or one of a family; its torque noise and jitter drawn anew where `again` is not 0.
#[must_use]
pub fn again(
    seed: u64,
    place: usize,
    family: Option<Family>,
    (kind, number): (Kind, usize),
    again: u64,
) -> Case {
    let own = Dice::new(seed, 1 + place as u64).seed();
    let mut dice = Dice::new(own, 0);
    for attempt in 0.. {
        let Some(mut drawn) = draw(&mut dice, family, (kind, number), attempt) else {
            continue;
        };
        let noise = dice.seed();
        if settle(&mut drawn, noise).is_none() {
            continue;
        }
        if let Some(case) = record(&drawn, kind, own, noise) {
            let mut case = match again {
                0 => case,
                _ => with_other_noise(&drawn, kind, own, Dice::new(noise, again)).unwrap_or(case),
            };
            if let Some(family) = family {
                case.truth["family"] = json!(family.name());
                case.truth["undeclared"] = json!(undeclared(&drawn.rigs));
            }
            return case;
        }
    }
    unreachable!("a smaller effect fits in the end")
}

/// What was drawn, recorded with the first noise that makes a recording of use.
fn with_other_noise(drawn: &Drawn, kind: Kind, own: u64, mut dice: Dice) -> Option<Case> {
    (0..DRAWS).find_map(|_| record(drawn, kind, own, dice.seed()))
}

fn draw(
    dice: &mut Dice,
    family: Option<Family>,
    (kind, number): (Kind, usize),
    attempt: usize,
) -> Option<Drawn> {
    // Sizes take turns with effects, so that each effect meets each size. What never fits is tried smaller.
    let size = (number / CATALOGUE.len() + number) % TIMES.len();
    let times = TIMES[size.saturating_sub(attempt / DRAWS)];
    let mut drawn = Drawn {
        rigs: Vec::new(),
        effects: Vec::new(),
        alike: Vec::new(),
        mask: None,
    };
    if let Some(family) = family {
        family.draw(dice, &mut drawn, (kind, number), attempt)?;
        return Some(drawn);
    }
    match kind {
        Kind::One => {
            let id = CATALOGUE[number % CATALOGUE.len()];
            let shape = effects::shape(dice, id);
            drawn.rigs = rigs(dice, shape, |encoder| effects::fits(id, encoder));
            if id == "stick_slip" {
                slow_down(&mut drawn.rigs[0], dice.log_between(0.2, 2.0));
            }
            add(dice, &mut drawn, id, times)?;
        }
        Kind::Several => several(dice, &mut drawn, attempt)?,
        Kind::Masked => masked(dice, &mut drawn, number, times)?,
        Kind::Loop => {
            let ids = [
                "eccentricity",
                "disc_tilt",
                "torque_ripple",
                "gear_mesh",
                "torque_tone",
            ];
            drawn.rigs = rigs(dice, Shape::Loops, |encoder| encoder.edges() >= 400);
            add(dice, &mut drawn, ids[number % ids.len()], times.max(10.0))?;
        }
        Kind::LookAlike => look_alike(dice, &mut drawn, number)?,
        Kind::Nothing => {
            let shape = dice.pick(&[
                Shape::Constant,
                Shape::TwoSpeeds,
                Shape::Ramp,
                Shape::Reversal,
                Shape::RunDown,
                Shape::Loops,
            ]);
            drawn.rigs = rigs(dice, shape, |e| shape != Shape::Loops || e.edges() >= 400);
        }
        Kind::Outside => {
            let which = (number % outside::COUNT as usize) as u32;
            let edges = |encoder: crate::encoder::Encoder| encoder.edges() >= 200;
            drawn.rigs = rigs(dice, outside::shape(which), edges);
            let effect = outside::effect(dice, which, &drawn.rigs);
            let times = if attempt < DRAWS { 30.0 } else { 10.0 };
            let sized = sized(&drawn.rigs, &effect, times)?;
            drawn.effects.push(sized);
        }
    }
    if drawn.effects.iter().any(needs_noise) {
        drawn.rigs.iter_mut().for_each(|rig| rig.noise_known = true);
    }
    Some(drawn)
}

fn needs_noise(sized: &Sized) -> bool {
    matches!(
        sized.effect,
        Effect::TimestampJitter { .. }
            | Effect::CaptureLatency { .. }
            | Effect::BurstNoise { .. }
            | Effect::TorsionalResonance { .. }
    )
}

/// The rig at another constant speed, all else in proportion.
fn slow_down(rig: &mut Rig, to: f64) {
    let share = to / rig.profile.top();
    rig.profile = Profile::Constant { speed: to };
    rig.longest_s /= share;
    rig.noise_psd *= share * share;
    for ripple in &mut rig.ripples {
        ripple.torque_n_m *= share * share;
    }
}

/// Adds an effect of an id.
pub(super) fn add(dice: &mut Dice, drawn: &mut Drawn, id: &str, times: f64) -> Option<()> {
    let effect = effects::effect(dice, id, &drawn.rigs);
    drawn.effects.push(sized(&drawn.rigs, &effect, times)?);
    Some(())
}

/// The effect made so many times as large as the ideal detector needs; none where a rig can't have it. That of a play is set when
/// its recording is made, by [`settle`].
pub(super) fn sized(rigs: &[Rig], effect: &Effect, times: f64) -> Option<Sized> {
    if shows_play(effect, rigs) {
        return Some(Sized {
            times,
            distance: DETECTABLE * times,
            ideal: effect.size() / times,
            separation: None,
            effect: effect.clone(),
        });
    }
    let seen = if happens_once(effect) {
        &rigs[..1]
    } else {
        rigs
    };
    let ideal = Ideal::of(seen, effect);
    let (effect, times, ideal_size) = match effect.clone() {
        Effect::LostEdges { seed, .. } => {
            let count = times as u32;
            (Effect::LostEdges { count, seed }, times, 1.0)
        }
        Effect::ExtraEdges { seed, .. } => {
            let count = times as u32;
            (Effect::ExtraEdges { count, seed }, times, 1.0)
        }
        Effect::IndexSlip { at_s, edges } => {
            let edges = edges * times as i32;
            (Effect::IndexSlip { at_s, edges }, times, 1.0)
        }
        whole @ (Effect::ClosedLoop { .. } | Effect::StickSlip { .. }) => {
            // It has no size to scale: it is as large as what it does here.
            let times = ideal.distance(&whole) / DETECTABLE;
            if times.is_nan() || times < 3.0 {
                return None;
            }
            let size = whole.size() / times;
            (whole, times, size)
        }
        other => {
            let factor = ideal.factor(&other)?;
            let size = other.size() * factor;
            (other.scaled(factor * times), times, size)
        }
    };
    if !plausible(&effect, rigs) {
        return None;
    }
    // Counts have no signal: each event is a whole edge.
    let counted = effect.size() == 0.0;
    let distance = if counted {
        DETECTABLE * times
    } else {
        ideal.distance(&effect)
    };
    // Where d' does not grow with the size as it should, the size means nothing.
    let power = if is_variance(&effect) { 2.0 } else { 1.0 };
    let expected = DETECTABLE * times.powf(power);
    if !(0.7..1.4).contains(&(distance / expected)) {
        return None;
    }
    Some(Sized {
        times,
        distance,
        ideal: ideal_size,
        separation: ideal.separation(&effect),
        effect,
    })
}

fn several(dice: &mut Dice, drawn: &mut Drawn, attempt: usize) -> Option<()> {
    let mut ids = [
        "eccentricity",
        "disc_tilt",
        "local_defect",
        "edge_delay",
        "channel_skew",
        "width_error",
        "threshold_ripple",
        "torque_ripple",
        "gear_mesh",
        "torque_tone",
        "load_step",
        "timestamp_jitter",
        "lost_edges",
    ];
    dice.shuffle(&mut ids);
    let count = dice.whole(2, 3) as usize;
    drawn.rigs = rigs(dice, Shape::TwoSpeeds, |encoder| {
        ids[..count].iter().all(|id| effects::fits(id, encoder))
    });
    for id in &ids[..count] {
        let times = if attempt < DRAWS {
            dice.pick(&[10.0, 30.0])
        } else {
            10.0
        };
        add(dice, drawn, id, times)?;
    }
    Some(())
}
