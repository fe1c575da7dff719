//! One case: what is drawn, how large it is made, and what the truth says.

use serde_json::{Value, json};

use super::effects::{self, CATALOGUE};
use super::kind::Kind;
use super::limits::plausible;
use super::outside;
use super::rigs::{Shape, rigs};
use crate::capture::{Row, rows};
use crate::effect::Effect;
use crate::ideal::{DETECTABLE, Ideal, changed, is_variance};
use crate::random::Dice;
use crate::rig::{Profile, Rig};
use crate::turning::turn;

/// Sizes of effects, in those that the ideal detector needs.
const TIMES: [f64; 4] = [3.0, 5.0, 10.0, 30.0];
/// What separates look-alikes, as d', stays below this.
const ALIKE: f64 = 1.5;
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
struct Sized {
    effect: Effect,
    times: f64,
    distance: f64,
    ideal: f64,
    separation: Option<f64>,
}

struct Drawn {
    rigs: Vec<Rig>,
    effects: Vec<Sized>,
    /// Ids that this recording can't tell apart.
    alike: Vec<&'static str>,
    /// RMS of the pattern over that of the effect.
    mask: Option<f64>,
}

/// Draws a case. The same seed, kind and number give the same case.
#[must_use]
pub fn case(seed: u64, place: usize, kind: Kind, number: usize) -> Case {
    let own = Dice::new(seed, 1 + place as u64).seed();
    let mut dice = Dice::new(own, 0);
    for attempt in 0.. {
        let Some(drawn) = draw(&mut dice, kind, number, attempt) else {
            continue;
        };
        if let Some(case) = record(&drawn, kind, own, dice.seed()) {
            return case;
        }
    }
    unreachable!("a smaller effect fits in the end")
}

fn draw(dice: &mut Dice, kind: Kind, number: usize, attempt: usize) -> Option<Drawn> {
    // Sizes take turns with effects, so that each effect meets each size. What never fits is tried smaller.
    let size = (number / CATALOGUE.len() + number) % TIMES.len();
    let times = TIMES[size.saturating_sub(attempt / DRAWS)];
    let mut drawn = Drawn {
        rigs: Vec::new(),
        effects: Vec::new(),
        alike: Vec::new(),
        mask: None,
    };
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

fn add(dice: &mut Dice, drawn: &mut Drawn, id: &str, times: f64) -> Option<()> {
    let effect = effects::effect(dice, id, &drawn.rigs);
    drawn.effects.push(sized(&drawn.rigs, &effect, times)?);
    Some(())
}

/// The effect made so many times as large as the ideal detector needs; none where a rig can't have it.
fn sized(rigs: &[Rig], effect: &Effect, times: f64) -> Option<Sized> {
    let seen = if happens_once(effect) {
        &rigs[..1]
    } else {
        rigs
    };
    let ideal = Ideal::new(seen);
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

fn masked(dice: &mut Dice, drawn: &mut Drawn, number: usize, times: f64) -> Option<()> {
    let known = number.is_multiple_of(2);
    // What is locked to the turn is part of a pattern that the twin does not give.
    let ids: &[&str] = if known {
        &[
            "eccentricity",
            "local_defect",
            "torque_ripple",
            "gear_mesh",
            "edge_delay",
            "threshold_ripple",
        ]
    } else {
        &[
            "torque_ripple",
            "gear_mesh",
            "torque_tone",
            "edge_delay",
            "threshold_ripple",
        ]
    };
    let id = ids[(number / 2) % ids.len()];
    drawn.rigs = rigs(dice, Shape::TwoSpeeds, |encoder| {
        encoder.edges() >= 200 && effects::fits(id, encoder)
    });
    for rig in &mut drawn.rigs {
        rig.disc_known = known;
    }
    add(dice, drawn, id, times.max(5.0))?;
    let rms = Ideal::new(&drawn.rigs).rms(&drawn.effects[0].effect);
    let ratio = dice.log_between(10.0, 100.0);
    let step = drawn.rigs[0].encoder.step_rad();
    // White from edge to edge as far as edges keep their order, the rest in smooth low orders.
    let white = (0.7 * ratio * rms).min(0.04 * step);
    let smooth = ((ratio * rms).powi(2) - white * white).sqrt();
    if smooth > 0.03 {
        return None;
    }
    let orders: Vec<(f64, f64)> = (0..8)
        .map(|_| (dice.normal(), dice.between(0.0, std::f64::consts::TAU)))
        .collect();
    let power: f64 = orders.iter().map(|(a, _)| 0.5 * a * a).sum();
    let scale = smooth / power.sqrt();
    let pattern: Vec<f64> = (0..drawn.rigs[0].encoder.edges())
        .map(|k| {
            let grid = drawn.rigs[0].grid_rad(k);
            let low = orders
                .iter()
                .zip(1..)
                .map(|((a, phase), order)| scale * a * libm::sin(f64::from(order) * grid - phase));
            white * dice.normal().clamp(-4.0, 4.0) + low.sum::<f64>()
        })
        .collect();
    for rig in &mut drawn.rigs {
        rig.disc_rad.clone_from(&pattern);
    }
    drawn.mask = Some(ratio);
    Some(())
}

fn look_alike(dice: &mut Dice, drawn: &mut Drawn, number: usize) -> Option<()> {
    let pairs: [(&str, &[&str]); 7] = [
        ("eccentricity", &["eccentricity", "torque_ripple"]),
        ("torque_ripple", &["eccentricity", "torque_ripple"]),
        ("disc_tilt", &["disc_tilt", "torque_ripple"]),
        ("torque_tone", &["torque_tone", "gear_mesh", "bearing"]),
        ("gear_mesh", &["torque_tone", "gear_mesh", "bearing"]),
        ("width_error", &["width_error", "edge_delay"]),
        ("edge_delay", &["width_error", "edge_delay"]),
    ];
    let both: [(&str, &[&str]); 3] = [
        ("quadrature_error", &["quadrature_error", "channel_skew"]),
        ("hysteresis", &["hysteresis", "backlash"]),
        ("backlash", &["hysteresis", "backlash"]),
    ];
    let (id, alike) = *pairs.iter().chain(&both).nth(number % 10)?;
    let shape = if alike[0] == "hysteresis" {
        Shape::Reversal
    } else {
        Shape::Constant
    };
    drawn.rigs = rigs(dice, shape, |e| e.edges() >= 200 && effects::fits(id, e));
    // A known ripple pushes a shaft that is off its angle, not a disc that is: at orders where noise is small that tells them apart.
    drawn.rigs[0].ripples.clear();
    let times = dice.pick(&[3.0, 5.0, 10.0]);
    let mut effect = effects::effect(dice, id, &drawn.rigs);
    if let Effect::TorqueRipple(order) = &mut effect {
        order.order = 1.0;
    }
    if let Effect::WidthError { rad } = &mut effect {
        *rad = [rad[0]; 3];
    }
    // Wander tells fixed frequency from fixed order and both from fixed angle: it must be too small for that.
    let order = match &effect {
        Effect::TorqueTone { f_hz, .. } => {
            std::f64::consts::TAU * f_hz / drawn.rigs[0].profile.top()
        }
        Effect::GearMesh(order) => order.order,
        _ => 2.0,
    };
    let rig = &drawn.rigs[0];
    let speed = rig.profile.top();
    let correlation = speed / rig.damping(true);
    let way = std::f64::consts::TAU * rig.turns;
    let phase = rig.wander(speed) * (2.0 * correlation * way).sqrt() * order;
    let allowed = 1.0 / (DETECTABLE * times);
    if shape == Shape::Constant && phase > allowed {
        let share = (allowed / phase).powi(2);
        drawn.rigs.iter_mut().for_each(|rig| rig.noise_psd *= share);
    }
    let sized = sized(&drawn.rigs, &effect, times)?;
    if sized.separation.is_some_and(|apart| apart > ALIKE) {
        return None;
    }
    drawn.effects.push(sized);
    drawn.alike = alike.to_vec();
    Some(())
}

/// Whether an effect happens at a time: then in the first recording only.
const fn happens_once(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::LostEdges { .. } | Effect::ExtraEdges { .. } | Effect::LoadStep { .. }
    )
}

/// Makes the recordings; none where one is no use.
fn record(drawn: &Drawn, kind: Kind, seed: u64, noise: u64) -> Option<Case> {
    let mut runs = Vec::new();
    let mut events = Vec::new();
    for (number, rig) in drawn.rigs.iter().enumerate() {
        let effects: Vec<Effect> = (drawn.effects.iter())
            .map(|sized| sized.effect.clone())
            .filter(|effect| number == 0 || !happens_once(effect))
            .collect();
        let real = effects.iter().fold(rig.clone(), |rig, e| changed(&rig, e));
        let course = turn(&real, &effects, Some(noise ^ number as u64));
        let (rows, at) = rows(&course, &real, &effects, noise ^ number as u64);
        let slow = course.speeds.0 <= 0.05 * rig.profile.top();
        let sticks = |e: &Effect| matches!(e, Effect::StickSlip { .. });
        let turns_back = matches!(rig.profile, Profile::Ramp { to, .. } if to < 0.0)
            || effects.iter().any(sticks);
        if (slow && !turns_back) || rows.len() > 200_000 || rows.len() < 100 {
            return None;
        }
        events.extend(at);
        runs.push((rig.clone(), rows));
    }
    let mechanisms: Vec<Value> = drawn
        .effects
        .iter()
        .map(|s| mechanism(s, &events))
        .collect();
    let verdict = match kind {
        Kind::Nothing => "complete",
        Kind::LookAlike => "ambiguous",
        Kind::Outside => "unknown",
        _ => "explained",
    };
    let first = &drawn.rigs[0];
    let speeds: Vec<f64> = drawn.rigs.iter().map(|rig| rig.profile.top()).collect();
    let truth = json!({
        "version": 1,
        "kind": kind.name(),
        "seed": seed,
        "verdict": verdict,
        "mechanisms": mechanisms,
        "indistinguishable": drawn.alike,
        "disc_known": first.disc_known,
        "mask_ratio": drawn.mask,
        "recordings": drawn.rigs.len(),
        "speeds_rad_s": speeds,
        "noise": {
            "known": first.noise_known,
            "torque_psd_n2_m2_s": first.noise_psd,
            "wander_fraction": first.wander(first.profile.top()),
            "jitter_s": first.jitter_s,
        },
    });
    Some(Case { runs, truth })
}

fn mechanism(sized: &Sized, events: &[f64]) -> Value {
    let effect = &sized.effect;
    let mut parameters = effect.parameters();
    if matches!(effect, Effect::LostEdges { .. } | Effect::ExtraEdges { .. }) {
        parameters.insert("times_s".to_owned(), json!(events));
    }
    json!({
        "id": effect.id(),
        "physics": effect.physics(),
        "same_physics": effect.same_physics(),
        "parameters": parameters,
        "times_ideal": sized.times,
        "ideal_size": sized.ideal,
        "d_prime": sized.distance,
        "separation_d_prime": sized.separation,
        "recording": happens_once(effect).then_some(1),
    })
}
