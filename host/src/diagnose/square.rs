//! Small square matrices, and their products with states that run side by side.

use std::array::from_fn;
use std::ops::{Index, IndexMut};

use super::filter::State;
use super::lsq::add;

/// A square matrix, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Square<const N: usize>(pub [[f64; N]; N]);

impl<const N: usize> Default for Square<N> {
    fn default() -> Self {
        Self([[0.0; N]; N])
    }
}

impl<const N: usize> Index<(State, State)> for Square<N> {
    type Output = f64;

    #[inline]
    fn index(&self, (row, column): (State, State)) -> &f64 {
        &self.0[row as usize][column as usize]
    }
}

impl<const N: usize> IndexMut<(State, State)> for Square<N> {
    #[inline]
    fn index_mut(&mut self, (row, column): (State, State)) -> &mut f64 {
        &mut self.0[row as usize][column as usize]
    }
}

impl<const N: usize> Square<N> {
    /// Its first rows and columns, or it with rows and columns of nothing.
    #[inline]
    pub fn resized<const M: usize>(&self) -> Square<M> {
        let mut all = Square::default();
        all.add(1.0, self);
        all
    }

    /// Adds so much of the first rows and columns of another one.
    #[inline]
    pub fn add<const M: usize>(&mut self, by: f64, other: &Square<M>) {
        for (into, of) in self.0.iter_mut().zip(&other.0) {
            add(into, by, of);
        }
    }
}

/// What changes nothing.
pub fn identity<const N: usize>() -> Square<N> {
    Square(from_fn(|row| {
        from_fn(|column| f64::from(u8::from(row == column)))
    }))
}

/// A B.
pub fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    Square(times(a, &b.0))
}

/// A matrix times states, side by side.
#[inline(always)]
pub fn times<const N: usize, const L: usize>(
    way: &Square<N>,
    state: &[[f64; L]; N],
) -> [[f64; L]; N] {
    let mut end = [[0.0; L]; N];
    for (end, way) in end.iter_mut().zip(&way.0) {
        for (state, way) in state.iter().zip(way) {
            for (end, of) in end.iter_mut().zip(state) {
                *end += way * of;
            }
        }
    }
    end
}

/// A transposed matrix times states, side by side.
#[inline(always)]
pub fn back<const N: usize, const L: usize>(
    way: &Square<N>,
    state: &[[f64; L]; N],
) -> [[f64; L]; N] {
    let mut end = [[0.0; L]; N];
    for (row, state) in way.0.iter().zip(state) {
        for (end, way) in end.iter_mut().zip(row) {
            for (end, of) in end.iter_mut().zip(state) {
                *end += way * of;
            }
        }
    }
    end
}

/// F P F'.
pub fn through<const N: usize>(way: &Square<N>, p: &Square<N>) -> Square<N> {
    let across = Square(from_fn(|row| from_fn(|column| way.0[column][row])));
    let mut end = product(&product(way, p), &across);
    for row in 0..N {
        for column in row + 1..N {
            end.0[column][row] = end.0[row][column];
        }
    }
    end
}
