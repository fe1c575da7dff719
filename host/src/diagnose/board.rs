//! All recordings of a rig, white, and the columns that a pattern has in them.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::basis::Basis;
use super::ends::Ends;

pub use super::bench::{Bench, FITTED, PARTS};
pub use super::column::{Column, Part, Products, product, with_rows};
pub use super::least_squares::{Gain, Model};

/// All recordings.
#[derive(Clone, Debug)]
pub struct Board {
    /// One for each recording.
    pub benches: Vec<Bench>,
    /// Whether angles mean the same in all recordings.
    pub tied: bool,
    /// How clearly each order of the disc shows, once it was asked for; it hangs on the noise. Whatever works it out must not wait for
    /// other threads, which may wait for it.
    pub(super) clear: OnceLock<Vec<f64>>,
    /// Products of columns that are kept.
    pub(super) products: Products,
}

impl Board {
    /// Forgets what was worked out of other edges.
    pub(super) fn forget(&mut self) {
        self.clear = OnceLock::new();
        self.products = Products::default();
    }

    /// Edges of all recordings.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.benches.iter().map(|bench| bench.seen.len()).sum()
    }

    /// The residuals, white.
    #[must_use]
    pub fn white(&self) -> Vec<Vec<f64>> {
        self.benches
            .iter()
            .map(|bench| bench.white.clone())
            .collect()
    }

    /// What is nobody's finding: the mean speed, where it is the recording's own. As angles.
    #[must_use]
    pub fn raw_nuisances(&self) -> Vec<Column> {
        let whole = Basis::Load {
            from_s: f64::NEG_INFINITY,
            until_s: f64::INFINITY,
        };
        let free = self
            .benches
            .iter()
            .enumerate()
            .filter(|(_, bench)| bench.free_speed);
        free.map(|(at, bench)| {
            let mut column = vec![None; self.benches.len()];
            column[at] = Some(whole.columns(&bench.seen, &bench.law).swap_remove(0));
            Column::of(column)
        })
        .collect()
    }

    /// The same, white.
    #[must_use]
    pub fn nuisances(&self) -> Vec<Column> {
        self.whitened(self.raw_nuisances())
    }

    fn whitened(&self, columns: Vec<Column>) -> Vec<Column> {
        let pairs: Vec<&[Column]> = columns.chunks(2).collect();
        let white = pairs.into_par_iter().flat_map_iter(|pair| match pair {
            [one, other] => {
                let parts = one.0.iter().zip(&other.0).zip(&self.benches);
                let (one, other): (Vec<_>, Vec<_>) = parts
                    .map(|((one, other), bench)| match (one, other) {
                        (Some(one), Some(other)) => {
                            let both = bench.both_whitened([one.to_vec(), other.to_vec()]);
                            let [one, other] = both.map(Part::from);
                            (Some(one), Some(other))
                        }
                        (one, other) => (bench.part_white(one), bench.part_white(other)),
                    })
                    .unzip();
                vec![Column(one), Column(other)]
            }
            alone => alone
                .iter()
                .map(|column| {
                    let parts = column.0.iter().zip(&self.benches);
                    Column(parts.map(|(part, bench)| bench.part_white(part)).collect())
                })
                .collect(),
        });
        white.collect()
    }

    /// A pattern's columns, white: each recording its own where nothing ties them.
    #[must_use]
    pub fn columns(&self, basis: Basis) -> Vec<Column> {
        self.whitened(self.raw_columns(basis))
    }

    /// A pattern's columns as angles.
    #[must_use]
    pub fn raw_columns(&self, basis: Basis) -> Vec<Column> {
        let own = self.benches.len() > 1 && (basis.timed() || (basis.placed() && !self.tied));
        let raw: Vec<Vec<Vec<f64>>> = self
            .benches
            .par_iter()
            .map(|bench| basis.columns(&bench.seen, &bench.law))
            .collect();
        let count = self.benches.len();
        if own {
            let mut columns = Vec::new();
            for (at, parts) in raw.into_iter().enumerate() {
                for part in parts {
                    let mut column = vec![None; count];
                    column[at] = Some(part);
                    columns.push(Column::of(column));
                }
            }
            columns
        } else {
            let mut columns = vec![Column(Vec::with_capacity(count)); basis.count()];
            for parts in raw {
                for (column, part) in columns.iter_mut().zip(parts) {
                    column.0.push(Some(part.into()));
                }
            }
            columns
        }
    }

    /// Takes a pattern of the disc off every recording.
    pub fn take_off(&mut self, errors_rad: &[f64]) {
        for bench in &mut self.benches {
            for at in 0..bench.seen.len() {
                bench.seen.angles[at] -= errors_rad[bench.seen.edge(at)];
            }
            // Where the shaft is when an edge comes is known better now.
            let count = bench.seen.edges as usize;
            bench.seen.errors.resize(count, 0.0);
            for (known, more) in bench.seen.errors.iter_mut().zip(errors_rad) {
                *known += more;
            }
            bench.seen.swing();
            bench.set_noise(bench.noise);
        }
    }

    /// The same in the noise of another, with what a task may have held up in doubt by so much, s.
    #[must_use]
    pub fn in_doubt(&self, held: &[Option<Ends>], doubt_s: f64, noise: &Self) -> Self {
        let mut other = self.clone();
        for (bench, ends) in other.benches.iter_mut().zip(held) {
            let readings = bench.seen.readings.iter_mut();
            let held = readings.filter(|one| ends.is_some_and(|ends| ends.has(one.at_s)));
            held.for_each(|one| one.doubt_s = doubt_s);
        }
        for (bench, found) in other.benches.iter_mut().zip(&noise.benches) {
            bench.set_noise(found.noise);
        }
        other.clear = OnceLock::new();
        other
    }

    /// Fits the noise to what is not explained; whether it is another than before. What a twin declares is kept unless it is wrong.
    pub fn refit_noise(&mut self, explained: &[Vec<f64>]) -> bool {
        let mut changed = false;
        for (bench, explained) in self.benches.iter_mut().zip(explained) {
            let angles = bench.seen.angles.iter().zip(explained);
            let left: Vec<f64> = angles.map(|(angle, explained)| angle - explained).collect();
            if bench.declared.is_some() {
                let white = bench.whitened(left.clone());
                let count = white.len() as f64;
                let variance = white.iter().map(|w| w * w).sum::<f64>() / count;
                if (variance - 1.0).abs() < 0.03 + 6.0 * (2.0 / count).sqrt() {
                    continue;
                }
            }
            let noise = bench.noise_of(&left);
            let far = |a: f64, b: f64| (a / b).ln().abs() > 0.06;
            if far(noise.acceleration, bench.noise.acceleration)
                || far(noise.stamp_s, bench.noise.stamp_s)
            {
                bench.set_noise(noise);
                self.clear = OnceLock::new();
                changed = true;
            }
        }
        changed
    }

    /// Columns with nothing outside of some parts.
    #[must_use]
    pub fn cut(&self, columns: &[Column], parts: std::ops::Range<usize>) -> Vec<Column> {
        let cut = |column: &Column| {
            let each = column.0.iter().zip(&self.benches).map(|(part, bench)| {
                part.as_ref().map(|part| {
                    let range = bench.part(parts.start).start..bench.part(parts.end - 1).end;
                    let mut cut = vec![0.0; part.len()];
                    cut[range.clone()].copy_from_slice(&part[range]);
                    cut
                })
            });
            Column::of(each)
        };
        columns.iter().map(cut).collect()
    }
}
