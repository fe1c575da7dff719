//! A pattern as it shows in every recording, shared and not copied, and products of patterns that were worked out before.

use std::collections::HashMap;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A pattern in one recording, one value an edge.
#[derive(Clone, Debug)]
pub struct Part {
    values: Arc<Vec<f64>>,
    /// Its own number if its products are kept; no two parts have the same.
    number: Option<u64>,
}

impl From<Vec<f64>> for Part {
    fn from(values: Vec<f64>) -> Self {
        Self {
            values: Arc::new(values),
            number: None,
        }
    }
}

impl Deref for Part {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values
    }
}

impl<'a> IntoIterator for &'a Part {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.values.iter()
    }
}

impl Part {
    /// The same, its products kept from now on.
    fn kept(mut self) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let next = || NEXT.fetch_add(1, Ordering::Relaxed);
        self.number = Some(self.number.unwrap_or_else(next));
        self
    }
}

/// A pattern in each recording; none where it does not show.
#[derive(Clone, Debug)]
pub struct Column(pub Vec<Option<Part>>);

impl Column {
    /// Of values of each recording.
    #[must_use]
    pub fn of(parts: impl IntoIterator<Item = Option<Vec<f64>>>) -> Self {
        let parts = parts.into_iter();
        Self(parts.map(|part| part.map(Part::from)).collect())
    }

    /// The same, its products kept from now on: worth it for what is fitted again and again.
    #[must_use]
    pub fn kept(self) -> Self {
        let parts = self.0.into_iter();
        Self(parts.map(|part| part.map(Part::kept)).collect())
    }
}

/// Products of parts that are kept.
#[derive(Clone, Debug, Default)]
pub struct Products(Arc<Mutex<HashMap<(u64, u64), f64>>>);

impl Products {
    /// Product of two columns.
    #[must_use]
    pub fn of(&self, a: &Column, b: &Column) -> f64 {
        let each = a.0.iter().zip(&b.0);
        each.map(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => self.of_parts(a, b),
            _ => 0.0,
        })
        .sum()
    }

    fn of_parts(&self, a: &Part, b: &Part) -> f64 {
        let (Some(one), Some(other)) = (a.number, b.number) else {
            return dot(a, b);
        };
        let pair = (one.min(other), one.max(other));
        // Nothing is ever half done in there.
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&pair).copied();
        found.unwrap_or_else(|| {
            let product = dot(a, b);
            known().insert(pair, product);
            product
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_that_is_kept_is_that_of_its_own_columns() {
        let column = |values: &[f64]| Column::of([Some(values.to_vec()), None]);
        let products = Products::default();
        let (a, b) = (column(&[1.0, 2.0]).kept(), column(&[3.0, 4.0]).kept());
        let c = column(&[5.0, -6.0]);
        for _ in 0..2 {
            assert_eq!(products.of(&a, &b), 11.0);
            assert_eq!(products.of(&b, &a), 11.0);
            assert_eq!(products.of(&a, &a), 5.0);
            assert_eq!(products.of(&a, &c), -7.0);
        }
        // What shares its values shares its products; what has the place of another in memory does not.
        assert_eq!(products.of(&a.clone().kept(), &b), 11.0);
        drop(b);
        assert_eq!(products.of(&a, &column(&[7.0, 8.0]).kept()), 23.0);
    }
}
