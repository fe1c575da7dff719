//! The mismatch map: how much of the residual each site explains, following each carrier.
//!
//! One transposed run of the filter gives what one rad at each edge would add to the likelihood; spectra of that over angle and over
//! time score all orders and frequencies at once, for angles as they are and for torques through the shaft's answer. Cells without a
//! frequency are few and are evaluated as they are.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::bench::Bench;
use super::cells::{self, SPEEDS};
use super::edges::median;
use super::effect::{Carrier, Effect, Growth, On, Site};
use super::lsq;
use super::model::{Board, Model};
use super::nearby::Left;
use super::sweep;

/// A cell of the map with how much it explains.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Effects that are one finding.
    pub effects: Vec<Effect>,
    /// By how much the sum of squares falls.
    pub gain: f64,
}

impl Candidate {
    /// Of one effect.
    pub fn of(effect: Effect, gain: f64) -> Self {
        Self {
            effects: vec![effect],
            gain,
        }
    }

    /// Numbers that it has: sizes and knobs.
    pub fn numbers(&self) -> usize {
        cells::numbers(&self.effects)
    }
}

/// Evidence that a finding needs beyond its numbers and the cells that were looked at: twice a difference of logarithms.
pub const SURE: f64 = 12.0;

/// Evidence of a candidate: what it explains, less what its numbers would by chance (G. Schwarz, Annals of Statistics 6, 1978).
pub fn evidence(board: &Board, gain: f64, numbers: usize) -> f64 {
    gain - numbers as f64 * (board.edges() as f64).ln()
}

/// Part of a peak's gain that the whole order beside it has to have to be taken in its place: what is left of it may be how its size
/// changes, which no single line explains.
const WHOLE: f64 = 0.9;
/// Slowest carrier beside a drive that nobody declared, cycles a turn: what is slower is the drive's own course.
const SLOWEST: f64 = 0.25;
/// Peaks of a spectrum that are looked at.
const PEAKS: usize = 2;
/// Bounds of bands, as shares of half the edges' rate: what swings slowly has images at high frequencies, which must not hide it.
const BANDS: [f64; 2] = [0.02, 0.2];
/// Band of the slow whole orders of a torque that a disc of unknown errors has as well: beside it little of them is left, however much that
/// tells.
const SHARED: usize = BANDS.len() + 1;
/// Carriers of each band that are tried at all sites that are alike, and candidates whose frequency is looked for closely.
const CARRIERS: usize = 4;
const REFINED: usize = 5;
/// Edges a turn of which each channel has so few that a wave of its own is told from no other.
pub const FEW: i64 = 128;
/// Share of half of what two frequencies are apart by to which the closer look goes.
const FINEST: f64 = 0.125;

/// What is scanned: the score of each edge of each recording.
struct Scores<'a> {
    /// What one rad at an edge adds.
    angle: &'a [Vec<f64>],
    /// The same of the disc.
    disc: &'a [Vec<f64>],
    /// What 1 rad/s^2 over the interval before it adds.
    push: Vec<Vec<f64>>,
}

/// Sites of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    Angle,
    Time,
}

/// Candidates by spectra, the best few of each site.
pub fn spectra(left: &Left<'_>, model: &Model) -> Vec<Candidate> {
    let board = left.board;
    let scores = Scores::of(left);
    let sites = sites(board);
    let found: Vec<Vec<(usize, f64, Carrier)>> = sites
        .par_iter()
        .map(|(site, over)| scores.peaks(board, *site, *over))
        .collect();
    let each = sites.iter().zip(found);
    let each = each.flat_map(|((site, _), found)| found.into_iter().map(move |one| (site, one)));
    let mut peaks: Vec<(&Site, (usize, f64, Carrier))> = each.collect();
    peaks.sort_by(|(_, a), (_, b)| b.1.total_cmp(&a.1));
    let mut carriers: Vec<(&Site, usize, Carrier)> = Vec::new();
    for (site, (band, _, carrier)) in peaks {
        let reach = board.reach(&Effect::new(Site::Torque, carrier))[0];
        let beside = carriers.iter().filter(|(by, ..)| alike(board, by, site));
        let mut of_kind =
            { beside.clone() }.filter(|(_, of, _)| (*of == SHARED) == (band == SHARED));
        let is_new = of_kind.all(|(.., other)| !near(*other, carrier, reach));
        if is_new && beside.filter(|(_, of, _)| *of == band).count() < CARRIERS {
            carriers.push((site, band, carrier));
        }
    }
    // Whichever of them showed it, it may enter at any site that moves the same edges.
    let everywhere = carriers.iter().flat_map(|(by, _, carrier)| {
        let over = if matches!(carrier, Carrier::Order(_)) {
            Over::Angle
        } else {
            Over::Time
        };
        sites
            .iter()
            .filter(move |(site, own)| *own == over && alike(board, by, site))
            .map(move |(site, _)| Effect::new(*site, *carrier))
    });
    let everywhere: Vec<Effect> = everywhere.collect();
    // Where nothing tells an order from its images, they come after it.
    let told = board.tells_images();
    let known = |effect: &&Effect| told || !board.is_image(effect);
    let found = model.terms.iter().map(|term| &term.effect);
    let images = everywhere.iter().filter(|_| told).chain(found);
    let images = images.flat_map(|effect| board.nearest_images(effect));
    let images: Vec<Effect> = images.collect();
    let all = everywhere.iter().filter(known).chain(&images).copied();
    let everywhere: Vec<Effect> = all
        .filter(|effect| !board.is_alias(effect) && !taken(board, model, effect))
        .collect();
    let exact = { everywhere.par_iter() }.zip(left.gains(&everywhere));
    let exact = exact.map(|(effect, gain)| or_whole(left, *effect, gain));
    let mut exact: Vec<(Effect, f64)> = exact.collect();
    exact.sort_by(|a, b| b.1.total_cmp(&a.1));
    exact.dedup_by_key(|(effect, _)| *effect);
    exact.truncate(REFINED);
    let lines = exact.par_iter();
    let lines = lines.map(|(effect, gain)| refined(left, *effect, *gain));
    let sweeps = sweeps(left, &scores, &sites);
    let gains = left.gains(&sweeps);
    let sweeps =
        { sweeps.into_par_iter().zip(gains) }.map(|(sweep, gain)| Candidate::of(sweep, gain));
    lines.chain(sweeps).collect()
}

/// Sites that have a spectrum, along what.
fn sites(board: &Board) -> Vec<(Site, Over)> {
    let (channels, two_flanks) = (cells::channels(board), cells::has_classes(board));
    let mut sites = vec![
        (Site::Disc(On::ALL), Over::Angle),
        (Site::Torque, Over::Angle),
        (Site::Torque, Over::Time),
    ];
    // At one speed what follows an angle follows a frequency. Of few edges what each channel does along the turn is their own.
    let many = has_many(board);
    let speeds = many && board.speed_spread() > SPEEDS;
    let mut add = |site: fn(On) -> Site, channel| {
        let site = site(On {
            channel,
            rises: None,
        });
        sites.push((site, Over::Time));
        if speeds {
            sites.push((site, Over::Angle));
        }
    };
    if two_flanks {
        add(Site::Level, None);
    }
    if channels > 1 {
        for channel in 0..channels {
            if two_flanks {
                add(Site::Level, Some(channel));
            }
            if many {
                add(Site::Stamp, Some(channel));
            }
        }
    }
    sites
}

/// Whether there are so many edges a turn that what channels and flanks do by themselves is told from what all edges do.
fn has_many(board: &Board) -> bool {
    let mut records = board.benches.iter().map(|bench| &bench.record);
    records.all(|record| record.of_edges > FEW)
}

/// Whether the disc's errors are unknown, and the speed changes so far that they are told from a torque.
fn learns_disc(board: &Board) -> bool {
    let free = board.pattern.as_ref().is_some_and(|pattern| !pattern.known);
    free && board.speed_spread() > SPEEDS
}

/// Whether two sites move the same edges, and the same way: what shows at one of them shows at the other. Of few edges it shows anywhere.
fn alike(board: &Board, one: &Site, other: &Site) -> bool {
    if !has_many(board) {
        return true;
    }
    let on = |site: &Site| match site {
        Site::Level(on) => (on.channel, true),
        Site::Disc(on) | Site::Stamp(on) => (on.channel, false),
        Site::Torque | Site::Drive | Site::Declared(_) => (None, false),
    };
    on(one) == on(other)
}

/// Effects whose frequency sweeps with time: each sweep that stands out at a site, at all that are alike.
fn sweeps(left: &Left<'_>, scores: &Scores<'_>, sites: &[(Site, Over)]) -> Vec<Effect> {
    let benches = &left.board.benches;
    let along_time = sites.iter().filter(|(_, over)| *over == Over::Time);
    let along_time = along_time.map(|(site, _)| *site);
    let sites: Vec<Site> = along_time.chain([Site::Disc(On::ALL)]).collect();
    let each = benches.par_iter().enumerate().flat_map_iter(|(at, bench)| {
        let sites = &sites;
        let shown = sites.iter().flat_map(move |site| {
            let found = sweep::carriers(&scores.along(bench, at, *site, Over::Time));
            found.into_iter().map(move |carrier| (site, carrier))
        });
        shown.flat_map(move |(by, carrier)| {
            let sites = sites.iter().filter(move |site| alike(left.board, by, site));
            // It may be the others' as well.
            let several = (benches.len() > 1).then_some(Some(bench.place));
            let places = [None].into_iter().chain(several);
            sites.flat_map(move |site| {
                let effect = Effect::new(*site, carrier);
                places.clone().map(move |only| Effect { only, ..effect })
            })
        })
    });
    each.collect()
}

/// Whether two carriers can't be told apart.
fn near(one: Carrier, other: Carrier, reach: f64) -> bool {
    match (one, other) {
        (Carrier::Order(a), Carrier::Order(b)) | (Carrier::Tone(a), Carrier::Tone(b)) => {
            (a - b).abs() < 1.5 * reach
        }
        _ => false,
    }
}

/// Whether a model has the same already: another one of it would only cancel it in part.
fn taken(board: &Board, model: &Model, effect: &Effect) -> bool {
    let reach = board.reach(effect)[0];
    model.terms.iter().any(|term| {
        let own = term.effect.growth == Growth::Own;
        let same = !own && term.effect.site == effect.site;
        same && near(term.effect.carrier, effect.carrier, reach)
    })
}

/// An effect with what it explains, or the same at the whole order that it may be.
fn or_whole(left: &Left<'_>, effect: Effect, gain: f64) -> (Effect, f64) {
    let Carrier::Order(exact) = effect.carrier else {
        return (effect, gain);
    };
    let order = exact.round();
    let carrier = Carrier::Order(order);
    let whole = Effect { carrier, ..effect };
    let near = (exact - order).abs() < left.board.reach(&effect)[0];
    if order > 0.0 && near && whole != effect {
        let there = left.gain(&whole);
        if there > WHOLE * gain {
            return (whole, there);
        }
    }
    (effect, gain)
}

/// The best nearby value of a candidate's frequency or order.
fn refined(left: &Left<'_>, effect: Effect, gain: f64) -> Candidate {
    let as_it_is = Candidate::of(effect, gain);
    if evidence(left.board, gain, as_it_is.numbers()) < 0.0 {
        return as_it_is;
    }
    let reach = left.board.reach(&effect)[0];
    let (effect, gain) = left.best_near(&effect, &[0.5 * reach], FINEST);
    let (effect, gain) = or_whole(left, effect, gain);
    Candidate::of(effect, gain)
}

impl<'a> Scores<'a> {
    fn of(left: &'a Left<'_>) -> Self {
        let each = left.board.benches.iter().zip(left.scores(Site::Torque));
        Self {
            push: each
                .map(|(bench, angle)| bench.plant.sensitivity(&bench.course, angle))
                .collect(),
            angle: left.scores(Site::Torque),
            disc: left.scores(Site::Disc(On::ALL)),
        }
    }

    /// What a unit at a site adds at each edge of a recording, along angle or time.
    fn along(&self, bench: &Bench, at: usize, site: Site, over: Over) -> Spectrum {
        let record = &bench.record;
        let value = |edge: usize| match site {
            Site::Torque => self.push[at][edge],
            Site::Level(on) => {
                let change = record.change(edge);
                let here = on.channel.is_none_or(|channel| channel == change.channel);
                let sign = if change.rises { -1.0 } else { 1.0 };
                if here {
                    sign * self.angle[at][edge]
                } else {
                    0.0
                }
            }
            Site::Stamp(on) if !on.has(record.captured(edge)) => 0.0,
            Site::Stamp(_) => -bench.course.speed[edge] * self.angle[at][edge],
            _ => self.disc[at][edge],
        };
        let along: Vec<f64> = match over {
            Over::Angle => (0..record.len()).map(|at| record.grid_rad(at)).collect(),
            Over::Time => record.time_s.clone(),
        };
        // A torque acts in the middle of its interval.
        let middle = |at: usize| 0.5 * (along[at] + along[at.saturating_sub(1)]);
        let along = match site {
            Site::Torque => (0..along.len()).map(middle).collect(),
            _ => along,
        };
        let unit = match over {
            Over::Angle => 1.0 / TAU,
            Over::Time => 1.0,
        };
        Spectrum {
            values: (0..record.len()).map(value).collect(),
            along,
            unit,
        }
    }

    /// The orders or frequencies that stand out, strongest first.
    fn peaks(&self, board: &Board, site: Site, over: Over) -> Vec<(usize, f64, Carrier)> {
        let each = board.benches.iter().enumerate();
        let each = each.map(|(at, bench)| self.along(bench, at, site, over));
        let each: Vec<Spectrum> = each.collect();
        let longest = each.iter().map(Spectrum::span).fold(0.0, f64::max);
        let top = each.iter().map(Spectrum::fastest).fold(0.0, f64::max);
        if longest <= 0.0 || top <= 0.0 {
            return Vec::new();
        }
        // Two points to what can be told apart, all recordings on the same ones.
        let step = 0.5 / longest;
        let count = (top / step) as usize;
        if count < 4 {
            return Vec::new();
        }
        let carrier = |at: f64| match over {
            // An exact order is chosen, and not met by chance.
            Over::Angle => Carrier::Order((at * step).next_up()),
            Over::Time => Carrier::Tone(at * step),
        };
        let shares = site == Site::Torque && over == Over::Angle && learns_disc(board);
        // Slow ones alone: a torque's angle goes by the square of its order.
        let slow = (BANDS[0] * top).max(1.0) as usize;
        let mut shared = vec![0.0; if shares { slow } else { 0 }];
        let mut power = vec![0.0; count];
        for one in &each {
            let spectrum = one.power(step, count);
            // What noise alone gives is what the neighbourhood has.
            let floor = local_median(&spectrum);
            for (order, sum) in (1_u32..).zip(&mut shared) {
                let order = f64::from(order);
                *sum += one.square(order) / floor[(order / step) as usize];
            }
            for (power, (here, floor)) in power.iter_mut().zip(spectrum.iter().zip(floor)) {
                *power += here / floor;
            }
        }
        // Fewer than two cycles are no rhythm.
        let slowest = if board.undriven {
            let turn = match over {
                Over::Angle => 1.0,
                Over::Time => board.fastest() / TAU,
            };
            (SLOWEST * turn / step).ceil() as usize
        } else {
            0
        };
        let mut order: Vec<usize> = (slowest.max(4)..count.saturating_sub(1))
            .filter(|&at| power[at] >= power[at - 1] && power[at] >= power[at + 1])
            .collect();
        order.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
        let band = |at: usize| {
            let share = at as f64 / count as f64;
            BANDS.iter().filter(|bound| share > **bound).count()
        };
        let mut taken: Vec<usize> = Vec::new();
        for at in order {
            let beside = taken.iter().filter(|&&other| band(other) == band(at));
            if beside.count() < PEAKS && taken.iter().all(|other| other.abs_diff(at) > 4) {
                taken.push(at);
            }
        }
        let taken = taken.into_iter();
        let taken = taken.map(|at| (band(at), power[at], carrier(at as f64)));
        let shared = (1_u32..).zip(shared);
        let shared = shared.map(|(order, power)| (SHARED, power, Carrier::Order(f64::from(order))));
        taken.chain(shared).collect()
    }
}

/// What each order, from 0 on, has of a row.
pub fn spectrum(mut row: Vec<f64>) -> Vec<Complex<f64>> {
    let forward = RealFftPlanner::new().plan_fft_forward(row.len());
    let mut out = forward.make_output_vec();
    // It fails where lengths differ.
    let _ = forward.process(&mut row, &mut out);
    out
}

/// Values along angle or time.
pub struct Spectrum {
    pub values: Vec<f64>,
    pub along: Vec<f64>,
    /// What a unit of `along` is in turns or s.
    pub unit: f64,
}

impl Spectrum {
    pub fn ends(&self) -> (f64, f64) {
        lsq::ends(self.along.iter().copied())
    }

    pub fn span(&self) -> f64 {
        let (least, most) = self.ends();
        ((most - least) * self.unit).max(0.0)
    }

    /// Frequency up to which edges still follow it: half their mean rate.
    pub fn fastest(&self) -> f64 {
        0.5 * self.values.len() as f64 / self.span().max(f64::MIN_POSITIVE)
    }

    /// Square of the size at one frequency, exactly.
    fn square(&self, frequency: f64) -> f64 {
        let each = self.values.iter().zip(&self.along);
        let waves = each
            .map(|(value, along)| Complex::from_polar(*value, TAU * frequency * self.unit * along));
        waves.sum::<Complex<f64>>().norm_sqr()
    }

    /// Square of the size at multiples of a frequency step.
    pub fn power(&self, step: f64, count: usize) -> Vec<f64> {
        // A grid twice as fine as the fastest, onto which each value is spread over its two neighbours.
        let length = (4 * count).next_power_of_two();
        let cell = 1.0 / (step * length as f64);
        let (least, _) = self.ends();
        let mut grid = vec![0.0; length];
        for (value, along) in self.values.iter().zip(&self.along) {
            let at = (along - least) * self.unit / cell;
            let first = at.floor();
            let share = at - first;
            let first = first as usize % length;
            grid[first] += value * (1.0 - share);
            grid[(first + 1) % length] += value * share;
        }
        let out = spectrum(grid);
        (0..count)
            .map(|at| {
                // Spreading over neighbours weakens what is fast.
                let x = TAU * 0.5 * at as f64 / length as f64;
                let weak = if x > 0.0 { (x.sin() / x).powi(2) } else { 1.0 };
                out[at].norm_sqr() / (weak * weak)
            })
            .collect()
    }
}

/// Median around each value over that of an exponential distribution with mean 1: over more of them, the higher their number.
pub fn local_median(power: &[f64]) -> Vec<f64> {
    let mut out = vec![1.0; power.len()];
    let mut from = 0;
    while from < power.len() {
        let half = (from / 8).clamp(6, 256);
        let until = (from + half).min(power.len());
        let range = from.saturating_sub(half)..(until + half).min(power.len());
        let middle = median(power[range].to_vec()).unwrap_or_default();
        out[from..until].fill((middle / std::f64::consts::LN_2).max(f64::MIN_POSITIVE));
        from = until;
    }
    out
}
