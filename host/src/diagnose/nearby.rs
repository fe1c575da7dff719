//! What an effect whose knobs are moved a little explains: its product with what is left is exact, its squares are those of the effect
//! that it was moved from. That spares a run of filter and pattern for each move.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::bench;
use super::edges::median;
use super::effect::{Carrier, Effect, Site};
use super::filter::SIDE_BY_SIDE;
use super::lsq::{Basis, OWN, add, dot};
use super::model::{Board, Fit};

/// What is left beside a model, as what one rad at each edge would add.
#[derive(Clone, Debug)]
pub struct Left<'a> {
    /// The board.
    pub board: &'a Board,
    /// The model's columns.
    pub basis: &'a Basis,
    /// What is left, white.
    pub white: &'a [f64],
    /// Score of each edge of each recording, 1/rad.
    scores: Vec<Vec<f64>>,
    /// The same of the disc, whose pattern is at its best.
    of_disc: Option<Vec<Vec<f64>>>,
}

impl<'a> Left<'a> {
    /// Of a fit that is clear of its basis.
    pub fn of(board: &'a Board, fit: &'a Fit, basis: &'a Basis) -> Self {
        let (mut white, mut errors) = (fit.left.clone(), None);
        if let Some(pattern) = board.pattern.as_ref().filter(|one| one.size2 > 0.0) {
            // A product with what the pattern could explain as well is a small difference: it takes the errors as closely as can be.
            let rest = board.rest(&fit.model);
            white = board.with_pattern(&rest);
            let closest = pattern.closest(&board.benches, &white);
            let shown = pattern.unfold(&board.benches, &closest);
            add(&mut white, -1.0, &shown);
            errors = Some((pattern, closest));
        }
        let each = bench::parts(&board.benches, &white);
        let scores: Vec<Vec<f64>> = each.map(|(bench, own)| bench.score(own)).collect();
        let of_disc =
            errors.map(|(pattern, errors)| pattern.scores(&board.benches, &errors, &scores));
        Self {
            board,
            basis,
            white: &fit.left,
            scores,
            of_disc,
        }
    }

    /// Scores of the edges for an effect of a site.
    pub fn scores(&self, site: Site) -> &[Vec<f64>] {
        match (&self.of_disc, site) {
            (Some(of_disc), Site::Disc(_)) => of_disc,
            _ => &self.scores,
        }
    }

    /// By how much the sum of squares falls with an effect.
    pub fn gain(&self, effect: &Effect) -> f64 {
        self.basis.gain(&self.board.columns(effect), self.white)
    }

    /// The same of some effects, each by itself.
    pub fn gains(&self, effects: &[Effect]) -> Vec<f64> {
        let some = effects.par_chunks(SIDE_BY_SIDE);
        let columns = some.flat_map(|some| self.board.columns_of(some));
        columns
            .map(|columns| self.basis.gain(&columns, self.white))
            .collect()
    }

    /// Inverse of the squares of an effect's columns beside the model.
    fn inverse(&self, effect: &Effect) -> DMatrix<f64> {
        let mut columns = self.board.columns(effect);
        let wholes: Vec<f64> = columns.iter().map(|column| dot(column, column)).collect();
        let each = columns.iter_mut();
        each.for_each(|column| self.basis.clear(column));
        let count = columns.len();
        let squares = DMatrix::from_fn(count, count, |a, b| {
            let open = if a == b { OWN * wholes[a] } else { 0.0 };
            dot(&columns[a], &columns[b]) + open
        });
        let inverse = squares.try_inverse();
        inverse.unwrap_or_else(|| DMatrix::zeros(count, count))
    }

    /// By about how much the sum of squares falls with an effect that is near one whose inverse squares are given.
    fn about(&self, effect: &Effect, inverse: &DMatrix<f64>) -> f64 {
        let mut products = DVector::zeros(inverse.nrows());
        let benches = self.board.benches.iter();
        for (bench, scores) in benches.zip(self.scores(effect.site)) {
            for (sum, column) in products.iter_mut().zip(bench.columns(effect).iter()) {
                *sum += dot(column, scores);
            }
        }
        products.dot(&(inverse * &products))
    }

    /// How many times as much as in white noise the lines beside one explain, those that it can be told from: by the median of an
    /// exponential distribution, and 1 at the least. None of what is no line, or has too few beside it.
    pub fn floor(&self, effect: &Effect) -> Option<f64> {
        /// Lines to either side at the most, of both sides at the least, and part of the frequency within which their squares are alike.
        const BESIDE: i32 = 16;
        const LEAST: usize = 6;
        const ALIKE: f64 = 0.1;
        if !matches!(effect.carrier, Carrier::Order(_) | Carrier::Tone(_)) {
            return None;
        }
        let reach = self.board.reach(effect)[0];
        let beside = |apart: i32| {
            let mut knobs = effect.knobs();
            let by = f64::from(apart) * reach;
            let alike = by.abs() < ALIKE * knobs[0];
            knobs[0] += by;
            alike.then(|| effect.with_knobs(&knobs))
        };
        // A whole order may be the disc's as well, those beside it are not: they go by the squares of one of them.
        let columns = self
            .board
            .columns(&beside(BESIDE / 2).or_else(|| beside(2))?);
        let count = columns.len();
        let squares = DMatrix::from_fn(count, count, |a, b| dot(&columns[a], &columns[b]));
        let inverse = squares.try_inverse()?;
        let aparts = (2..=BESIDE).flat_map(|apart| [-apart, apart]);
        let gains = aparts.filter_map(beside);
        let gains: Vec<f64> = gains.map(|beside| self.about(&beside, &inverse)).collect();
        if gains.len() < LEAST {
            return None;
        }
        let median = median(gains)?;
        Some((median / (effect.sizes() as f64 * std::f64::consts::LN_2)).max(1.0))
    }

    /// The best knobs near those of an effect, each moved by a step that is halved until a share of it is left, and what it explains
    /// there.
    pub fn best_near(&self, effect: &Effect, steps: &[f64], finest: f64) -> (Effect, f64) {
        let line = matches!(effect.carrier, Carrier::Order(_) | Carrier::Tone(_));
        // Beside a pattern each run is dear.
        let exact = !line && self.of_disc.is_none();
        let mut best = *effect;
        let mut inverse = self.inverse(&best);
        let mut share = 1.0;
        while share >= finest {
            let before = best;
            let gain = |effect: &Effect| match exact {
                true => self.gain(effect),
                false => self.about(effect, &inverse),
            };
            let mut most = gain(&best);
            for (knob, step) in steps.iter().enumerate() {
                for side in [-1.0, 1.0] {
                    let mut knobs = best.knobs();
                    knobs[knob] += side * share * step;
                    let moved = best.with_knobs(&knobs);
                    if !knobs[knob].is_finite() || !moved.is_possible() {
                        continue;
                    }
                    let here = gain(&moved);
                    if here > most {
                        (best, most) = (moved, here);
                    }
                }
            }
            // A line's squares are the same beside it.
            if best != before && !line && !exact {
                inverse = self.inverse(&best);
            }
            share *= 0.5;
        }
        (best, self.gain(&best))
    }
}
