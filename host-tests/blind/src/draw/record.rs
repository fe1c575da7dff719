//! Recordings of what was drawn, and the truth about them.

use serde_json::{Value, json};

use super::case::{Case, Drawn, Sized};
use super::kind::Kind;
use crate::capture::rows;
use crate::effect::Effect;
use crate::encoder::Encoder;
use crate::ideal::changed;
use crate::rig::{Profile, Rig, Told};
use crate::turning::{Course, turn};

/// Whether an effect happens at a time: then in the first recording only.
pub(super) const fn happens_once(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::LostEdges { .. } | Effect::ExtraEdges { .. } | Effect::LoadStep { .. }
    )
}

/// One run of what was drawn, as it is recorded.
pub(super) struct Run {
    /// The rig that really turns.
    real: Rig,
    effects: Vec<Effect>,
    pub(super) course: Course,
}

/// Turns the rig of a number with its effects and noise.
pub(super) fn run(drawn: &Drawn, number: usize, noise: u64) -> Run {
    let effects: Vec<Effect> = (drawn.effects.iter())
        .map(|sized| sized.effect.clone())
        .filter(|effect| number == 0 || !happens_once(effect))
        .collect();
    let rig = drawn.rigs[number].clone();
    let real = effects.iter().fold(rig, |rig, e| changed(&rig, e));
    let course = turn(&real, &effects, Some(noise ^ number as u64));
    Run {
        real,
        effects,
        course,
    }
}

/// Makes the recordings; none where one is no use.
pub(super) fn record(drawn: &Drawn, kind: Kind, seed: u64, noise: u64) -> Option<Case> {
    let mut runs = Vec::new();
    let mut events = Vec::new();
    for (number, rig) in drawn.rigs.iter().enumerate() {
        let Run {
            real,
            effects,
            course,
        } = run(drawn, number, noise);
        let (rows, at) = rows(&course, &real, &effects, noise ^ number as u64);
        let slow = course.speeds.0 <= 0.05 * rig.profile.top();
        let sticks = |e: &Effect| matches!(e, Effect::StickSlip { .. });
        let turns_back = rig.profile.reverses() || effects.iter().any(sticks);
        if (slow && !turns_back) || rows.len() > 200_000 || rows.len() < 100 {
            return None;
        }
        events.extend(at);
        runs.push((rig.clone(), rows));
    }
    let mechanisms: Vec<Value> = drawn
        .effects
        .iter()
        .map(|s| mechanism(s, &events, drawn.rigs[0].encoder))
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

fn mechanism(sized: &Sized, events: &[f64], encoder: Encoder) -> Value {
    let effect = &sized.effect;
    let mut parameters = effect.parameters();
    if matches!(effect, Effect::LostEdges { .. } | Effect::ExtraEdges { .. }) {
        parameters.insert("times_s".to_owned(), json!(events));
    }
    if let (Effect::LineError { .. }, Some(pattern)) = (effect, effect.disc(encoder)) {
        // What can be measured is the pattern that was drawn, not what it was drawn from.
        let squares: f64 = pattern.iter().map(|e| e * e).sum();
        let rms = (squares / pattern.len() as f64).sqrt();
        parameters.insert("pattern_rms_rad".to_owned(), json!(rms));
    }
    let mut value = json!({
        "id": effect.id(),
        "physics": effect.physics(),
        "same_physics": effect.same_physics(),
        "parameters": parameters,
        "times_ideal": sized.times,
        "ideal_size": sized.ideal,
        "d_prime": sized.distance,
        "separation_d_prime": sized.separation,
        "recording": happens_once(effect).then_some(1),
    });
    if let Effect::Cell(cell) = effect {
        value["site"] = json!(cell.site.name());
        value["carrier"] = json!(cell.carrier.name());
        value["near"] = json!(cell.near());
    }
    value
}

/// Ids of what the rig has, beside the effects, and the twin does not give.
pub(super) fn undeclared(rigs: &[Rig]) -> Vec<&'static str> {
    let any = |has: &dyn Fn(&Rig) -> bool| rigs.iter().any(has);
    let mut ids = Vec::new();
    let mut add = |there: bool, more: &[&'static str]| {
        if there {
            ids.extend_from_slice(more);
        }
    };
    let bare = |rig: &Rig| rig.told == Told::InertiaOnly;
    add(
        any(&|rig| !rig.disc_known),
        &[
            "line_error",
            "width_error",
            "quadrature_error",
            "eccentricity",
            "disc_tilt",
            "local_defect",
        ],
    );
    add(any(&|rig| !rig.noise_known), &["timestamp_jitter"]);
    add(
        any(&|rig| bare(rig) && !rig.ripples.is_empty()),
        &["torque_ripple"],
    );
    add(
        any(&|rig| bare(rig) && rig.viscous + rig.coulomb > 0.0),
        &["friction"],
    );
    let looped = |rig: &Rig| matches!(rig.profile, Profile::Loop { .. });
    add(any(&|rig| bare(rig) && looped(rig)), &["closed_loop"]);
    ids
}
