//! Groups of steady effects that are tried as they are.

use std::ops::Range;

use crate::diagnose::bench::Bench;
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::model::Board;
use crate::effect::STEEPEST;
use crate::twin::Drive;

/// Spread of the speed, as a share of it, from which on a size that grows with it can be told from one that does not.
pub const SPEEDS: f64 = 0.05;

/// How a size may go with the speed, where the speed changes; what grows as it falls would be infinite where the shaft turns round.
pub(super) fn by_speed(board: &Board) -> Vec<Growth> {
    let mut growths = Vec::new();
    if board.speed_spread() > SPEEDS {
        growths.push(Growth::Speed(1.0));
        growths.extend((!turns_round(board)).then_some(Growth::Speed(-1.0)));
    }
    growths
}

/// Sizes and knobs of effects.
pub fn numbers(effects: &[Effect]) -> usize {
    let each = effects.iter();
    each.map(|effect| effect.sizes() + effect.knobs().len())
        .sum()
}

/// A board's channels.
pub fn channels(board: &Board) -> u8 {
    let each = board.benches.iter().map(|bench| bench.record.channels());
    each.max().unwrap_or(1)
}

/// Whether a board has edges of more than one class.
pub fn has_classes(board: &Board) -> bool {
    board.benches.iter().any(|bench| bench.record.classes > 1)
}

/// All edges, and where there are several channels those of each.
pub(super) fn all_and_each(board: &Board) -> impl Iterator<Item = Option<u8>> {
    let channels = channels(board);
    let each = 0..if channels > 1 { channels } else { 0 };
    std::iter::once(None).chain(each.map(Some))
}

fn on(channel: Option<u8>, rises: Option<bool>) -> On {
    On { channel, rises }
}

/// A steady effect on each of some channels.
fn steadies(site: fn(On) -> Site, rises: Option<bool>, channels: Range<u8>) -> Vec<Effect> {
    let site = |channel| site(on(Some(channel), rises));
    let each = channels.map(site);
    each.map(|site| Effect::new(site, Carrier::Steady))
        .collect()
}

/// How far edges of a class are off those of the first one: of each channel, and of its falls.
pub fn classes(board: &Board) -> Vec<Effect> {
    let mut all = steadies(Site::Disc, None, 1..channels(board));
    if has_classes(board) {
        all.extend(steadies(Site::Disc, Some(false), 0..channels(board)));
    }
    all
}

/// A comparator's level off the middle of its signal: the channel is narrower about its middle, which puts its falls off against its
/// rises, and these against the other channels.
fn off_the_middle(channel: u8, channels: u8) -> Vec<Effect> {
    let others = match channel {
        0 => 1..channels,
        own => own..own + 1,
    };
    let mut all = steadies(Site::Disc, Some(false), channel..channel + 1);
    all.extend(steadies(Site::Disc, None, others));
    all
}

/// Effects one by one, all but one, and all.
fn some_of(effects: Vec<Effect>) -> Vec<Vec<Effect>> {
    let mut all = Vec::new();
    if effects.len() > 1 {
        all.extend(effects.iter().map(|effect| vec![*effect]));
    }
    if effects.len() > 2 {
        all.extend((0..effects.len()).map(|left_out| {
            let mut some = effects.clone();
            some.remove(left_out);
            some
        }));
    }
    if !effects.is_empty() {
        all.push(effects);
    }
    all
}

/// Groups of effects that are tried as they are.
pub fn steady(board: &Board) -> Vec<Vec<Effect>> {
    let channels = channels(board);
    let has_classes = has_classes(board);
    let one = |site: Site, carrier: Carrier| vec![Effect::new(site, carrier)];
    let mut all: Vec<Vec<Effect>> = Vec::new();
    if has_classes {
        all.extend(some_of(steadies(Site::Disc, Some(false), 0..channels)));
        all.extend(some_of(steadies(Site::Stamp, Some(true), 0..channels)));
    }
    if has_classes && channels > 1 {
        all.extend(some_of(steadies(Site::Stamp, Some(false), 0..channels)));
        all.push(one(Site::Disc(on(None, Some(false))), Carrier::Steady));
        all.push(one(Site::Stamp(on(None, Some(true))), Carrier::Steady));
        all.extend(some_of(steadies(Site::Disc, None, 1..channels)));
        all.extend(some_of(steadies(Site::Stamp, None, 1..channels)));
        all.extend((0..channels).map(|channel| off_the_middle(channel, channels)));
    }
    if has_classes && by_speed(board).contains(&Growth::Speed(-1.0)) {
        // A level beside a signal that is larger the faster the shaft turns, as a pick-up coil's is.
        let level = |channel| Effect {
            growth: Growth::Speed(-1.0),
            ..Effect::new(Site::Level(on(channel, None)), Carrier::Steady)
        };
        all.extend(all_and_each(board).map(|channel| vec![level(channel)]));
    }
    if turns_round(board) {
        let sites = all_and_each(board).map(|channel| Site::Disc(on(channel, None)));
        all.extend(sites.map(|site| one(site, Carrier::Direction)));
    }
    all.extend(friction(board));
    // What settles goes by shares of the longest recording.
    let longest = board.seconds();
    let settling = |from: f64, share: f64| Carrier::Settling(from * longest, share * longest);
    let mut benches = board.benches.iter();
    if benches.any(|bench| bench.is_held() && bench.twin.speed_loop().is_none()) {
        all.push(one(Site::Drive, Carrier::Time));
        all.extend([0.03, 0.08, 0.2, 0.5].map(|share| one(Site::Drive, settling(0.0, share))));
        let keeps_one = |bench: &Bench| matches!(bench.twin.drive, Drive::Constant { .. });
        if board.speed_spread() > SPEEDS && !board.benches.iter().all(keeps_one) {
            // A load that the drive knows nothing of. Of recordings at one speed each it is a drive that is off by a part of its speed.
            let load = Effect::new(Site::Torque, Carrier::Steady);
            let powers = (1..=STEEPEST as u32).map(f64::from).map(Growth::Speed);
            all.extend(powers.map(|growth| vec![Effect { growth, ..load }]));
        }
    }
    if has_classes {
        for channel in all_and_each(board) {
            for share in [0.05, 0.2, 0.5] {
                let level = |from| one(Site::Level(on(channel, None)), settling(from, share));
                all.extend([0.0, 0.25, 0.5].map(level));
                // A delay of all edges is none that edges show.
                let stamp = one(Site::Stamp(on(channel, None)), settling(0.0, share));
                all.extend(channel.map(|_| stamp));
            }
        }
    }
    all
}

/// Whether the shaft turns round in any recording.
fn turns_round(board: &Board) -> bool {
    let mut benches = board.benches.iter();
    benches.any(|bench| !bench.course.reversals_s.is_empty())
}

/// Kinds of friction, where the speed changes enough to show them. About one speed, one way, all that they do is to damp what noise makes,
/// and noise that is not white is damped in its own way.
fn friction(board: &Board) -> Vec<Vec<Effect>> {
    if !board.undriven && board.speed_spread() < SPEEDS && !turns_round(board) {
        return Vec::new();
    }
    let power = |p: f64| Effect::new(Site::Torque, Carrier::Power(p));
    let mut all = some_of([0.0, 1.0, 2.0].map(power).to_vec());
    let tops = board.benches.iter().map(|bench| bench.course.top());
    let top = tops.fold(0.0, f64::max);
    let speeds = board.benches.iter().flat_map(|bench| &bench.course.speed);
    let least = speeds.fold(f64::INFINITY, |least, speed| least.min(speed.abs()));
    // Stribeck's speed, as a share of the top one, has to show somewhere.
    for share in [0.05, 0.1, 0.2, 0.35, 0.6] {
        if least < 2.0 * share * top {
            let stribeck = Effect::new(Site::Torque, Carrier::Stribeck(share * top));
            all.push(vec![stribeck]);
            all.push(vec![power(0.0), stribeck]);
            all.push(vec![power(0.0), power(1.0), stribeck]);
        }
    }
    all
}
