//! A model: effects beside what the twins declare, with all their numbers, fitted together to all recordings.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::bench::{self, Bench};
use super::columns::{Columns, White};
use super::correct::Correction;
use super::course::Course;
use super::disc;
use super::effect::{Carrier, Effect, Growth, Site};
use super::filter::{Noise, SIDE_BY_SIDE};
use super::lsq::{self, Basis, Solution};
use super::noise::{Free, Tails};
use super::pattern::Pattern;
use super::record::Record;

/// All recordings of a rig beside their twins.
#[derive(Clone, Debug)]
pub struct Board {
    /// One a recording.
    pub benches: Vec<Bench>,
    /// The noise of all.
    pub noise: Noise,
    /// What of the noise is not said.
    pub free: Free,
    /// Whether the twins do not say how the shaft is driven.
    pub undriven: bool,
    /// Whether noise has levels of its own in stretches of a recording: a misfit has them as well.
    pub levels: bool,
    /// The disc's pattern, where it is part of what is fitted.
    pub pattern: Option<Pattern>,
    /// Whether the twins give the disc, so that another one is a finding.
    pub disc_given: bool,
    /// Rounds in which pattern and noise are found at the most.
    pub rounds: usize,
    /// Numbers that the twins declare and that are fitted, in the order of [`Site::Declared`].
    pub corrections: Vec<Correction>,
    /// White columns in the present noise.
    pub white: White,
}

/// An effect in a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// It.
    pub effect: Effect,
    /// Its sizes.
    pub sizes: Vec<f64>,
    /// Whether it is no finding: what nobody knows of any rig.
    pub nuisance: bool,
    /// Terms of one group are one finding.
    pub group: usize,
}

/// A model as fitted.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Its effects.
    pub terms: Vec<Term>,
}

/// An effect, and what it or a change of it does to the edges of each recording, rad.
type Raw<'a> = (Effect, Vec<Cow<'a, [f64]>>);

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with its numbers.
    pub model: Model,
    /// Columns of sizes and knobs, white, all recordings in a row.
    pub columns: Vec<Vec<f64>>,
    /// Of each column its term, and which of its numbers: sizes first, then knobs.
    pub of: Vec<(usize, usize)>,
    /// Covariance of the numbers, in the order of the columns.
    pub covariance: DMatrix<f64>,
    /// What is left, white, all recordings in a row.
    pub left: Vec<f64>,
    /// Sum of its squares.
    pub rss: f64,
    /// The same where knobs go on as their slopes say.
    lowest: f64,
}

/// Change of a knob for its slope, in its reach.
const SMALL: f64 = 0.02;
/// Rounds of re-linearisation at the most.
const ROUNDS: usize = 8;
/// Rounds in which pattern and noise are found at the most, and where likelihoods of models alike are compared, and the change of a logarithm of the noise that is none.
const SIZED: usize = 12;
const COMPARED: usize = 2;
const ALIKE: f64 = 0.05;
/// Rounds in which noise and how stiffly an unknown drive holds the shaft are found.
const HELD: usize = 4;
/// Rounds in which noise and what a speed loop saw are found, as each bears on the other.
const TIED: usize = 2;
/// Rounds in which noise and its levels are found beside a model at the most.
const LEVELLED: usize = 4;
/// Density of a torque that wanders over that of torque noise, to begin with.
const WANDERS: f64 = 3.0;
/// Sum of squares that is no gain.
const NO_GAIN: f64 = 0.02;

impl Model {
    /// Adds effects that are one finding.
    pub fn add(&mut self, effects: &[Effect], group: usize) {
        self.terms.extend(effects.iter().map(|effect| Term {
            effect: *effect,
            sizes: vec![0.0; effect.sizes()],
            nuisance: false,
            group,
        }));
    }

    /// Adds effects that are no finding.
    pub fn add_open(&mut self, effects: &[Effect], group: usize) {
        self.add(effects, group);
        let added = self.terms.iter_mut().rev().take(effects.len());
        added.for_each(|term| term.nuisance = true);
    }

    /// Effects of a group.
    #[must_use]
    pub fn effects(&self, group: usize) -> Vec<Effect> {
        self.terms
            .iter()
            .filter(|term| term.group == group)
            .map(|term| term.effect)
            .collect()
    }

    /// Sizes and knobs of a group.
    #[must_use]
    pub fn numbers(&self, group: usize) -> usize {
        self.effects(group)
            .iter()
            .map(|effect| effect.sizes() + effect.knobs().len())
            .sum()
    }

    /// Groups that are findings, in the order in which they were found.
    #[must_use]
    pub fn groups(&self) -> Vec<usize> {
        let mut groups: Vec<usize> = Vec::new();
        for term in self.terms.iter().filter(|term| !term.nuisance) {
            if !groups.contains(&term.group) {
                groups.push(term.group);
            }
        }
        groups
    }

    /// A group that no term has yet: what turned out to be open keeps the one that it had as a finding.
    #[must_use]
    pub fn unused(&self) -> usize {
        let free = |group: &usize| self.terms.iter().all(|term| term.group != *group);
        (0..=self.terms.len()).find(free).unwrap_or_default()
    }

    /// What is no finding.
    #[must_use]
    pub fn nuisances(&self) -> Self {
        let some = self.terms.iter().filter(|term| term.nuisance);
        Self {
            terms: some.cloned().collect(),
        }
    }

    /// The same without a group.
    #[must_use]
    pub fn without(&self, group: usize) -> Self {
        Self {
            terms: self
                .terms
                .iter()
                .filter(|term| term.group != group)
                .cloned()
                .collect(),
        }
    }
}

impl Fit {
    /// The same without a group: all other numbers fitted again, knobs as slopes.
    #[must_use]
    pub fn without(&self, group: usize) -> Self {
        let kept: Vec<usize> = (0..self.of.len())
            .filter(|&at| self.model.terms[self.of[at].0].group != group)
            .collect();
        let columns: Vec<Vec<f64>> = kept.iter().map(|&at| self.columns[at].clone()).collect();
        let by_column: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let Solution {
            rss,
            left,
            covariance,
            ..
        } = lsq::solve(
            &by_column,
            &self.beside(&|term| self.model.terms[term].group == group),
        );
        let before = |term: usize| {
            let terms = self.model.terms[..term].iter();
            terms.filter(|term| term.group == group).count()
        };
        let of = kept.iter().map(|&at| {
            let (term, number) = self.of[at];
            (term - before(term), number)
        });
        Self {
            model: self.model.without(group),
            of: of.collect(),
            columns,
            covariance,
            left,
            rss,
            lowest: rss,
        }
    }

    /// What a group makes of each innovation.
    #[must_use]
    pub fn own(&self, group: usize) -> Vec<f64> {
        self.own_of(&|term| self.model.terms[term].group == group)
    }

    /// What some terms make of each innovation.
    fn own_of(&self, asked: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let mut own = vec![0.0; self.left.len()];
        for (column, (at, number)) in self.columns.iter().zip(&self.of) {
            let term = &self.model.terms[*at];
            if asked(*at) && *number < term.sizes.len() {
                let each = own.iter_mut().zip(column);
                each.for_each(|(own, of)| *own += term.sizes[*number] * of);
            }
        }
        own
    }

    /// What is left where the sizes of some terms are none.
    fn beside(&self, gone: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let mut target = self.own_of(gone);
        let each = target.iter_mut().zip(&self.left);
        each.for_each(|(target, left)| *target += left);
        target
    }

    /// An orthonormal basis of its columns.
    #[must_use]
    pub fn basis(&self) -> Basis {
        let columns: Vec<&[f64]> = self.columns.iter().map(Vec::as_slice).collect();
        Basis::of(&columns)
    }

    /// By how much the sum of squares grows without a group, all else fitted again, knobs as slopes.
    #[must_use]
    pub fn loss(&self, group: usize) -> f64 {
        self.loss_of(&|term| self.model.terms[term].group == group)
    }

    /// The same without some terms, by their places.
    #[must_use]
    pub fn loss_of(&self, gone: &dyn Fn(usize) -> bool) -> f64 {
        let target = self.beside(gone);
        let kept = self.columns.iter().zip(&self.of);
        let kept = kept.filter(|(_, (term, _))| !gone(*term));
        let kept: Vec<&[f64]> = kept.map(|(column, _)| column.as_slice()).collect();
        (lsq::solve(&kept, &target).rss - self.lowest).max(0.0)
    }
}

impl Board {
    /// Of recordings beside their twins, in the noise that fits them so.
    #[must_use]
    pub fn new(benches: Vec<Bench>) -> Self {
        Self::with(benches, false)
    }

    /// The same where noise has levels by stretches: of recordings of which nothing is known, so that nothing is missing.
    #[must_use]
    pub fn levelled(benches: Vec<Bench>) -> Self {
        Self::with(benches, true)
    }

    /// The same in any noise.
    #[must_use]
    pub fn of(benches: Vec<Bench>) -> Self {
        let tick_s = benches
            .iter()
            .map(|bench| bench.record.tick_s)
            .fold(0.0, f64::max);
        let noise = Noise {
            torque: 1.0,
            stamp_s: tick_s,
            drift: if benches
                .iter()
                .any(|bench| bench.twin.drive == crate::twin::Drive::Unknown)
            {
                1.0
            } else {
                0.0
            },
            fade: 0.0,
            angle_rad: 0.0,
        };
        let known = benches.iter().all(|bench| {
            let errors = &bench.twin.errors;
            *errors != crate::twin::Errors::default() || !bench.twin.local_defect.is_empty()
        });
        let undriven = benches
            .iter()
            .any(|bench| bench.twin.drive == crate::twin::Drive::Unknown);

        Self {
            benches,
            noise,
            free: Free {
                torque: true,
                drift: undriven,
                fast: false,
                fade: false,
                stamp: true,
                tails: Tails::Normal,
            },
            undriven,
            levels: false,
            pattern: None,
            rounds: SIZED,
            disc_given: known,
            corrections: Vec::new(),
            white: White::default(),
        }
    }

    fn with(benches: Vec<Bench>, levels: bool) -> Self {
        let mut board = Self {
            levels,
            ..Self::of(benches)
        };
        let looped = board
            .benches
            .iter()
            .any(|bench| bench.twin.speed_loop().is_some());
        board.fit_noise(&Model::default());
        if looped {
            for _ in 0..TIED {
                board.decide_ties(&Model::default());
                board.fit_noise(&Model::default());
            }
        }
        board.pattern = if board.disc_given {
            board.pattern_given()
        } else {
            Pattern::new(&board.benches)
        };
        if board.pattern.is_some() {
            board.size_up(&Model::default());
        }
        for _ in 0..HELD {
            if !board.hold(&Model::default()) {
                break;
            }
            board.fit_noise(&Model::default());
        }
        board
    }

    /// The same along other edges of its recordings, in the same noise, beside a model.
    #[must_use]
    pub fn along(&self, records: Vec<Record>, model: &Model) -> Option<Self> {
        let mut board = self.clone();
        for (bench, record) in board.benches.iter_mut().zip(records) {
            bench.found.off.clear();
            bench.weights = vec![1.0; record.len()];
            bench.tails.clone_from(&bench.weights);
            bench.record = record;
        }
        board.rounds = COMPARED;
        board = board.found_anew()?;
        if let Some(pattern) = &mut board.pattern {
            *pattern = pattern.along(&board.benches)?;
        }
        board.go_by(model);
        board.set_noise(self.noise);
        Some(board)
    }

    /// Errors of the disc as far as the twins that give it leave them open.
    #[must_use]
    pub fn pattern_given(&self) -> Option<Pattern> {
        let each = self.benches.iter().map(|bench| bench.spread_rad);
        let spread_rad = each.fold(0.0, f64::max);
        let given = self.disc_given && spread_rad > 0.0;
        given.then(|| Pattern::known(&self.benches, spread_rad * spread_rad))?
    }

    /// Sets the disc's pattern to the size of most evidence beside a model, and the noise to what both leave, until neither changes, as
    /// each bears on the other.
    pub fn size_up(&mut self, model: &Model) {
        let mut model = model.clone();
        for _ in 0..self.rounds {
            let before = self.noise;
            if self.pattern.is_some() {
                model = self.fit(&model).model;
            }
            let model = &model;
            let Some(mut pattern) = self.pattern.take() else {
                return;
            };
            let rest = self.rest(model);
            let white = self.white(&rest);
            pattern.size_up(&self.benches, &white);
            let errors = pattern.closest(&self.benches, &white);
            let left: Vec<Vec<f64>> = self
                .benches
                .iter()
                .zip(&rest)
                .map(|(bench, rest)| {
                    (0..rest.len())
                        .map(|at| rest[at] - errors[bench.record.slot(at)])
                        .collect()
                })
                .collect();
            self.level(&left);
            let (noise, _) = bench::fit_noise(&self.benches, &left, self.noise, self.free);
            self.pattern = Some(pattern);
            self.set_noise(noise);
            self.go_by(model);
            let changed = |was: f64, is: f64| (is / was.max(f64::MIN_POSITIVE)).ln().abs() > ALIKE;
            if !changed(before.torque, noise.torque) && !changed(before.stamp_s, noise.stamp_s) {
                break;
            }
        }
    }

    /// Works out the course anew beside what a model and the disc's pattern shift edges by: torques are evaluated at that. Whether it
    /// is another course.
    pub fn go_by(&mut self, model: &Model) -> bool {
        let found = disc::shifts(self, model);
        let change = |bench: &Bench, found: &[f64]| {
            let was = |at: usize| bench.found.off.get(at).copied().unwrap_or(0.0);
            let change = |at: usize| bench.scales[at] * (found[at] - was(at));
            let squares = (0..found.len()).map(|at| change(at).powi(2));
            squares.sum::<f64>() / found.len().max(1) as f64
        };
        let mut each = self.benches.iter().zip(&found);
        if each.all(|(bench, found)| change(bench, found) < 1.0) {
            return false;
        }
        for (bench, off) in self.benches.iter_mut().zip(found) {
            bench.found.off = off;
        }
        let Some(board) = self.found_anew() else {
            return false;
        };
        *self = board;
        if let Some(pattern) = &mut self.pattern {
            pattern.weigh(&self.benches);
        }
        self.decide_ties(model);
        true
    }

    /// Decides anew which samples of a speed loop saw which edges, beside a model.
    pub fn decide_ties(&mut self, model: &Model) {
        let mut benches = self.benches.iter();
        if benches.all(|bench| bench.twin.speed_loop().is_none()) {
            return;
        }
        let rests = disc::rests(self, model);
        let each = self.benches.par_iter_mut().zip(&rests);
        each.for_each(|(bench, rest)| bench.decide_ties(rest));
    }

    /// Edges of all recordings.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.benches.iter().map(|bench| bench.record.len()).sum()
    }

    /// Length of the longest recording, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.benches
            .iter()
            .map(|bench| bench.record.seconds())
            .fold(0.0, f64::max)
    }

    /// Spread of the speed in all recordings as a share of its mean, swings within half a turn left out.
    #[must_use]
    pub fn speed_spread(&self) -> f64 {
        let each = self.benches.iter().flat_map(|bench| &bench.course.steady);
        let speeds: Vec<f64> = each.map(|speed| speed.abs()).collect();
        let count = speeds.len().max(1) as f64;
        let mean = speeds.iter().sum::<f64>() / count;
        let off = speeds.iter().map(|speed| (speed - mean).powi(2));
        (off.sum::<f64>() / count).sqrt() / mean.max(f64::MIN_POSITIVE)
    }

    /// Angles of all recordings, white, in a row, with what the disc's pattern explains in them.
    #[must_use]
    pub fn with_pattern(&self, angles: &[Vec<f64>]) -> Vec<f64> {
        let each = self.benches.par_iter().zip(angles);
        let each: Vec<Vec<f64>> = each.map(|(bench, angles)| bench.white(angles)).collect();
        each.concat()
    }

    /// Angles of all recordings, white, in a row.
    #[must_use]
    pub fn white(&self, angles: &[Vec<f64>]) -> Vec<f64> {
        self.beside_pattern(self.with_pattern(angles))
    }

    /// A white row without what the disc's pattern explains.
    #[must_use]
    pub fn beside_pattern(&self, white: Vec<f64>) -> Vec<f64> {
        match &self.pattern {
            Some(pattern) => pattern.taken_off(&self.benches, white),
            None => white,
        }
    }

    /// The residuals, white, in a row.
    #[must_use]
    pub fn target(&self) -> Vec<f64> {
        let each: Vec<Vec<f64>> = self
            .benches
            .par_iter()
            .map(|bench| bench.white(&bench.residual))
            .collect();
        match &self.pattern {
            Some(pattern) => pattern.closely_taken_off(&self.benches, each.concat()),
            None => each.concat(),
        }
    }

    /// Columns of an effect for unit of each size, white, in a row.
    #[must_use]
    pub fn columns(&self, effect: &Effect) -> Vec<Vec<f64>> {
        self.columns_of(std::slice::from_ref(effect)).swap_remove(0)
    }

    /// The same of some effects.
    fn columns_of(&self, effects: &[Effect]) -> Vec<Vec<Vec<f64>>> {
        let raw = effects.par_iter().map(|effect| {
            let benches = self.benches.iter();
            benches.map(|bench| bench.columns(effect)).collect()
        });
        let raw: Vec<Vec<Columns>> = raw.collect();
        let rows = effects.iter().zip(&raw).flat_map(|(effect, raw)| {
            (0..effect.sizes()).map(move |size| {
                let each = raw.iter().map(|raw| Cow::Borrowed(&*raw[size]));
                (*effect, each.collect())
            })
        });
        let mut shown = self.shown(&rows.collect::<Vec<_>>()).into_iter();
        let each = effects.iter();
        each.map(|effect| shown.by_ref().take(effect.sizes()).collect())
            .collect()
    }

    /// Of which courses in which noise, and beside which pattern, a white column is.
    fn mark(&self) -> Vec<u64> {
        let benches = self.benches.iter();
        let marks = benches.flat_map(|bench| [bench.kept.course, bench.mark().to_bits()]);
        let size2 = self.pattern.iter().map(|pattern| pattern.size2.to_bits());
        marks.chain(size2).collect()
    }

    /// What effects do to the edges of each recording, rad, each white, in a row.
    fn shown(&self, rows: &[Raw<'_>]) -> Vec<Vec<f64>> {
        let of_disc = |pattern: &&Pattern, row: &Raw<'_>| pattern.size2 > 0.0 && row.0.is_of_disc();
        let some = rows.par_chunks(SIDE_BY_SIDE).flat_map(|rows| {
            let mut rest: Vec<&Raw<'_>> = rows.iter().collect();
            let mut discs = Vec::new();
            if let Some(pattern) = &self.pattern {
                (discs, rest) = rest.into_iter().partition(|row| of_disc(&pattern, row));
            }
            let benches = self.benches.iter().enumerate();
            let mut white = vec![Vec::new(); rest.len()];
            for (at, bench) in benches {
                let raw = rest.iter().map(|(_, angles)| angles[at].to_vec());
                let each = white.iter_mut().zip(bench.white_rows(raw.collect()));
                each.for_each(|(white, of)| white.extend(of));
            }
            let Some(pattern) = &self.pattern else {
                return white;
            };
            let mut white = pattern.taken_off_rows(&self.benches, white).into_iter();
            let errors = discs.iter().map(|(_, angles)| {
                let mut errors = vec![0.0; pattern.edges];
                for (bench, angles) in self.benches.iter().zip(angles) {
                    for (at, value) in angles.iter().enumerate() {
                        errors[bench.record.slot(at)] = *value;
                    }
                }
                errors
            });
            let errors: Vec<Vec<f64>> = errors.collect();
            let mut discs = pattern.taken_off_disc(&self.benches, &errors).into_iter();
            let each = rows.iter().filter_map(|row| {
                if of_disc(&pattern, row) {
                    discs.next()
                } else {
                    white.next()
                }
            });
            each.collect()
        });
        some.collect()
    }

    /// What a small change of a knob of a term does to the edges of each recording, rad.
    fn slope(&self, term: &Term, knob: usize) -> Raw<'_> {
        let step = SMALL * self.reach(&term.effect)[knob];
        let moved = |by: f64| {
            let mut knobs = term.effect.knobs();
            knobs[knob] += by;
            term.effect.with_knobs(&knobs)
        };
        let (above, below) = (moved(step), moved(-step));
        let each = self.benches.iter().map(|bench| {
            let (above, below) = (bench.columns(&above), bench.columns(&below));
            let mut sum = vec![0.0; bench.record.len()];
            for (size, (above, below)) in term.sizes.iter().zip(above.iter().zip(below.iter())) {
                let by = size / (2.0 * step);
                let each = sum.iter_mut().zip(above.iter().zip(below));
                each.for_each(|(sum, (above, below))| *sum += by * (above - below));
            }
            Cow::Owned(sum)
        });
        (term.effect, each.collect())
    }

    /// What a model says of each edge, rad, for each recording.
    #[must_use]
    pub fn predicted(&self, model: &Model) -> Vec<Vec<f64>> {
        self.benches
            .par_iter()
            .map(|bench| {
                let mut sum = vec![0.0; bench.record.len()];
                for term in &model.terms {
                    for (column, size) in bench.columns(&term.effect).iter().zip(&term.sizes) {
                        sum.iter_mut()
                            .zip(column)
                            .for_each(|(sum, of)| *sum += size * of);
                    }
                }
                sum
            })
            .collect()
    }

    /// What a model leaves of each edge's angle, rad, for each recording.
    #[must_use]
    pub fn rest(&self, model: &Model) -> Vec<Vec<f64>> {
        let mut rest = self.predicted(model);
        for (bench, rest) in self.benches.iter().zip(&mut rest) {
            let each = rest.iter_mut().zip(&bench.residual);
            each.for_each(|(rest, all)| *rest = all - *rest);
        }
        rest
    }

    /// What rounding to ticks alone would leave of each edge's angle, rad, for each recording, on the course that a model has.
    #[must_use]
    pub fn rounded(&self, model: &Model) -> Vec<Vec<f64>> {
        let mut rest = self.rest(model);
        if let Some(pattern) = &self.pattern {
            let errors = pattern.closest(&self.benches, &self.with_pattern(&rest));
            for (bench, rest) in self.benches.iter().zip(&mut rest) {
                let each = rest.iter_mut().enumerate();
                each.for_each(|(at, rest)| *rest -= errors[bench.record.slot(at)]);
            }
        }
        let each = self.benches.iter().zip(&rest);
        each.map(|(bench, rest)| bench.rounded(rest, self.noise.stamp_s))
            .collect()
    }

    /// Sum of squares below which nothing is claimed: what the twins declare of the shaft's course is only worked out to so many digits.
    #[must_use]
    pub fn precision(&self) -> f64 {
        /// Part of the declared course that may be wrong.
        const DIGITS: f64 = 1e-6;
        let each = self.benches.iter();
        let white = each.map(|bench| {
            let mut response = bench.declared.angles();
            bench.less_start(&mut response);
            bench.white(&response)
        });
        DIGITS * DIGITS * white.map(|white| lsq::dot(&white, &white)).sum::<f64>()
    }

    /// What rounding leaves, white, in a row.
    #[must_use]
    pub fn spurs(&self, model: &Model) -> Vec<f64> {
        self.white(&self.rounded(model))
    }

    /// Steps of an effect's knobs that hardly change it: what two of them are apart by to be told apart.
    #[must_use]
    pub fn reach(&self, effect: &Effect) -> Vec<f64> {
        let seconds = self.seconds();
        let longest = self
            .benches
            .iter()
            .max_by(|a, b| a.record.turns().total_cmp(&b.record.turns()));
        let turns = longest.map_or(1.0, |bench| {
            let places = &bench.record.place;
            let (least, most) = (
                places.iter().min().copied().unwrap_or(0),
                places.iter().max().copied().unwrap_or(1),
            );
            (most - least).max(1) as f64 / bench.record.edges as f64
        });
        let interval = seconds
            / self
                .benches
                .iter()
                .map(|bench| bench.record.len())
                .max()
                .unwrap_or(1) as f64;
        let mut reach = match effect.carrier {
            Carrier::Order(_) => vec![1.0 / turns],
            Carrier::Tone(_) => vec![1.0 / seconds],
            Carrier::Chirp(..) => vec![1.0 / seconds, 2.0 / (seconds * seconds)],
            Carrier::Bump(_, sigma) => vec![sigma, 0.5 * sigma],
            Carrier::Window(..) => vec![3.0 * interval; 2],
            Carrier::Settling(_, tau) => vec![0.3 * tau, 0.3 * tau],
            Carrier::Stribeck(speed) => vec![0.2 * speed],
            Carrier::Steady | Carrier::Time | Carrier::Direction | Carrier::Power(_) => Vec::new(),
        };
        match effect.growth {
            Growth::Constant => {}
            Growth::Even(_) => reach.push(0.3 / seconds),
            Growth::Speed(_) => reach.push(0.2),
            Growth::Modulated(..) => reach.extend([1.0 / seconds, 0.2, 0.3]),
        }
        reach
    }

    /// Whether two effects can't be told apart.
    #[must_use]
    pub fn is_same(&self, one: &Effect, other: &Effect) -> bool {
        let (here, there) = (one.knobs(), other.knobs());
        let near = here.iter().zip(&there).zip(self.reach(one));
        one.with_knobs(&there) == *other && { near }
            .all(|((here, there), reach)| here == there || (here - there).abs() < reach)
    }

    /// Knobs that are fitted: an instant beyond a recording's ends is none.
    fn fitted(&self, effect: &Effect) -> Vec<usize> {
        let knobs = effect.knobs();
        let last = self
            .benches
            .iter()
            .filter_map(|bench| bench.record.time_s.last())
            .fold(0.0, |a: f64, b| a.max(*b));
        let first = self
            .benches
            .iter()
            .filter_map(|bench| bench.record.time_s.first())
            .fold(f64::INFINITY, |a: f64, b| a.min(*b));
        (0..knobs.len())
            .filter(|&at| match effect.carrier {
                Carrier::Window(..) => knobs[at] > first && knobs[at] < last,
                // Without a start it settles from the first edge on.
                Carrier::Settling(from, _) => at == 1 || from > first,
                Carrier::Order(order) => order.fract() != 0.0,
                _ => true,
            })
            .collect()
    }

    /// Fits all numbers of a model, from where they are.
    #[must_use]
    pub fn fit(&self, model: &Model) -> Fit {
        self.settled(model, &self.target(), &Basis::default())
    }

    /// More effects with their best numbers beside a fit, whose own sizes and knobs move along but are not worked out anew: their terms,
    /// and by how much the sum of squares falls. `basis` is that of the fit's columns.
    #[must_use]
    pub fn beside(&self, fit: &Fit, basis: &Basis, effects: &[Effect]) -> (Vec<Effect>, f64) {
        let mut target = fit.left.clone();
        basis.clear(&mut target);
        let mut model = Model::default();
        model.add(effects, 0);
        let before = lsq::dot(&target, &target);
        let settled = self.settled(&model, &target, basis);
        let possible = self.can_be(&settled.model);
        let gain = if possible { before - settled.rss } else { 0.0 };
        (settled.model.effects(0), gain)
    }

    /// All numbers of a model, re-linearised until nothing changes; what is of the basis is taken off its columns.
    fn settled(&self, model: &Model, target: &[f64], basis: &Basis) -> Fit {
        let mut now = self.with_slopes(self.sized(model, target, basis), basis);
        for _ in 0..ROUNDS {
            if now
                .of
                .iter()
                .all(|(term, number)| *number < now.model.terms[*term].effect.sizes())
            {
                break;
            }
            let Some(better) = self.step(&now, target, basis) else {
                break;
            };
            let gain = now.rss - better.rss;
            now = self.with_slopes(better, basis);
            if gain < NO_GAIN {
                break;
            }
        }
        now
    }

    /// Sizes for knobs as they are; columns of these alone.
    fn sized(&self, model: &Model, target: &[f64], basis: &Basis) -> Fit {
        let effects: Vec<Effect> = model.terms.iter().map(|term| term.effect).collect();
        // What the twins declare has other columns beside other twins.
        let (declared, others): (Vec<Effect>, Vec<Effect>) = effects
            .iter()
            .partition(|effect| matches!(effect.site, Site::Declared(_)));
        let work_out = |effects: &[Effect]| self.columns_of(effects);
        let mut others = self.white.of(self.mark(), &others, work_out).into_iter();
        let mut declared = self.columns_of(&declared).into_iter().map(Arc::new);
        let (mut columns, mut of) = (Vec::new(), Vec::new());
        for (at, effect) in effects.iter().enumerate() {
            let own = match effect.site {
                Site::Declared(_) => declared.next(),
                _ => others.next(),
            };
            let own = own.iter().flat_map(|own| own.iter().cloned());
            columns.extend(own);
            of.extend((0..effect.sizes()).map(|size| (at, size)));
        }
        columns
            .par_iter_mut()
            .for_each(|column| basis.clear(column));
        let by_size: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let Solution {
            sizes,
            rss,
            left,
            covariance,
        } = lsq::solve(&by_size, target);
        let mut model = model.clone();
        for ((term, number), size) in of.iter().zip(&sizes) {
            model.terms[*term].sizes[*number] = *size;
        }
        Fit {
            model,
            columns,
            of,
            covariance,
            left,
            rss,
            lowest: rss,
        }
    }

    /// The same with what a small change of each knob does, at these sizes.
    fn with_slopes(&self, sized: Fit, basis: &Basis) -> Fit {
        let mut fit = sized;
        let knobs = fit.model.terms.iter().enumerate().flat_map(|(at, term)| {
            let fitted = self.fitted(&term.effect);
            fitted.into_iter().map(move |knob| (at, knob))
        });
        let knobs: Vec<(usize, usize)> = knobs.collect();
        if knobs.is_empty() {
            return fit;
        }
        let slopes = knobs.par_iter();
        let slopes = slopes.map(|&(at, knob)| self.slope(&fit.model.terms[at], knob));
        let slopes: Vec<Raw<'_>> = slopes.collect();
        let mut slopes = self.shown(&slopes);
        slopes.par_iter_mut().for_each(|slope| basis.clear(slope));
        for ((at, knob), slope) in knobs.into_iter().zip(slopes) {
            fit.columns.push(slope);
            fit.of.push((at, fit.model.terms[at].effect.sizes() + knob));
        }
        let all: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
        let solved = lsq::solve(&all, &fit.left);
        fit.covariance = solved.covariance;
        fit.lowest = solved.rss;
        fit
    }

    /// A step of Gauss and Newton, shortened until it helps, without its slopes; none where it does not.
    fn step(&self, now: &Fit, target: &[f64], basis: &Basis) -> Option<Fit> {
        let all: Vec<&[f64]> = now.columns.iter().map(Vec::as_slice).collect();
        let by = lsq::solve(&all, &now.left).sizes;
        let mut share = 1.0;
        for _ in 0..5 {
            let mut model = now.model.clone();
            for (at, term) in model.terms.iter_mut().enumerate() {
                let reach = self.reach(&term.effect);
                let mut knobs = term.effect.knobs();
                for ((_, number), by) in now.of.iter().zip(&by).filter(|((term, _), _)| *term == at)
                {
                    if let Some(knob) = number.checked_sub(term.effect.sizes()) {
                        knobs[knob] += (share * by).clamp(-reach[knob], reach[knob]);
                    }
                }
                let moved = term.effect.with_knobs(&knobs);
                if moved.is_possible() {
                    term.effect = moved;
                }
            }
            let next = self.sized(&model, target, basis);
            if next.rss < now.rss {
                return Some(next);
            }
            share *= 0.3;
        }
        None
    }

    /// Fits the noise to what a model leaves.
    pub fn fit_noise(&mut self, model: &Model) {
        if self.pattern.is_some() {
            return self.size_up(model);
        }
        let rest = self.rest(model);
        for _ in 0..LEVELLED {
            self.level(&rest);
            let before = self.noise;
            let (noise, _) = bench::fit_noise(&self.benches, &rest, self.noise, self.free);
            self.set_noise(noise);
            if (noise.torque / before.torque).ln().abs() < ALIKE {
                break;
            }
        }
    }

    /// A model beside the noise that it leaves: the board, the fit, and its [`Self::lost`].
    #[must_use]
    pub fn at_its_noise(&self, model: &Model) -> (Self, Fit, f64) {
        let mut board = self.clone();
        let mut fit = board.fit(model);
        for _ in 0..LEVELLED {
            let before = board.noise.torque;
            board.fit_noise(&fit.model);
            fit = board.fit(&fit.model);
            // A pattern is sized up until neither changes.
            if board.pattern.is_some() || (board.noise.torque / before).ln().abs() < ALIKE {
                break;
            }
        }
        let lost = board.lost(&fit);
        (board, fit, lost)
    }

    /// Twice the negative logarithm of the likelihood of a fit, with what its numbers would gain by chance.
    #[must_use]
    pub fn lost(&self, fit: &Fit) -> f64 {
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        let scales = scales.filter(|scale| **scale > 0.0);
        let weights = self.benches.iter().flat_map(|bench| &bench.weights);
        let weights: f64 = weights.map(|weight| weight.ln()).sum();
        let volume = self.pattern.as_ref().map_or(0.0, Pattern::log_volume);
        let groups = fit.model.groups().into_iter();
        let numbers: usize = groups.map(|group| fit.model.numbers(group)).sum();
        let chance = numbers as f64 * (self.edges() as f64).ln();
        let scales: f64 = scales.map(|scale| scale.ln()).sum();
        self.squares(fit) + volume + chance - 2.0 * (scales + weights)
    }

    /// Twice the negative logarithm of how likely innovations of a fit are, over their deviations.
    fn squares(&self, fit: &Fit) -> f64 {
        let tails = self.free.tails;
        if tails == Tails::Normal {
            return fit.rss;
        }
        let (edges, disc) = fit.left.split_at(self.edges());
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        let weights = self.benches.iter().flat_map(|bench| &bench.tails);
        let each = edges.iter().zip(weights).zip(scales);
        let shown = each.filter(|(_, scale)| **scale > 0.0);
        shown
            .map(|((white, weight), _)| tails.cost(white / weight))
            .sum::<f64>()
            + lsq::dot(disc, disc)
    }

    /// Weighs edges by the level of the noise about them, and by how far out they are.
    fn level(&mut self, rest: &[Vec<f64>]) {
        let (levels, tails) = (self.levels, self.free.tails);
        let each = self.benches.par_iter_mut().zip(rest);
        each.for_each(|(bench, rest)| {
            if levels {
                bench.level(rest);
            }
            bench.weigh(rest, tails);
        });
    }

    /// The same board in white and normal noise.
    #[must_use]
    pub fn in_plain_noise(&self) -> Self {
        let mut board = self.clone();
        board.levels = false;
        board.rounds = SIZED;
        board.free = Free {
            drift: board.undriven,
            fast: false,
            fade: false,
            tails: Tails::Normal,
            ..board.free
        };
        for bench in &mut board.benches {
            bench.weights.fill(1.0);
            bench.tails.fill(1.0);
        }
        if !board.undriven {
            board.noise.drift = 0.0;
            board.noise.fade = 0.0;
        }
        board.set_noise(board.noise);
        board
    }

    /// The same board with a torque noise that is held over an interval at some speed of the course, as drives and simulators make it; none
    /// where the twins say how long it is held.
    #[must_use]
    pub fn in_held_noise(&self, speed: fn(&Course) -> f64) -> Option<Self> {
        let mut board = self.clone();
        for bench in &mut board.benches {
            if bench.plant.law.hold_s > 0.0 {
                return None;
            }
            let turn_s = std::f64::consts::TAU / speed(&bench.course);
            bench.hold_noise(turn_s / bench.record.of_edges as f64);
        }
        board.set_noise(board.noise);
        Some(board)
    }

    /// The same board in noise as rigs have it: with a torque that wanders, with levels and, as asked for, with long tails.
    #[must_use]
    pub fn in_any_noise(&self, tails: Tails) -> Self {
        let mut board = self.clone();
        board.levels = true;
        board.rounds = COMPARED;
        board.free = Free {
            drift: true,
            fast: true,
            fade: !board.undriven,
            tails,
            ..board.free
        };
        if board.noise.drift <= 0.0 {
            let speed = board.benches.iter().map(|bench| bench.leaps.speed());
            let turning = speed.fold(0.0, f64::max);
            // Some times as dense as the torque noise, to once a turn.
            board.set_noise(Noise {
                drift: WANDERS * board.noise.torque * turning * turning,
                fade: if board.free.fade { turning } else { 0.0 },
                ..board.noise
            });
        }
        board
    }

    /// Goes by another noise.
    pub fn set_noise(&mut self, noise: Noise) {
        self.noise = noise;
        self.benches
            .par_iter_mut()
            .for_each(|bench| bench.set_noise(&noise));
        if let Some(pattern) = &mut self.pattern {
            pattern.weigh(&self.benches);
        }
    }
}

/// Whether a site moves the shaft.
#[must_use]
pub const fn pushes(site: Site) -> bool {
    matches!(site, Site::Torque | Site::Drive)
}
