//! Small square matrices, and their products with states that run side by side.

/// A square matrix.
pub type Square<const N: usize> = [[f64; N]; N];

/// What changes nothing.
#[must_use]
pub fn identity<const N: usize>() -> Square<N> {
    let mut one = [[0.0; N]; N];
    for (at, row) in one.iter_mut().enumerate() {
        row[at] = 1.0;
    }
    one
}

/// A B.
#[must_use]
pub fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    let mut c = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..N {
            c[row][column] = (0..N).map(|k| a[row][k] * b[k][column]).sum();
        }
    }
    c
}

/// A matrix times states, side by side.
#[inline(always)]
pub fn times<const N: usize, const L: usize>(
    way: &Square<N>,
    state: &[[f64; L]; N],
) -> [[f64; L]; N] {
    let mut end = [[0.0; L]; N];
    for (end, way) in end.iter_mut().zip(way) {
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
    for (row, state) in way.iter().zip(state) {
        for (end, way) in end.iter_mut().zip(row) {
            for (end, of) in end.iter_mut().zip(state) {
                *end += way * of;
            }
        }
    }
    end
}

/// F P F'.
#[must_use]
pub fn through<const N: usize>(way: &Square<N>, p: &Square<N>) -> Square<N> {
    let half = product(way, p);
    let mut end = [[0.0; N]; N];
    for row in 0..N {
        for column in row..N {
            let sum: f64 = (0..N).map(|k| half[row][k] * way[column][k]).sum();
            end[row][column] = sum;
            end[column][row] = sum;
        }
    }
    end
}
