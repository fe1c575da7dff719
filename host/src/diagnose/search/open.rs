//! What the twins leave open, which is no finding: a drive that they do not declare, and a disc that they do not give.

use std::f64::consts::TAU;

use crate::diagnose::cells;
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::lsq::{Basis, dot};
use crate::diagnose::model::{Board, Model};

/// Part of the speed at which a disc was learned within which that speed is no other one.
const NEAR: f64 = 1e-3;
/// Changes of a drive that the twins do not declare, at the most.
pub const CHANGES: usize = 16;

/// Orders of a disc with many edges that may be as large as they like: what is off the centre, tilted or bent moves all edges of a part of
/// the turn alike. Of a disc with few edges the pattern alone takes that, as its size then is theirs.
const LOW: i64 = 8;

/// What nobody knows of any rig: the mean speed that an open-loop drive holds. Of a disc that the twins do not give, how far edges of a
/// class are off.
#[must_use]
pub fn nuisances(board: &Board) -> Model {
    let mut model = Model::default();
    if !board.disc_given {
        model.add_open(&cells::classes(board), usize::MAX);
        model.add_open(&beside_gaps(board), usize::MAX);
        let mut benches = board.benches.iter();
        if benches.all(|bench| bench.record.of_edges > 16 * LOW) {
            let orders = 1..=LOW;
            let orders = orders.map(|order| Carrier::Order(order as f64));
            let low: Vec<Effect> = orders
                .map(|order| Effect::new(Site::Disc(On::ALL), order))
                .collect();
            model.add_open(&low, usize::MAX);
        }
    }
    model.add_open(&past_learned(board), usize::MAX);
    let mut benches = board.benches.iter();
    if benches.any(|bench| bench.is_held() && bench.plant.law.mode.is_none()) {
        model.add_open(&[Effect::new(Site::Drive, Carrier::Steady)], usize::MAX);
    }
    if board.undriven {
        model.add_open(&turns_back(board), usize::MAX);
    }
    if board.is_looped() {
        model.add_open(&targets(board), usize::MAX);
    }
    model
}

/// Delays of edge classes at other speeds than the one at which the disc was learned.
#[must_use]
pub fn past_learned(board: &Board) -> Vec<Effect> {
    let learned = board.benches.iter();
    let r_min = learned
        .filter_map(|bench| bench.twin.errors.learned_r_min)
        .next();
    let Some(speed) = r_min.map(|r_min| r_min * TAU / 60.0) else {
        return Vec::new();
    };
    let away = |speed_now: &f64| (speed_now.abs() / speed - 1.0).abs() > NEAR;
    if !board
        .benches
        .iter()
        .any(|bench| bench.course.steady.iter().any(away))
    {
        return Vec::new();
    }
    let each = cells::classes(board).into_iter().map(|class| Effect {
        site: match class.site {
            Site::Disc(on) => Site::Stamp(on),
            site => site,
        },
        growth: Growth::Past(speed),
        ..class
    });
    each.collect()
}

/// The last edge before each gap and the first one behind it: the signal is another one there, and their errors are not of the others' size.
fn beside_gaps(board: &Board) -> Vec<Effect> {
    let Some(record) = board.benches.first().map(|bench| &bench.record) else {
        return Vec::new();
    };
    let seen = board.seen();
    let count = seen.len();
    let beside = (0..count).filter(|slot| {
        let (before, behind) = ((slot + count - 1) % count, (slot + 1) % count);
        seen[*slot] && !(seen[before] && seen[behind])
    });
    let each = beside.filter_map(|slot| {
        let on = On {
            channel: None,
            rises: (record.classes > 1).then(|| record.change_of(slot).rises),
        };
        let carrier = Carrier::Bump(record.angle_of(slot), 0.5 * record.step_rad());
        board.at_its_edge(&Effect::new(Site::Disc(on), carrier))
    });
    each.collect()
}

/// A speed loop that the twins do not declare keeps a speed that nobody knows exactly, and its integral begins anywhere.
fn targets(board: &Board) -> Vec<Effect> {
    let several = board.benches.len() > 1;
    let each = board.benches.iter().flat_map(|bench| {
        [Carrier::Steady, Carrier::Time].map(|carrier| Effect {
            only: several.then_some(bench.place),
            ..Effect::new(Site::Drive, carrier)
        })
    });
    each.collect()
}

/// A drive that the twins do not declare may turn back as suddenly as it likes, which looks like friction; where it does so often, only
/// friction does every time.
fn turns_back(board: &Board) -> Vec<Effect> {
    let several = board.benches.len() > 1;
    let each = board.benches.iter().flat_map(|bench| {
        let at = bench.course.reversals_s.iter();
        at.map(move |at_s| Effect {
            only: several.then_some(bench.place),
            ..Effect::new(Site::Drive, Carrier::Window(*at_s, f64::INFINITY))
        })
    });
    let all: Vec<Effect> = each.collect();
    if all.len() > CHANGES { Vec::new() } else { all }
}

/// What is open beside waves of a disc that the twins give. Such a wave moves each mark by where it is, and a mark with an error of its own is
/// not where it should be: by the grid the wave jumps from edge to edge where the marks are unevenly apart, as no shaft does. Told by
/// those jumps a slow wave would be known far better than it is. So they are open where they are most of what shows it.
pub fn own_errors(board: &Board, model: &Model, effects: &[Effect]) -> Vec<Effect> {
    let mut discs = board.benches.iter().map(|bench| &bench.disc);
    if !board.disc_given || discs.all(|disc| disc.iter().all(|error| *error == 0.0)) {
        return Vec::new();
    }
    let waves = effects.iter().filter(|effect| {
        let wave = matches!(effect.carrier, Carrier::Order(_));
        wave && effect.is_of_disc()
    });
    let own = waves.map(|wave| Effect {
        growth: Growth::Own,
        ..*wave
    });
    own.filter(|own| model.terms.iter().all(|term| term.effect != *own))
        .filter(|own| jumps_show(board, own))
        .collect()
}

/// Whether most of what shows a wave of the disc is what its marks' own errors make of it.
fn jumps_show(board: &Board, own: &Effect) -> bool {
    let wave = Effect {
        growth: Growth::Constant,
        ..*own
    };
    let jumps = board.columns(own);
    let jumps: Vec<&[f64]> = jumps.iter().map(Vec::as_slice).collect();
    let basis = Basis::of(&jumps);
    let (mut all, mut smooth) = (0.0, 0.0);
    for mut column in board.columns(&wave) {
        all += dot(&column, &column);
        basis.clear(&mut column);
        smooth += dot(&column, &column);
    }
    smooth < 0.5 * all
}

/// Whether effects are of what the twins leave open, and so no findings: a drive that they do not declare may change at any instant, and
/// gives way with the speed as friction does where that hardly changes; a disc that they do not give may have any errors.
pub fn is_open(board: &Board, effects: &[Effect]) -> bool {
    let drags = board.undriven && board.speed_spread() < cells::SPEEDS;
    if drags && effects.iter().all(Effect::is_friction) {
        return true;
    }
    effects.iter().all(|effect| {
        let changes = effect.site.pushes() && matches!(effect.carrier, Carrier::Window(..));
        board.undriven && changes || !board.disc_given && effect.is_of_disc()
    })
}

/// Whether an effect is an angle that swings more slowly than the shaft turns, as its course does under a drive of which nothing is known.
pub fn is_course(effect: &Effect) -> bool {
    let slow = matches!(effect.carrier, Carrier::Order(order) if order < 1.0);
    slow && matches!(effect.site, Site::Disc(_))
}

/// Effects of what the twins leave open as they enter: a torque of an unknown drive makes the course, which nothing damps.
pub fn left_open(board: &Board, effects: &[Effect]) -> Vec<Effect> {
    let each = effects.iter().map(|effect| match effect.site {
        Site::Torque if board.undriven => Effect {
            site: Site::Drive,
            ..*effect
        },
        _ => *effect,
    });
    each.collect()
}

/// A model with effects as a finding, or as what the twins leave open.
#[must_use]
pub fn with(board: &Board, model: &Model, effects: &[Effect], group: usize) -> Model {
    let mut model = model.clone();
    if is_open(board, effects) {
        model.add_open(&left_open(board, effects), group);
    } else {
        model.add(effects, group);
        model.add_open(&own_errors(board, &model, effects), group);
    }
    model
}
