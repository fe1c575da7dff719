//! Rows of angles of all recordings as a fit has them: white, weighed, and without what the disc's pattern explains.

use std::borrow::Cow;

use rayon::prelude::*;

use super::Board;
use crate::diagnose::columns::Columns;
use crate::diagnose::effect::Effect;
use crate::diagnose::filter::SIDE_BY_SIDE;

/// An effect, and what it or a change of it does to the edges of each recording, rad.
pub(super) type Raw<'a> = (Effect, Vec<Cow<'a, [f64]>>);

impl Board {
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
        let each = self.benches.par_iter();
        let each: Vec<Vec<f64>> = each.map(|bench| bench.white(&bench.residual)).collect();
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
    pub(super) fn columns_of(&self, effects: &[Effect]) -> Vec<Vec<Vec<f64>>> {
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
    pub(super) fn mark(&self) -> Vec<u64> {
        let benches = self.benches.iter();
        let marks = benches.flat_map(|bench| [bench.kept.course, bench.mark().to_bits()]);
        let size2 = self.pattern.iter().map(|pattern| pattern.size2.to_bits());
        marks.chain(size2).collect()
    }

    /// What effects do to the edges of each recording, rad, each white, in a row.
    pub(super) fn shown(&self, rows: &[Raw<'_>]) -> Vec<Vec<f64>> {
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
                .taken_off_rows(&self.benches, white(&rest))
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
            let mut discs = pattern.taken_off_disc(&self.benches, &errors).into_iter();
            let each = rows.iter().filter_map(|row| match of_disc(&row) {
                true => discs.next(),
                false => white.next(),
            });
            each.collect()
        });
        some.collect()
    }
}
