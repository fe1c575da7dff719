//! Effects of one place: torques that come and go at instants, and bumps of the disc.

use rayon::prelude::*;

use super::Bank;
use super::groups::{all_and_each, by_speed};
use crate::diagnose::bench::Bench;
use crate::diagnose::effect::{Carrier, Effect, Growth, On, Site};
use crate::diagnose::filter::SIDE_BY_SIDE;
use crate::diagnose::lsq::dot;
use crate::diagnose::model::Board;
use crate::diagnose::nearby::Left;
use crate::diagnose::record::PLACES;
use crate::diagnose::scan::{Candidate, evidence};

/// Bumps whose gain is worked out exactly: others beside them share edges with them, which the folded score does not see.
const EXACT: usize = 12;
/// Widths of bumps, edges: from a single one on, each about twice the one before.
const WIDTHS: [f64; 10] = [0.7, 1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 96.0, 192.0, 384.0];

/// A torque from an instant of one recording on, with its white column.
#[derive(Clone, Debug)]
pub struct Step {
    from_s: f64,
    effect: Effect,
    column: Vec<f64>,
}

/// An effect from one instant until another.
fn window(effect: Effect, from_s: f64, until_s: f64) -> Effect {
    let carrier = Carrier::Window(from_s, until_s);
    Effect { carrier, ..effect }
}

/// Steps that are tried, of each recording: one from before it on, the others even over it.
pub fn steps(board: &Board) -> Vec<Vec<Step>> {
    let several = board.benches.len() > 1;
    // A drive that nobody declared makes it where there is one: it is in the free course.
    let site = if board.undriven {
        Site::Drive
    } else {
        Site::Torque
    };
    let each = board.benches.iter().map(|bench| {
        let effect = |from_s: &f64| Effect {
            only: several.then_some(bench.place),
            ..Effect::new(site, Carrier::Window(*from_s, f64::INFINITY))
        };
        let first_s = bench.record.time_s.first().copied().unwrap_or(0.0);
        let seconds = bench.record.seconds();
        let later = (1..PLACES).map(|at| first_s + seconds * at as f64 / PLACES as f64);
        let all: Vec<f64> = std::iter::once(f64::NEG_INFINITY).chain(later).collect();
        let effects: Vec<Effect> = all.iter().map(effect).collect();
        let columns = board.columns_of(&effects).into_iter();
        let each = all.into_iter().zip(effects).zip(columns);
        each.map(|((from_s, effect), mut column)| Step {
            from_s,
            effect,
            column: column.swap_remove(0),
        })
        .collect()
    });
    each.collect()
}

/// The two effects that explain most, by how much.
fn best_two(mut all: Vec<(f64, Effect)>) -> impl Iterator<Item = (f64, Effect)> {
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(2)
}

/// Torques that come at one instant and go at another: the best of all pairs of a grid of instants, of each recording.
pub fn loads(bank: &Bank, left: &Left<'_>) -> Vec<Candidate> {
    let each = bank.steps.iter().zip(&left.board.benches);
    let each = each.zip(left.scores(Site::Torque));
    each.flat_map(|((steps, bench), scores)| loads_of(steps, left, bench, scores))
        .collect()
}

/// The edge from which on a torque explains most, by about how much. What it explains is exact but for its square, which is that of the
/// grid's instants beside it.
fn sudden(bench: &Bench, scores: &[f64], site: Site, grid: &[(f64, f64)]) -> Option<(f64, f64)> {
    let course = &bench.course;
    let push = match site {
        Site::Drive => bench.plant.free(course).sensitivity(course, scores),
        _ => bench.plant.sensitivity(course, scores),
    };
    let mut later = 0.0;
    let gains = (1..push.len()).rev().filter_map(|at| {
        later += push[at];
        let from_s = course.time_s[at - 1];
        let next = grid.partition_point(|(time_s, _)| *time_s < from_s);
        let (before, after) = (grid.get(next.checked_sub(1)?)?, grid.get(next)?);
        let share = (from_s - before.0) / (after.0 - before.0);
        let square = before.1.powf(1.0 - share) * after.1.powf(share);
        let gain = later * later / (bench.plant.law.inertia.powi(2) * square);
        gain.is_finite().then_some((from_s, gain))
    });
    gains.reduce(|best, one| if one.1 > best.1 { one } else { best })
}

fn loads_of(steps: &[Step], left: &Left<'_>, bench: &Bench, of_edges: &[f64]) -> Vec<Candidate> {
    let [first, second, third, ..] = steps else {
        return Vec::new();
    };
    let cleared = steps.par_iter();
    let cleared = cleared.map(|step| left.basis.beside(&step.column));
    let columns: Vec<Vec<f64>> = cleared.collect();
    let each = columns.par_iter();
    let of_each = each.map(|column| (dot(column, left.white), dot(column, column)));
    let (scores, own): (Vec<f64>, Vec<f64>) = of_each.unzip();
    let gain = |(a, b): (usize, usize)| {
        let step = &steps[a];
        if a == b {
            // One that does not go again has to come.
            let gain = scores[a].powi(2) / own[a];
            return (own[a] > 0.0 && a > 0).then_some((gain, step.effect));
        }
        let both = own[a] + own[b];
        let square = both - 2.0 * dot(&columns[a], &columns[b]);
        let gain = (scores[a] - scores[b]).powi(2) / square;
        let effect = window(step.effect, step.from_s, steps[b].from_s);
        (square > 1e-9 * both && square > 0.0).then_some((gain, effect))
    };
    let count = steps.len();
    let pairs = (0..count).into_par_iter();
    let pairs = pairs.flat_map_iter(|a| (a..count).map(move |b| (a, b)));
    let best = best_two(pairs.filter_map(gain).collect());
    let half_s = 0.5 * (third.from_s - second.from_s);
    let near = best.map(|(gain, effect)| nearest(left, effect, gain, half_s));
    let mut found: Vec<Candidate> = near.collect();
    let grid = steps.iter().zip(&own).skip(1);
    let grid: Vec<(f64, f64)> = grid.map(|(step, own)| (step.from_s, *own)).collect();
    if let Some((from_s, gain)) = sudden(bench, of_edges, first.effect.site, &grid) {
        let effect = window(first.effect, from_s, f64::INFINITY);
        let interval_s = bench.record.seconds() / bench.record.len() as f64;
        found.push(nearest(left, effect, gain, interval_s));
    }
    found
}

/// A kind of bump that is looked for.
#[derive(Clone, Debug)]
pub struct Kind {
    /// A unit one anywhere.
    effect: Effect,
    /// Edges that it is on.
    on: On,
    /// Its width, edges.
    width: f64,
    /// Square of a unit one at an edge of the grid.
    square: f64,
    own: usize,
}

/// Kinds of bumps that are looked for. Of a disc of which nothing is known, only one that changes with the speed is not the disc's own.
pub fn kinds_of_bumps(board: &Board) -> Vec<Kind> {
    let record = board.benches.first().map(|bench| &bench.record);
    let Some(record) = record.filter(|record| record.edges >= 32) else {
        return Vec::new();
    };
    let edges = record.edges as f64;
    let flanks: &[Option<bool>] = &[None, Some(true), Some(false)];
    let sites: Vec<On> = if record.classes > 1 {
        let on = |channel| flanks.iter().map(move |&rises| On { channel, rises });
        all_and_each(board).flat_map(on).collect()
    } else {
        vec![On::ALL]
    };
    let mut growths = vec![Growth::Constant];
    if board.pattern.as_ref().is_some_and(|disc| !disc.known) {
        growths.extend(by_speed(board));
    }
    let widths = WIDTHS.into_iter().filter(|width| width * 6.0 <= edges);
    let kinds = widths.flat_map(|width| sites.iter().map(move |on| (*on, width)));
    let kinds = kinds.flat_map(|(on, width)| growths.iter().map(move |&by| (on, width, by)));
    let kinds: Vec<(On, f64, Growth)> = kinds.collect();
    let kind = |(on, width, growth): (On, f64, Growth)| {
        // A unit one is worth the same on each of its edges.
        let here = |slot: &usize| on.has(record.change_of(*slot));
        let (middle, last) = (record.edges as usize / 2, record.edges as usize);
        let own = (middle..last).find(here).unwrap_or(middle);
        let carrier = Carrier::Bump(record.angle_of(own), width * record.step_rad());
        let effect = Effect {
            growth,
            ..Effect::new(Site::Disc(on), carrier)
        };
        Kind {
            effect,
            on,
            width,
            square: 0.0,
            own,
        }
    };
    let mut kinds: Vec<Kind> = kinds.into_iter().map(kind).collect();
    kinds.par_chunks_mut(SIDE_BY_SIDE).for_each(|kinds| {
        let effects: Vec<Effect> = kinds.iter().map(|kind| kind.effect).collect();
        for (kind, column) in kinds.iter_mut().zip(board.columns_of(&effects)) {
            kind.square = dot(&column[0], &column[0]);
        }
    });
    kinds
}

/// Bumps of the disc: where the folded score stands out, for each width and each kind of edge.
pub fn bumps(bank: &Bank, left: &Left<'_>) -> Vec<Candidate> {
    let Some(first) = left.board.benches.first() else {
        return Vec::new();
    };
    let record = &first.record;
    let edges = record.edges;
    let mut growths: Vec<Growth> = Vec::new();
    for kind in &bank.bumps {
        if !growths.contains(&kind.effect.growth) {
            growths.push(kind.effect.growth);
        }
    }
    let folds = growths.iter().map(|growth| {
        let mut fold = vec![0.0; edges as usize];
        let scores = left.scores(Site::Disc(On::ALL));
        for (bench, scores) in left.board.benches.iter().zip(scores) {
            for (at, score) in scores.iter().enumerate() {
                let by = match growth {
                    Growth::Speed(power) => bench.course.speed[at].abs().powf(*power),
                    _ => 1.0,
                };
                fold[bench.record.slot(at)] += by * score;
            }
        }
        fold
    });
    let folds: Vec<Vec<f64>> = folds.collect();
    let pattern = left.board.pattern.as_ref();
    let known = pattern.and_then(|pattern| pattern.known_of_each(&left.board.benches));
    let known = known.unwrap_or_else(|| vec![1.0; edges as usize]);
    let best = |kind: &Kind| {
        let of = |growth: &Growth| *growth == kind.effect.growth;
        let fold = &folds[growths.iter().position(of).unwrap_or(0)];
        let reach = (3.0 * kind.width).ceil() as i64;
        let stride = (0.5 * kind.width).floor().max(1.0) as usize;
        let sums = |middle: i64| {
            let slots = (-reach..=reach).map(|by| (by, (middle + by).rem_euclid(edges) as usize));
            let there = slots.filter(|(_, slot)| kind.on.has(record.change_of(*slot)));
            there.fold((0.0, 0.0), |(score, square), (by, slot)| {
                let shape = (-0.5 * (by as f64 / kind.width).powi(2)).exp();
                let own = shape * shape * known[slot];
                (score + shape * fold[slot], square + own)
            })
        };
        let unit = kind.square / sums(kind.own as i64).1;
        let there = (0..edges)
            .step_by(stride)
            .filter(|slot| known[*slot as usize] > 0.0);
        let gains = there.map(|middle| {
            let (score, square) = sums(middle);
            let gain = score * score / (unit * square);
            (if gain.is_finite() { gain } else { 0.0 }, middle)
        });
        let best = gains.reduce(|best, one| if one.0 > best.0 { one } else { best });
        let (gain, middle) = best.unwrap_or_default();
        let middle_rad = record.angle_of(middle as usize);
        let carrier = Carrier::Bump(middle_rad, kind.width * record.step_rad());
        let effect = Effect {
            carrier,
            ..kind.effect
        };
        (gain, left.board.at_its_edge(&effect).unwrap_or(effect))
    };
    let shown = bank.bumps.par_iter().filter(|kind| kind.square > 0.0);
    let mut shown: Vec<(f64, Effect)> = shown.map(best).collect();
    shown.sort_by(|a, b| b.0.total_cmp(&a.0));
    shown.truncate(EXACT);
    let shown: Vec<Effect> = shown.into_iter().map(|(_, effect)| effect).collect();
    let exact = left.gains(&shown).into_iter().zip(shown);
    best_two(exact.collect())
        .map(|(gain, effect)| nearest(left, effect, gain, 0.5 * effect.knobs()[1]))
        .collect()
}

/// An effect with the best knobs of its carrier near its own, both of one unit, where it may be worth them.
fn nearest(left: &Left<'_>, effect: Effect, gain: f64, step: f64) -> Candidate {
    let as_it_is = Candidate::of(effect, gain);
    if left.board.at_its_edge(&effect) == Some(effect) {
        return as_it_is;
    }
    if evidence(left.board, gain, as_it_is.numbers()) < 0.0 {
        return as_it_is;
    }
    let reach = left.board.reach(&effect).into_iter().take(2);
    let least = 0.3 * reach.fold(f64::INFINITY, f64::min);
    let (near, there) = left.best_near(&effect, &[step; 2], least / step);
    // The way there goes by squares that are not its own.
    let here = left.gain(&effect);
    if there > here {
        Candidate::of(near, there)
    } else {
        Candidate::of(effect, here)
    }
}
