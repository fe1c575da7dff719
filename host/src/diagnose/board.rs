//! All recordings of a rig, white, and patterns fitted to them together by least squares.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::basis::Basis;
use super::kalman::{ShaftNoise, Whitener};
use super::noise_fit::{self, Free};
use super::seen::Seen;
use super::shaft::ShaftLaw;

/// Parts of each recording that sums are kept for: the last ones are held out, and what is real is in all of them.
pub const PARTS: usize = 10;
/// Parts that parameters are fitted on when the others judge.
pub const FITTED: usize = 7;

/// One recording.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Its residual.
    pub seen: Seen,
    /// Its shaft.
    pub law: ShaftLaw,
    /// Its noise.
    pub noise: ShaftNoise,
    /// What the twin says of it.
    pub declared: Option<ShaftNoise>,
    /// Best stamp its timer can give, s.
    pub least_stamp_s: f64,
    /// Torques that the twin declares: order and N m.
    pub torques: Vec<(f64, f64)>,
    /// Whether the mean speed is the recording's own, so that a steady push says nothing.
    pub free_speed: bool,
    whitener: Whitener,
    /// The residual, white.
    pub white: Vec<f64>,
}

impl Bench {
    /// With the noise that a twin declares, else one found.
    #[must_use]
    pub fn new(
        seen: Seen,
        law: ShaftLaw,
        declared: Option<ShaftNoise>,
        least_stamp_s: f64,
        free_speed: bool,
    ) -> Self {
        let noise = declared.unwrap_or_else(|| first_guess(&seen, &law, least_stamp_s));
        let mut bench = Self {
            seen,
            law,
            noise,
            declared,
            least_stamp_s,
            free_speed,
            torques: Vec::new(),
            whitener: Whitener::default(),
            white: Vec::new(),
        };
        if declared.is_none() {
            let angles = bench.seen.angles.clone();
            bench.noise = bench.noise_of(&angles);
        }
        bench.set_noise(bench.noise);
        bench
    }

    /// The noise that a residual shows.
    #[must_use]
    pub fn noise_of(&self, angles: &[f64]) -> ShaftNoise {
        let free = if self.law.held() {
            Free::Sizes
        } else {
            Free::All
        };
        noise_fit::fit(
            &self.seen.readings,
            angles,
            self.least_stamp_s,
            self.noise,
            free,
        )
    }

    /// Takes another noise.
    pub fn set_noise(&mut self, noise: ShaftNoise) {
        self.noise = noise;
        self.whitener = Whitener::new(&self.seen.readings, noise);
        self.white = self.whitened(self.seen.angles.clone());
    }

    /// A row of angles, white.
    #[must_use]
    pub fn whitened(&self, mut angles: Vec<f64>) -> Vec<f64> {
        self.whitener.whiten(&mut angles);
        angles
    }

    /// The transposed filter.
    pub fn transposed(&self, white: &mut [f64]) {
        self.whitener.transposed(white);
    }

    /// Its filter.
    #[must_use]
    pub const fn whitener(&self) -> &Whitener {
        &self.whitener
    }

    /// Standard deviation of the expected angle of every edge, rad.
    pub fn deviations(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.whitener.deviations()
    }

    /// Edges of a part.
    #[must_use]
    pub fn part(&self, part: usize) -> std::ops::Range<usize> {
        let count = self.seen.len();
        part * count / PARTS..(part + 1) * count / PARTS
    }
}

/// A thousandth of the speed, and stamps as good as the tick.
fn first_guess(seen: &Seen, law: &ShaftLaw, least_stamp_s: f64) -> ShaftNoise {
    let speed = seen.mean_speed();
    let wander = 1e-3 * speed;
    let damping = law.damping(0.0, speed);
    let unheld = !law.held();
    ShaftNoise {
        acceleration: 2.0 * if unheld { speed } else { damping } * wander * wander,
        stamp_s: 3.0 * least_stamp_s,
        drift: if unheld {
            1e-8 * speed * speed * speed
        } else {
            0.0
        },
        forgets_per_s: if unheld { speed } else { 0.0 },
    }
}

/// A pattern, white, in each recording; none where it does not show.
#[derive(Clone, Debug)]
pub struct Column(pub Vec<Option<Vec<f64>>>);

/// Sums of products over every part: recording by recording, part by part.
type Sums = Vec<[f64; PARTS]>;

/// All recordings.
#[derive(Clone, Debug)]
pub struct Board {
    /// One for each recording.
    pub benches: Vec<Bench>,
    /// Whether angles mean the same in all recordings.
    pub tied: bool,
}

/// Patterns fitted together.
#[derive(Clone, Debug)]
pub struct Model {
    /// The patterns.
    pub columns: Vec<Column>,
    /// Their sizes.
    pub sizes: DVector<f64>,
    /// Covariance of the sizes.
    pub covariance: DMatrix<f64>,
    pub(super) factor: Option<Cholesky<f64, Dyn>>,
    /// What is left, white.
    pub left: Vec<Vec<f64>>,
}

impl Model {
    /// Nothing fitted.
    #[must_use]
    pub fn none(board: &Board) -> Self {
        Self {
            columns: Vec::new(),
            sizes: DVector::zeros(0),
            covariance: DMatrix::zeros(0, 0),
            factor: None,
            left: board
                .benches
                .iter()
                .map(|bench| bench.white.clone())
                .collect(),
        }
    }
}

/// What more patterns would do.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Fall of the sum of squares.
    pub squares: f64,
    /// Their sizes.
    pub sizes: DVector<f64>,
}

impl Board {
    /// Edges of all recordings.
    #[must_use]
    pub fn edges(&self) -> usize {
        self.benches.iter().map(|bench| bench.seen.len()).sum()
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
            Column(column)
        })
        .collect()
    }

    /// The same, white.
    #[must_use]
    pub fn nuisances(&self) -> Vec<Column> {
        self.whitened(self.raw_nuisances())
    }

    fn whitened(&self, columns: Vec<Column>) -> Vec<Column> {
        let white = |column: Column| {
            let parts = column.0.into_iter().zip(&self.benches);
            Column(
                parts
                    .map(|(part, bench)| part.map(|part| bench.whitened(part)))
                    .collect(),
            )
        };
        columns.into_iter().map(white).collect()
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
        let raw = self
            .benches
            .iter()
            .map(|bench| basis.columns(&bench.seen, &bench.law));
        let count = self.benches.len();
        if own {
            let mut columns = Vec::new();
            for (at, parts) in raw.enumerate() {
                for part in parts {
                    let mut column = vec![None; count];
                    column[at] = Some(part);
                    columns.push(Column(column));
                }
            }
            columns
        } else {
            let mut columns = vec![Column(Vec::with_capacity(count)); basis.count()];
            for parts in raw {
                for (column, part) in columns.iter_mut().zip(parts) {
                    column.0.push(Some(part));
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
            bench.set_noise(bench.noise);
        }
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
                changed = true;
            }
        }
        changed
    }

    /// Fits columns together; none where they can't be told apart.
    #[must_use]
    pub fn fit(&self, columns: Vec<Column>) -> Option<Model> {
        let white: Vec<&[f64]> = self.benches.iter().map(|b| b.white.as_slice()).collect();
        let count = columns.len();
        let mut left: Vec<Vec<f64>> = white.iter().map(|w| w.to_vec()).collect();
        if count == 0 {
            return Some(Model {
                columns,
                sizes: DVector::zeros(0),
                covariance: DMatrix::zeros(0, 0),
                factor: None,
                left,
            });
        }
        let (mut gram, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for i in 0..count {
            right[i] = with_rows(&columns[i], &left);
            for j in 0..=i {
                gram[(i, j)] = product(&columns[i], &columns[j]);
                gram[(j, i)] = gram[(i, j)];
            }
        }
        // Sizes of any unit: scaled to one before.
        let scale: Vec<f64> = (0..count).map(|i| gram[(i, i)].sqrt().recip()).collect();
        if scale.iter().any(|scale| !scale.is_finite()) {
            return None;
        }
        for i in 0..count {
            right[i] *= scale[i];
            for j in 0..count {
                gram[(i, j)] *= scale[i] * scale[j];
            }
        }
        let worst = (0..count).map(|i| gram[(i, i)]).fold(0.0, f64::max);
        let factor = gram.cholesky()?;
        let narrow = factor.l_dirty().diagonal().min();
        if narrow * narrow < 1e-9 * worst {
            return None;
        }
        let unit = factor.solve(&right);
        let mut covariance = factor.inverse();
        for i in 0..count {
            for j in 0..count {
                covariance[(i, j)] *= scale[i] * scale[j];
            }
        }
        let sizes = DVector::from_iterator(count, unit.iter().zip(&scale).map(|(u, s)| u * s));
        for (column, size) in columns.iter().zip(sizes.iter()) {
            for (left, part) in left.iter_mut().zip(&column.0) {
                if let Some(part) = part {
                    for (left, value) in left.iter_mut().zip(part) {
                        *left -= size * value;
                    }
                }
            }
        }
        Some(Model {
            columns,
            sizes,
            covariance,
            factor: Some(factor),
            left,
        })
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
            Column(each.collect())
        };
        columns.iter().map(cut).collect()
    }

    /// Columns with given sizes.
    #[must_use]
    pub fn with_sizes(&self, columns: &[Column], sizes: &DVector<f64>) -> Model {
        let mut left: Vec<Vec<f64>> = self
            .benches
            .iter()
            .map(|bench| bench.white.clone())
            .collect();
        for (column, size) in columns.iter().zip(sizes.iter()) {
            for (left, part) in left.iter_mut().zip(&column.0) {
                if let Some(part) = part {
                    for (left, value) in left.iter_mut().zip(part) {
                        *left -= size * value;
                    }
                }
            }
        }
        Model {
            columns: Vec::new(),
            sizes: sizes.clone(),
            covariance: DMatrix::zeros(0, 0),
            factor: None,
            left,
        }
    }

    /// What more columns would explain of what a model leaves.
    #[must_use]
    pub fn gain(&self, model: &Model, more: &[Column]) -> Option<Gain> {
        let (old, new) = (model.columns.len(), more.len());
        let mut gram = DMatrix::zeros(new, new);
        let mut right = DVector::zeros(new);
        let mut across = DMatrix::zeros(old, new);
        for i in 0..new {
            right[i] = with_rows(&more[i], &model.left);
            for j in 0..=i {
                gram[(i, j)] = product(&more[i], &more[j]);
                gram[(j, i)] = gram[(i, j)];
            }
            for (k, column) in model.columns.iter().enumerate() {
                across[(k, i)] = product(column, &more[i]);
            }
        }
        let whole: Vec<f64> = (0..new).map(|i| gram[(i, i)]).collect();
        if let Some(factor) = &model.factor {
            let norms: Vec<f64> = model.columns.iter().map(|c| product(c, c).sqrt()).collect();
            for k in 0..old {
                for i in 0..new {
                    across[(k, i)] /= norms[k];
                }
            }
            gram -= across.transpose() * factor.solve(&across);
        }
        // What the model has already can't be sized.
        if (0..new).any(|i| gram[(i, i)].is_nan() || gram[(i, i)] <= 1e-7 * whole[i]) {
            return None;
        }
        let scale: Vec<f64> = (0..new).map(|i| gram[(i, i)].sqrt().recip()).collect();
        for i in 0..new {
            right[i] *= scale[i];
            for j in 0..new {
                gram[(i, j)] *= scale[i] * scale[j];
            }
        }
        let factor = gram.cholesky()?;
        let unit = factor.solve(&right);
        let squares = unit.dot(&right);
        // No more than there is: else the columns are too alike to be told apart.
        let narrow = factor.l_dirty().diagonal().min();
        let most: f64 = model.left.iter().flatten().map(|w| w * w).sum();
        if narrow < 1e-4 || squares > most {
            return None;
        }
        let sizes = DVector::from_iterator(new, unit.iter().zip(&scale).map(|(u, s)| u * s));
        squares.is_finite().then_some(Gain { squares, sizes })
    }

    /// Sums of products of columns over parts.
    #[must_use]
    pub fn parts(&self, a: &Column, b: &[Option<&[f64]>]) -> Sums {
        self.benches
            .iter()
            .enumerate()
            .map(|(at, bench)| {
                let (Some(a), Some(b)) = (&a.0[at], b[at]) else {
                    return [0.0; PARTS];
                };
                std::array::from_fn(|part| {
                    let range = bench.part(part);
                    dot(&a[range.clone()], &b[range])
                })
            })
            .collect()
    }
}

/// Product of two columns.
#[must_use]
pub fn product(a: &Column, b: &Column) -> f64 {
    let each = a.0.iter().zip(&b.0);
    each.map(|(a, b)| match (a, b) {
        (Some(a), Some(b)) => dot(a, b),
        _ => 0.0,
    })
    .sum()
}

/// Product of a column with rows.
#[must_use]
pub fn with_rows(a: &Column, rows: &[Vec<f64>]) -> f64 {
    let each = a.0.iter().zip(rows);
    each.map(|(a, row)| a.as_ref().map_or(0.0, |a| dot(a, row)))
        .sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums at once.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4
        .remainder()
        .iter()
        .zip(b4.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    rest + sums.iter().sum::<f64>()
}
