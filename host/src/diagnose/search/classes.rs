//! Steady effects of edge classes, which are one finding with others of their kind.

use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::model::Model;
use crate::diagnose::name;
use crate::mechanism::Mechanism;

/// Steady effects of edge classes that a finding has in part already are one finding with it, channel by channel: its group, and the model
/// with all of its effects. Falls of a channel whose rises it has are another one, of the channel; effects of another kind are one as well.
pub fn joined(model: &Model, effects: &[Effect], channels: u8) -> (usize, Model) {
    // Classes of two names are two findings.
    let named = |effect: &Effect| name::mechanism(std::slice::from_ref(effect));
    let same = |effect: &&Effect| named(effect) == named(&effects[0]);
    let (own, others): (Vec<&Effect>, Vec<&Effect>) = effects.iter().partition(same);
    if !others.is_empty() && steady(effects) {
        let [own, others] = [own, others].map(|all| all.into_iter().copied().collect::<Vec<_>>());
        let (group, model) = joined(model, &own, channels);
        return (group, joined(&model, &others, channels).1);
    }
    let alone = |effects: &[Effect]| (model.unused(), model.with(effects, model.unused()));
    let Some(other) = joins(model, effects) else {
        return alone(effects);
    };
    let each = |effects: &[Effect]| -> Vec<Effect> {
        let each = effects.iter();
        each.flat_map(|effect| by_channel(*effect, channels))
            .collect()
    };
    let mut all = each(&model.effects(other));
    let (before, mut apart) = (all.len(), Vec::new());
    for effect in each(effects) {
        if all.iter().any(|other| is_opposite(other, &effect)) {
            apart.push(on_edges(effect, |on| On { rises: None, ..on }));
        } else if !all.contains(&effect) {
            all.push(effect);
        }
    }
    if all.len() == before && !apart.is_empty() {
        // All channels alike are no effect.
        if apart.len() == usize::from(channels) {
            apart.remove(0);
        }
        return alone(&apart);
    }
    (other, model.without(other).with(&all, other))
}

/// The finding of a model with which steady effects of edge classes are one.
#[must_use]
pub fn joins(model: &Model, effects: &[Effect]) -> Option<usize> {
    let named = name::mechanism(effects);
    if !steady(effects) || named == Mechanism::Unknown {
        return None;
    }
    model.groups().into_iter().find(|other| {
        let own = model.effects(*other);
        steady(&own) && name::mechanism(&own) == named
    })
}

/// Whether effects are always there as they are.
fn steady(effects: &[Effect]) -> bool {
    let mut each = effects.iter();
    each.all(|effect| effect.carrier == Carrier::Steady && effect.growth == Growth::Constant)
}

/// The edges that an effect of a class is of.
const fn edges_of(effect: &Effect) -> Option<On> {
    match effect.site {
        Site::Stamp(on) | Site::Disc(on) => Some(on),
        _ => None,
    }
}

/// The same effect on other edges.
fn on_edges(effect: Effect, change: impl Fn(On) -> On) -> Effect {
    let site = match effect.site {
        Site::Stamp(on) => Site::Stamp(change(on)),
        Site::Disc(on) => Site::Disc(change(on)),
        other => other,
    };
    Effect { site, ..effect }
}

/// Whether one is of the rises and the other of the falls of the same channel: both together are one of them and the channel as a whole.
fn is_opposite(one: &Effect, other: &Effect) -> bool {
    let same_site = std::mem::discriminant(&one.site) == std::mem::discriminant(&other.site);
    let (Some(one), Some(other)) = (edges_of(one), edges_of(other)) else {
        return false;
    };
    let both = one.rises.is_some() && other.rises.is_some();
    same_site && both && one.channel == other.channel && one.rises != other.rises
}

/// An effect on all channels as one on each.
fn by_channel(effect: Effect, channels: u8) -> Vec<Effect> {
    match edges_of(&effect) {
        Some(On { channel: None, .. }) => (0..channels)
            .map(|channel| {
                let channel = Some(channel);
                on_edges(effect, |on| On { channel, ..on })
            })
            .collect(),
        _ => vec![effect],
    }
}
