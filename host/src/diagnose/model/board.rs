//! Recordings of one rig beside their twins, in a noise and about a course that bear on each other, and their angles as a fit has them:
//! white, weighed, and without what the disc's pattern explains.

use std::borrow::Cow;

use rayon::prelude::*;

use super::Model;
use crate::diagnose::bench::{Bench, Torques};
use crate::diagnose::columns::{Columns, White};
use crate::diagnose::declared::OPEN;
use crate::diagnose::disc;
use crate::diagnose::effect::{Carrier, Effect, Site};
use crate::diagnose::filter::{Noise, SIDE_BY_SIDE};
use crate::diagnose::lsq;
use crate::diagnose::noise::{Free, Tails, UNSEEN};
use crate::diagnose::numbers::Knob;
use crate::diagnose::pattern::{CLEAR, Pattern, SMALLER};
use crate::diagnose::record::Record;
use crate::diagnose::spread::Spread;
use crate::twin::{Drive, Errors};

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
    /// Numbers that the twins declare and that are fitted, in the order of their effects.
    pub corrections: Vec<Correction>,
    /// White columns in the present noise.
    pub white: White,
}

/// An effect, and what it or a change of it does to the edges of each recording, rad.
pub(super) type Raw<'a> = (Effect, Vec<Cow<'a, [f64]>>);

/// A declared knob that is fitted.
#[derive(Clone, Debug)]
pub struct Correction {
    /// It.
    pub knob: Knob,
    /// Its values as declared.
    pub declared: Vec<f64>,
    /// Its values in the twins that the board goes by.
    pub now: Vec<f64>,
    /// Index of its first value among effects that the twins declare.
    pub first: usize,
}

/// Rounds in which pattern and noise are found at the most, and in a hurry: where likelihoods of models alike are compared.
pub(super) const SIZED: usize = 12;
pub(super) const COMPARED: usize = 2;
/// Rounds in which the noise and one thing more that bears on it are found at the most.
pub(super) const BOTH: usize = 4;

impl Board {
    /// Of recordings beside their twins, in the noise that fits them so.
    pub fn new(benches: Vec<Bench>) -> Self {
        Self::of(benches).at_rest()
    }

    /// The same in any noise.
    pub fn of(benches: Vec<Bench>) -> Self {
        let ticks = benches.iter().map(|bench| bench.record.tick_s);
        let mut twins = benches.iter().map(|bench| &bench.twin);
        let undriven = twins.clone().any(|twin| twin.drive == Drive::Unknown);
        let disc_given =
            twins.all(|twin| twin.errors != Errors::default() || !twin.local_defect.is_empty());
        Self {
            noise: Noise {
                torque: 1.0,
                stamp_s: ticks.fold(0.0, f64::max),
                drift: if undriven { 1.0 } else { 0.0 },
                unseen: if undriven { UNSEEN } else { 0.0 },
                ..Noise::default()
            },
            free: Free {
                torque: true,
                drift: undriven,
                fast: false,
                fade: false,
                stamp: true,
                unseen: undriven,
                ring: false,
                tails: Tails::Normal,
            },
            undriven,
            levels: false,
            pattern: None,
            rounds: SIZED,
            disc_given,
            corrections: Vec::new(),
            white: White::default(),
            benches,
        }
    }

    /// The same in the noise that fits beside no model, with all that bears on it.
    #[must_use]
    pub fn at_rest(mut self) -> Self {
        let none = Model::default();
        self.fit_noise(&none);
        // What a speed loop saw and the noise bear on each other.
        for _ in 0..2 {
            if self.decide_ties(&none) {
                self.fit_noise(&none);
            }
        }
        self.pattern = if self.disc_given {
            self.pattern_given()
        } else {
            Pattern::new(&self.benches)
        };
        if self.pattern.is_some() {
            self.size_up(&none);
            // Phases that a recording showed go by where the shaft was, and not by where a disc that the twin lacks shows it.
            let mut benches = self.benches.iter();
            if benches.any(|bench| bench.twin.free_phases) && self.go_by(&none) {
                self.fit_noise(&none);
            }
        }
        self.find_corners(&none);
        self.hold_by_noise(&none);
        for _ in 0..BOTH {
            if self.is_looped() || !self.hold(&none) {
                break;
            }
            self.fit_noise(&none);
            self.find_corners(&none);
        }
        self
    }

    /// The same along other edges of its recordings, in the same noise, beside a model.
    #[must_use]
    pub fn along(&self, records: Vec<Record>, model: &Model) -> Option<Self> {
        let mut board = self.clone();
        for (bench, record) in board.benches.iter_mut().zip(records) {
            bench.take(record);
        }
        board.rounds = COMPARED;
        board = board.found_anew()?;
        if let Some(pattern) = &mut board.pattern {
            *pattern = pattern.along(&board.benches)?;
        }
        board.go_by(model);
        board.set_noise(self.noise);
        board.find_corners(model);
        Some(board)
    }

    /// What the twins do not give, in words.
    pub const fn not_given(&self) -> Option<&'static str> {
        match (self.disc_given, self.undriven) {
            (true, false) => None,
            (false, false) => Some("the disc"),
            (true, true) => Some("the drive"),
            (false, true) => Some("the disc and the drive"),
        }
    }

    /// Errors of the disc as far as the twins that give it leave them open.
    pub fn pattern_given(&self) -> Option<Pattern> {
        let each = self.benches.iter();
        let spread = each.fold(Spread::default(), |most, bench| most.widest(&bench.spread));
        let given = self.disc_given && spread.whole_rad() > 0.0;
        given.then(|| Pattern::known(&self.benches, &spread))?
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
        let torques = |bench: &Bench| -> Torques {
            let own = |only: Option<u8>| only.is_none_or(|only| only == bench.place);
            let each = model.terms.iter().filter(|term| {
                let effect = &term.effect;
                let wave = matches!(effect.carrier, Carrier::Order(_));
                effect.site == Site::Torque && wave && own(effect.only)
            });
            each.map(|term| (term.effect, term.sizes.clone())).collect()
        };
        let mut each = self.benches.iter().zip(&found);
        let same = |(bench, found): (&Bench, &Vec<f64>)| {
            let (was, is) = (
                bench.open(&bench.found.torques),
                bench.open(&torques(bench)),
            );
            change(bench, found) < 1.0 && (is - was).abs() <= OPEN * was.max(is)
        };
        if each.all(same) {
            return false;
        }
        for (bench, off) in self.benches.iter_mut().zip(found) {
            bench.found.late_s = disc::late_s(bench, model);
            bench.found.off = off;
            bench.found.torques = torques(bench);
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

    /// Decides anew which samples of a speed loop saw which edges, beside a model. Whether there are loops.
    pub fn decide_ties(&mut self, model: &Model) -> bool {
        let mut benches = self.benches.iter();
        let looped = benches.any(|bench| bench.twin.speed_loop().is_some());
        if looped {
            let rests = disc::rests(self, model);
            let each = self.benches.par_iter_mut().zip(&rests);
            each.for_each(|(bench, rest)| bench.decide_ties(rest));
        }
        looped
    }

    /// Edges of all recordings.
    pub fn edges(&self) -> usize {
        self.benches.iter().map(|bench| bench.record.len()).sum()
    }

    /// Length of the longest recording, s.
    pub fn seconds(&self) -> f64 {
        let each = self.benches.iter().map(|bench| bench.record.seconds());
        each.fold(0.0, f64::max)
    }

    /// Spread of the speed in all recordings as a share of its mean, swings within half a turn left out.
    pub fn speed_spread(&self) -> f64 {
        let each = self.benches.iter().flat_map(|bench| &bench.course.steady);
        let speeds: Vec<f64> = each.map(|speed| speed.abs()).collect();
        disc::rms(&speeds) / self.mean_speed().max(f64::MIN_POSITIVE)
    }

    /// Mean speed over time of the fastest recording, rad/s, whichever way the shaft turns.
    pub fn fastest(&self) -> f64 {
        let each = self.benches.iter().map(|bench| bench.course.mean());
        each.fold(0.0, f64::max)
    }

    /// Mean speed over all edges, rad/s, whichever way the shaft turns.
    pub fn mean_speed(&self) -> f64 {
        let speeds = self.benches.iter().flat_map(|bench| &bench.course.steady);
        let (sum, count) = speeds.fold((0.0, 0.0), |(sum, count), speed| {
            (sum + speed.abs(), count + 1.0)
        });
        sum / f64::max(count, 1.0)
    }

    /// What a model leaves of each edge's angle, rad, for each recording.
    pub fn rest(&self, model: &Model) -> Vec<Vec<f64>> {
        let each = self.benches.par_iter().map(|bench| {
            let mut sum = vec![0.0; bench.record.len()];
            for term in &model.terms {
                for (column, size) in bench.columns(&term.effect).iter().zip(&term.sizes) {
                    lsq::add(&mut sum, *size, column);
                }
            }
            let each = sum.iter_mut().zip(&bench.residual);
            each.for_each(|(sum, all)| *sum = all - *sum);
            sum
        });
        each.collect()
    }

    /// What rounding to ticks alone would leave of each edge's angle, rad, for each recording, on the course that a model has.
    pub fn rounded(&self, model: &Model) -> Vec<Vec<f64>> {
        let rests = disc::rests(self, model);
        let each = self.benches.iter().zip(&rests);
        each.map(|(bench, rest)| bench.rounded(rest, self.noise.stamp_s))
            .collect()
    }

    /// Sum of squares below which nothing is claimed: what the twins declare of the shaft's course is worked out to a millionth.
    pub fn precision(&self) -> f64 {
        let each = self.benches.iter();
        let white = each.map(|bench| {
            let mut response = bench.declared.angles();
            bench.less_start(&mut response);
            bench.white(&response)
        });
        1e-6 * 1e-6 * white.map(|white| lsq::dot(&white, &white)).sum::<f64>()
    }

    /// Angles of all recordings, white, in a row, with what the disc's pattern explains in them.
    pub fn with_pattern(&self, angles: &[Vec<f64>]) -> Vec<f64> {
        let each = self.benches.par_iter().zip(angles);
        let each: Vec<Vec<f64>> = each.map(|(bench, angles)| bench.white(angles)).collect();
        each.concat()
    }

    /// Angles of all recordings, white, in a row.
    pub fn white(&self, angles: &[Vec<f64>]) -> Vec<f64> {
        self.beside_pattern(self.with_pattern(angles))
    }

    /// A white row without what the disc's pattern explains.
    pub fn beside_pattern(&self, white: Vec<f64>) -> Vec<f64> {
        match &self.pattern {
            Some(pattern) => pattern.taken_off(&self.benches, white),
            None => white,
        }
    }

    /// The residuals, white, in a row.
    pub fn target(&self) -> Vec<f64> {
        let each = self.benches.iter().map(|bench| bench.residual.clone());
        let white = self.with_pattern(&each.collect::<Vec<_>>());
        match &self.pattern {
            Some(pattern) => pattern
                .taken_off_rows(&self.benches, vec![white], SMALLER)
                .swap_remove(0),
            None => white,
        }
    }

    /// Columns of an effect for unit of each size, white, in a row.
    pub fn columns(&self, effect: &Effect) -> Vec<Vec<f64>> {
        self.columns_of(std::slice::from_ref(effect)).swap_remove(0)
    }

    /// The same of some effects.
    pub fn columns_of(&self, effects: &[Effect]) -> Vec<Vec<Vec<f64>>> {
        self.columns_until(effects, CLEAR)
    }

    /// The same until a part of what the pattern leaves of them is left: what an effect explains may be a billion times the noise.
    pub(super) fn columns_until(&self, effects: &[Effect], small: f64) -> Vec<Vec<Vec<f64>>> {
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
        let mut shown = self.shown(&rows.collect::<Vec<_>>(), small).into_iter();
        let each = effects.iter();
        each.map(|effect| shown.by_ref().take(effect.sizes()).collect())
            .collect()
    }

    /// Of which courses in which noise, and beside which pattern, a white column is.
    pub(super) fn mark(&self) -> Vec<u64> {
        let benches = self.benches.iter();
        let marks = benches.flat_map(|bench| [bench.kept.course, bench.mark().to_bits()]);
        let size2 = self.pattern.iter().map(|pattern| pattern.size2.to_bits());
        marks.chain(size2).collect()
    }

    /// What effects do to the edges of each recording, rad, each white, in a row.
    pub(super) fn shown(&self, rows: &[Raw<'_>], small: f64) -> Vec<Vec<f64>> {
        let white = |rows: &[&Raw<'_>]| {
            let mut white = vec![Vec::new(); rows.len()];
            for (at, bench) in self.benches.iter().enumerate() {
                let raw = rows.iter().map(|(_, angles)| angles[at].to_vec());
                let each = white.iter_mut().zip(bench.white_rows(raw.collect()));
                each.for_each(|(white, of)| white.extend(of));
            }
            white
        };
        let some = rows.par_chunks(SIDE_BY_SIDE).flat_map(|rows| {
            let Some(pattern) = &self.pattern else {
                return white(&rows.iter().collect::<Vec<_>>());
            };
            let of_disc = |row: &&Raw<'_>| pattern.size2 > 0.0 && row.0.is_of_disc();
            let (discs, rest): (Vec<_>, Vec<_>) = rows.iter().partition(of_disc);
            let mut white = pattern
                .taken_off_rows(&self.benches, white(&rest), small)
                .into_iter();
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
            let mut discs = pattern
                .taken_off_disc(&self.benches, &errors, small)
                .into_iter();
            let each = rows.iter().filter_map(|row| match of_disc(&row) {
                true => discs.next(),
                false => white.next(),
            });
            each.collect()
        });
        some.collect()
    }
}
