//! Cells of the map that have no frequency: few, and evaluated as they are.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::effect::{Carrier, Effect, Growth, On, Site};
use super::lsq::{Basis, dot};
use super::model::{Board, Fit};
use super::nearby::Left;
use super::scan::{Candidate, evidence};

/// How many harmonics of an order, itself included, are tried at once.
const HARMONICS: [u32; 4] = [3, 4, 6, 8];
/// Instants at which steps are tried.
const INSTANTS: usize = 32;
/// Shares of the longest recording that settling is tried with.
const SETTLINGS: [f64; 4] = [0.03, 0.08, 0.2, 0.5];
/// Shares of the top speed that Stribeck's is looked for at.
const STRIBECK: [f64; 5] = [0.05, 0.1, 0.2, 0.35, 0.6];
/// Bumps that are looked at closely.
const BUMPS: usize = 2;
/// Widths of bumps, edges.
const WIDTHS: [f64; 10] = [0.7, 1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 96.0, 192.0, 384.0];
/// Spread of the speed, as a share of it, from which on a size that grows with it can be told from one that does not.
pub const SPEEDS: f64 = 0.05;

/// White columns of the cells that are always tried: they hang on the noise alone, so they are worked out once for many looks.
#[derive(Clone, Debug)]
pub struct Bank {
    groups: Vec<Vec<Effect>>,
    effects: Vec<Effect>,
    columns: Vec<Vec<f64>>,
    steps: Vec<Vec<Step>>,
    bumps: Vec<(On, f64, f64)>,
}

/// A torque from an instant of one recording on.
#[derive(Clone, Debug)]
struct Step {
    from_s: f64,
    only: Option<u8>,
    /// A drive that nobody declared makes it where there is one: it is in the free course.
    site: Site,
    column: Vec<f64>,
}

impl Step {
    /// The torque until another one comes.
    const fn until(&self, until_s: f64) -> Effect {
        Effect {
            only: self.only,
            ..Effect::new(self.site, Carrier::Window(self.from_s, until_s))
        }
    }
}

impl Bank {
    /// Of a board.
    #[must_use]
    pub fn new(board: &Board) -> Self {
        use rayon::prelude::*;
        let groups = steady(board);
        let mut effects: Vec<Effect> = Vec::new();
        for effect in groups.iter().flatten() {
            if !effects.contains(effect) {
                effects.push(*effect);
            }
        }
        let columns = effects
            .par_iter()
            .map(|effect| board.columns(effect).swap_remove(0))
            .collect();
        let several = board.benches.len() > 1;
        let steps = board.benches.iter().map(|bench| {
            let only = several.then_some(bench.place);
            let step = |from_s: f64| {
                let mut step = Step {
                    from_s,
                    only,
                    site: if board.undriven {
                        Site::Drive
                    } else {
                        Site::Torque
                    },
                    column: Vec::new(),
                };
                step.column = board.columns(&step.until(f64::INFINITY)).swap_remove(0);
                step
            };
            instants(bench).into_par_iter().map(step).collect()
        });
        let steps = steps.collect();
        Self {
            groups,
            effects,
            columns,
            steps,
            bumps: kinds_of_bumps(board),
        }
    }

    /// What each group explains beside a fit.
    #[must_use]
    pub fn candidates(&self, fit: &Fit, basis: &Basis) -> Vec<Candidate> {
        use rayon::prelude::*;
        let cleared: Vec<Vec<f64>> = self
            .columns
            .par_iter()
            .map(|column| {
                let mut column = column.clone();
                basis.clear(&mut column);
                column
            })
            .collect();
        let none = Basis::default();
        self.groups
            .par_iter()
            .map(|effects| {
                let at = effects
                    .iter()
                    .filter_map(|effect| self.effects.iter().position(|own| own == effect));
                let at: Vec<usize> = at.collect();
                // What is none of its own beside the model says nothing.
                let own = at.iter().all(|&at| {
                    dot(&cleared[at], &cleared[at])
                        > 1e-7 * dot(&self.columns[at], &self.columns[at])
                });
                let columns: Vec<&[f64]> = at.iter().map(|&at| cleared[at].as_slice()).collect();
                let gain = if own {
                    none.gain(&columns, &fit.left)
                } else {
                    0.0
                };
                Candidate {
                    effects: effects.clone(),
                    gain,
                }
            })
            .collect()
    }
}

/// Instants at which steps are tried, from before a recording on.
fn instants(bench: &Bench) -> Vec<f64> {
    let times = &bench.record.time_s;
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Vec::new();
    };
    let at = |at: usize| match at {
        0 => f64::NEG_INFINITY,
        _ => first + (last - first) * at as f64 / INSTANTS as f64,
    };
    (0..INSTANTS).map(at).collect()
}

/// Sizes and knobs of effects.
#[must_use]
pub fn numbers(effects: &[Effect]) -> usize {
    let each = effects.iter();
    each.map(|effect| effect.sizes() + effect.knobs().len())
        .sum()
}

/// A board's channels.
#[must_use]
pub fn channels(board: &Board) -> u8 {
    board
        .benches
        .iter()
        .map(|bench| bench.record.channels())
        .max()
        .unwrap_or(1)
}

/// How far edges of a class are off those of the first one: of each channel, and of its falls.
#[must_use]
pub fn classes(board: &Board) -> Vec<Effect> {
    let classes = board.benches.iter().map(|bench| bench.record.classes);
    let flanks = classes.max().unwrap_or(1) > 1;
    let steady = |channel: u8, rises: Option<bool>| {
        let channel = Some(channel);
        Effect::new(Site::Disc(On { channel, rises }), Carrier::Steady)
    };
    let channels = 1..channels(board);
    let mut all: Vec<Effect> = channels.map(|channel| steady(channel, None)).collect();
    if flanks {
        all.extend((0..self::channels(board)).map(|channel| steady(channel, Some(false))));
    }
    all
}

/// Groups of effects that are tried as they are.
#[must_use]
pub fn steady(board: &Board) -> Vec<Vec<Effect>> {
    let channels = channels(board);
    let classes = board
        .benches
        .iter()
        .map(|bench| bench.record.classes)
        .max()
        .unwrap_or(1);
    let one = |site: Site, carrier: Carrier| vec![Effect::new(site, carrier)];
    let on = |channel: Option<u8>, rises: Option<bool>| On { channel, rises };
    let each = |make: &dyn Fn(u8) -> Effect, from: u8| -> Vec<Effect> {
        (from..channels).map(make).collect()
    };
    let mut all: Vec<Vec<Effect>> = Vec::new();
    let mut group = |effects: Vec<Effect>| {
        if effects.len() > 1 {
            all.extend(effects.iter().map(|effect| vec![*effect]));
            if effects.len() > 2 {
                for left_out in 0..effects.len() {
                    let mut some = effects.clone();
                    some.remove(left_out);
                    all.push(some);
                }
            }
        }
        if !effects.is_empty() {
            all.push(effects);
        }
    };
    let steady = |site: Site| Effect::new(site, Carrier::Steady);
    if classes > 1 {
        group(each(&|c| steady(Site::Disc(on(Some(c), Some(false)))), 0));
        group(each(&|c| steady(Site::Stamp(on(Some(c), Some(true)))), 0));
        if channels > 1 {
            group(each(&|c| steady(Site::Stamp(on(Some(c), Some(false)))), 0));
            group(vec![steady(Site::Disc(on(None, Some(false))))]);
            group(vec![steady(Site::Stamp(on(None, Some(true))))]);
            group(each(&|c| steady(Site::Disc(on(Some(c), None))), 1));
            group(each(&|c| steady(Site::Stamp(on(Some(c), None))), 1));
        }
    }
    if board
        .benches
        .iter()
        .any(|bench| !bench.course.reversals_s.is_empty())
    {
        all.push(one(Site::Disc(On::ALL), Carrier::Direction));
        if channels > 1 {
            all.extend(
                (0..channels).map(|c| one(Site::Disc(on(Some(c), None)), Carrier::Direction)),
            );
        }
    }
    all.extend(friction(board));
    let longest = board.seconds();
    let driven = board
        .benches
        .iter()
        .any(|bench| bench.is_held() && bench.twin.speed_loop().is_none());
    if driven {
        all.push(one(Site::Drive, Carrier::Time));
        all.extend(
            SETTLINGS.map(|share| one(Site::Drive, Carrier::Settling(0.0, share * longest))),
        );
    }
    if classes > 1 {
        let mut sites = vec![None];
        if channels > 1 {
            sites.extend((0..channels).map(Some));
        }
        for channel in sites {
            let site = Site::Level(on(channel, None));
            for share in [0.05, 0.2, 0.5] {
                for from in [0.0, 0.25, 0.5] {
                    all.push(one(
                        site,
                        Carrier::Settling(from * longest, share * longest),
                    ));
                }
            }
        }
    }
    all
}

/// Kinds of friction, where the speed changes enough to show them. About one speed all that they do is to damp what noise makes, and noise
/// that is not white is damped in its own way.
fn friction(board: &Board) -> Vec<Vec<Effect>> {
    if !board.undriven && board.speed_spread() < SPEEDS {
        return Vec::new();
    }
    let mut all: Vec<Vec<Effect>> = Vec::new();
    let power = |p: f64| Effect::new(Site::Torque, Carrier::Power(p));
    let top = board
        .benches
        .iter()
        .map(|bench| bench.course.top())
        .fold(0.0, f64::max);
    for some in [
        vec![0.0],
        vec![1.0],
        vec![2.0],
        vec![0.0, 1.0],
        vec![0.0, 2.0],
        vec![1.0, 2.0],
        vec![0.0, 1.0, 2.0],
    ] {
        all.push(some.into_iter().map(power).collect());
    }
    let least = board
        .benches
        .iter()
        .flat_map(|bench| &bench.course.speed)
        .fold(f64::INFINITY, |least, speed| least.min(speed.abs()));
    // It has to show somewhere.
    let shows = |share: &f64| least < 2.0 * share * top;
    for share in STRIBECK.into_iter().filter(shows) {
        let stribeck = Effect::new(Site::Torque, Carrier::Stribeck(share * top));
        all.push(vec![stribeck]);
        all.push(vec![power(0.0), stribeck]);
        all.push(vec![power(0.0), power(1.0), stribeck]);
    }
    all
}

/// The same frequency at other sites, along the angle as well as along the time, of constant size; of a torque with harmonics as
/// well, where it is so loud that they count as noise.
#[must_use]
pub fn elsewhere(board: &Board, own: &[Effect], loud: bool) -> Vec<Vec<Effect>> {
    let [effect] = own else { return Vec::new() };
    let speed = board.benches.iter().map(|bench| bench.course.mean());
    let turns_a_s = speed.fold(0.0, f64::max) / TAU;
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
    if board.benches.iter().any(|bench| bench.record.classes > 1) {
        all.push((Site::Level(On::ALL), Carrier::Tone(tone)));
    }
    all.extend(
        board
            .images(effect)
            .into_iter()
            .map(|image| (image.site, image.carrier)),
    );
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
            && !board.images(effect).contains(other)
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
    if effect.sizes() < 2 || effect.growth != Growth::Constant {
        return Vec::new();
    }
    let rate = 1.0 / board.seconds();
    let mut growths = vec![Growth::Even(rate), Growth::Even(-0.5 * rate)];
    if board.speed_spread() > SPEEDS {
        growths.extend([Growth::Speed(1.0), Growth::Speed(-1.0)]);
    }
    let each = growths.into_iter();
    each.map(|growth| vec![Effect { growth, ..*effect }])
        .collect()
}

/// The same effect with harmonics of its order: what pushes once in a part of a turn is no sine.
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
    let each = board.benches.iter().map(|bench| bench.record.edges as f64);
    let most = 0.5 * each.fold(0.0, f64::max) / order;
    let of = |count: u32| {
        let each = (1..=count).map(|times| Effect {
            carrier: Carrier::Order(order * f64::from(times)),
            ..effect
        });
        each.collect()
    };
    let counts = HARMONICS.into_iter();
    counts
        .filter(|count| f64::from(*count) < most)
        .map(of)
        .collect()
}

/// Torques that come at one instant and go at another: the best of all pairs of a grid of instants, of each recording.
#[must_use]
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
    let mut best: Option<(f64, f64)> = None;
    for at in (1..push.len()).rev() {
        later += push[at];
        let from_s = course.time_s[at - 1];
        let next = grid.partition_point(|(time_s, _)| *time_s < from_s);
        let (Some(after), Some(before)) = (grid.get(next), grid.get(next.wrapping_sub(1))) else {
            continue;
        };
        let share = (from_s - before.0) / (after.0 - before.0);
        let square = before.1.powf(1.0 - share) * after.1.powf(share);
        let gain = later * later / (bench.plant.law.inertia.powi(2) * square);
        if gain.is_finite() && best.is_none_or(|(_, most)| gain > most) {
            best = Some((from_s, gain));
        }
    }
    best
}

fn loads_of(steps: &[Step], left: &Left<'_>, bench: &Bench, of_edges: &[f64]) -> Vec<Candidate> {
    use rayon::prelude::*;
    if steps.len() < 3 {
        return Vec::new();
    }
    let cleared = steps.par_iter().map(|step| {
        let mut column = step.column.clone();
        left.basis.clear(&mut column);
        column
    });
    let columns: Vec<Vec<f64>> = cleared.collect();
    let scores: Vec<f64> = columns
        .iter()
        .map(|column| dot(column, left.white))
        .collect();
    let count = steps.len();
    let pairs: Vec<(usize, usize)> = (0..count)
        .flat_map(|a| (a..count).map(move |b| (a, b)))
        .collect();
    let products: Vec<f64> = pairs
        .par_iter()
        .map(|(a, b)| dot(&columns[*a], &columns[*b]))
        .collect();
    let own = |at: usize| products[pairs.partition_point(|pair| *pair < (at, at))];
    let mut best: Vec<(f64, Effect)> = Vec::new();
    for (&(a, b), product) in pairs.iter().zip(&products) {
        if a == b {
            if own(a) > 0.0 && a > 0 {
                best.push((scores[a].powi(2) / own(a), steps[a].until(f64::INFINITY)));
            }
            continue;
        }
        let square = own(a) + own(b) - 2.0 * product;
        if square > 1e-9 * (own(a) + own(b)) && square > 0.0 {
            let gain = (scores[a] - scores[b]).powi(2) / square;
            best.push((gain, steps[a].until(steps[b].from_s)));
        }
    }
    best.sort_by(|a, b| b.0.total_cmp(&a.0));
    best.truncate(2);
    let step = steps[2].from_s - steps[1].from_s;
    let mut found: Vec<Candidate> = best
        .into_iter()
        .map(|(gain, effect)| nearest(left, effect, gain, 0.5 * step))
        .collect();
    let grid: Vec<(f64, f64)> = (1..count).map(|at| (steps[at].from_s, own(at))).collect();
    if let Some((from_s, gain)) = sudden(bench, of_edges, steps[0].site, &grid) {
        let one = Step {
            from_s,
            column: Vec::new(),
            ..steps[0]
        };
        let interval_s = bench.record.seconds() / bench.record.len() as f64;
        found.push(nearest(left, one.until(f64::INFINITY), gain, interval_s));
    }
    found
}

/// Kinds of bumps that are looked for: the edges that they are on, and their width, rad, with the squares of a unit one.
fn kinds_of_bumps(board: &Board) -> Vec<(On, f64, f64)> {
    let Some(first) = board.benches.first() else {
        return Vec::new();
    };
    let edges = first.record.edges as f64;
    if edges < 32.0 {
        return Vec::new();
    }
    let mut sites = vec![On::ALL];
    if first.record.classes > 1 {
        sites.extend([true, false].map(|rises| On {
            channel: None,
            rises: Some(rises),
        }));
        if channels(board) > 1 {
            for channel in 0..channels(board) {
                sites.push(On {
                    channel: Some(channel),
                    rises: None,
                });
                sites.extend([true, false].map(|rises| On {
                    channel: Some(channel),
                    rises: Some(rises),
                }));
            }
        }
    }
    let widths = WIDTHS
        .into_iter()
        .filter(|width| width * 6.0 <= edges)
        .map(|width| width * first.record.step_rad());
    let kinds: Vec<(On, f64)> = widths
        .flat_map(|width| sites.iter().map(move |on| (*on, width)))
        .collect();
    use rayon::prelude::*;
    kinds
        .into_par_iter()
        .map(|(on, width)| {
            // A unit one is worth the same on each of its edges.
            let here = |slot: &usize| on.has(first.record.change_of(*slot));
            let (middle, last) = (first.record.edges as usize / 2, first.record.edges as usize);
            let own = (middle..last).find(here).unwrap_or(middle);
            let angle = first.record.angle_of(own);
            let column = board
                .columns(&Effect::new(Site::Disc(on), Carrier::Bump(angle, width)))
                .swap_remove(0);
            (on, width, dot(&column, &column))
        })
        .collect()
}

/// Bumps of the disc: where the folded score stands out, for each width and each kind of edge.
#[must_use]
pub fn bumps(bank: &Bank, left: &Left<'_>) -> Vec<Candidate> {
    let Some(first) = left.board.benches.first() else {
        return Vec::new();
    };
    let edges = first.record.edges;
    let mut fold = vec![0.0; edges as usize];
    for (bench, scores) in left
        .board
        .benches
        .iter()
        .zip(left.scores(Site::Disc(On::ALL)))
    {
        for (at, score) in scores.iter().enumerate() {
            fold[bench.record.slot(at)] += score;
        }
    }
    let step = first.record.step_rad();
    use rayon::prelude::*;
    let mut found: Vec<(f64, Effect)> = bank
        .bumps
        .par_iter()
        .filter(|(.., square)| *square > 0.0)
        .map(|(on, width, square)| {
            let width_edges = width / step;
            let reach = (3.0 * width_edges).ceil() as i64;
            let mut best = (0.0, 0);
            let stride = (0.5 * width_edges).floor().max(1.0) as usize;
            for middle in (0..edges).step_by(stride) {
                let mut sum = 0.0;
                for by in -reach..=reach {
                    let slot = (middle + by).rem_euclid(edges) as usize;
                    if on.has(first.record.change_of(slot)) {
                        sum += (-0.5 * (by as f64 / width_edges).powi(2)).exp() * fold[slot];
                    }
                }
                if sum * sum / square > best.0 {
                    best = (sum * sum / square, middle);
                }
            }
            (
                best.0,
                Effect::new(
                    Site::Disc(*on),
                    Carrier::Bump(first.record.angle_of(best.1 as usize), *width),
                ),
            )
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(BUMPS);
    found
        .into_iter()
        .map(|(gain, effect)| nearest(left, effect, gain, 0.5 * effect.knobs()[1]))
        .collect()
}

/// An effect with the best knobs near its own, all of one unit, where it may be worth them.
fn nearest(left: &Left<'_>, effect: Effect, gain: f64, step: f64) -> Candidate {
    let as_it_is = Candidate {
        effects: vec![effect],
        gain,
    };
    if evidence(left.board, gain, as_it_is.numbers()) < 0.0 {
        return as_it_is;
    }
    let reach = left.board.reach(&effect).into_iter();
    let least = 0.3 * reach.fold(f64::INFINITY, f64::min);
    let steps = vec![step; effect.knobs().len()];
    let (effect, gain) = left.best_near(&effect, &steps, least / step);
    Candidate {
        effects: vec![effect],
        gain,
    }
}
