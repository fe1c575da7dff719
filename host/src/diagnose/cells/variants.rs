//! What an effect that was found may be instead: the same with more numbers, or at another site.

use std::f64::consts::TAU;

use super::groups::{by_speed, has_classes};
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::model::Board;

/// How many harmonics of an order, itself included, are tried at once.
const HARMONICS: [u32; 4] = [3, 4, 6, 8];

/// The same frequency at other sites, along the angle as well as along the time, of constant size; of a torque with harmonics as
/// well, where it is so loud that they count as noise.
pub fn elsewhere(board: &Board, own: &[Effect], loud: bool) -> Vec<Vec<Effect>> {
    let [effect] = own else { return Vec::new() };
    let turns_a_s = board.fastest() / TAU;
    let (order, tone) = match effect.carrier {
        Carrier::Order(order) => (order, order * turns_a_s),
        Carrier::Tone(tone) => (tone / turns_a_s, tone),
        _ => return Vec::new(),
    };
    let whole = order.round();
    let reach = board.reach(&Effect::new(Site::Torque, Carrier::Order(order)))[0];
    let order = if whole > 0.0 && (order - whole).abs() < reach {
        whole
    } else {
        order
    };
    let mut all = vec![
        (Site::Torque, Carrier::Order(order)),
        (Site::Disc(On::ALL), Carrier::Order(order)),
        (Site::Torque, Carrier::Tone(tone)),
    ];
    if has_classes(board) {
        all.push((Site::Level(On::ALL), Carrier::Tone(tone)));
    }
    let images = board.nearest_images(effect).into_iter();
    all.extend(images.map(|image| (image.site, image.carrier)));
    let of = |(site, carrier): (Site, Carrier)| Effect {
        site,
        carrier,
        growth: Growth::Constant,
        ..*effect
    };
    let same = |other: &Effect| {
        other.site == effect.site
            && other.growth == effect.growth
            && std::mem::discriminant(&other.carrier) == std::mem::discriminant(&effect.carrier)
            && !board.nearest_images(effect).contains(other)
    };
    let each = all.into_iter().map(of).flat_map(|other| {
        let mut each = if loud {
            harmonics(board, &[other])
        } else {
            Vec::new()
        };
        if !same(&other) {
            each.push(vec![other]);
        }
        each
    });
    each.collect()
}

/// The same effect with sizes that go with time or speed, to be fitted in its place.
pub fn grown(board: &Board, own: &[Effect]) -> Vec<Vec<Effect>> {
    let [effect] = own else { return Vec::new() };
    let place = matches!(effect.carrier, Carrier::Bump(..));
    if effect.sizes() < 2 && !place || effect.growth != Growth::Constant {
        return Vec::new();
    }
    let rate = 1.0 / board.seconds();
    let mut growths = vec![Growth::Even(rate), Growth::Even(-0.5 * rate)];
    growths.extend(by_speed(board));
    let each = growths.into_iter();
    let each = each.map(|growth| Effect { growth, ..*effect });
    each.filter(Effect::is_possible)
        .map(|grown| vec![grown])
        .collect()
}

/// The same along the angle, where a frequency is that of whole turns or of every two of them: what is so by chance is no pick-up.
pub fn synchronous(board: &Board, own: &[Effect]) -> Option<Effect> {
    let [effect] = own else { return None };
    let Carrier::Tone(tone) = effect.carrier else {
        return None;
    };
    let order = tone * TAU / board.fastest();
    let exact = 0.5 * (2.0 * order).round();
    let carrier = Carrier::Order(exact);
    let reach = board.reach(&Effect { carrier, ..*effect })[0];
    (exact > 0.0 && (order - exact).abs() < reach).then_some(Effect { carrier, ..*effect })
}

/// The same effect with harmonics of its order: what pushes once in a part of a turn, or of two turns, is no sine.
pub fn harmonics(board: &Board, own: &[Effect]) -> Vec<Vec<Effect>> {
    let [
        Effect {
            site: Site::Torque,
            carrier: Carrier::Order(order),
            growth: Growth::Constant,
            ..
        },
    ] = own
    else {
        return Vec::new();
    };
    let effect = own[0];
    // What comes every two turns has all odd halves.
    let half = order.floor() + 0.5;
    let of_two_turns = (order - half).abs() < board.reach(&effect)[0] && order.fract() != 0.0;
    let nth = |nth: u32| match of_two_turns {
        true => f64::from(nth) - 0.5,
        false => order * f64::from(nth),
    };
    let each = board.benches.iter().map(|bench| bench.record.edges as f64);
    let most = 0.5 * each.fold(0.0, f64::max);
    let of = |count: u32| {
        let each = (1..=count).map(|times| Effect {
            carrier: Carrier::Order(nth(times)),
            ..effect
        });
        each.collect()
    };
    let counts = HARMONICS.into_iter();
    counts.filter(|count| nth(*count) < most).map(of).collect()
}
