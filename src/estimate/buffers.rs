//! Memory of the estimator: one running sum and two 16-bit cells for every edge of a turn.

/// Memory that an [`Estimator`](super::Estimator) works in, eight bytes an edge. Firmware takes [`StaticBuffers`];
/// a host that learns the line count at run time brings slices of its own.
pub trait EdgeBuffers {
    /// Sum over turns of each interval's deviation, one entry an edge.
    fn sum(&mut self) -> &mut [i32];
    /// Two cells an edge: the latest turn's deviation and the contrast between turns.
    fn work(&mut self) -> &mut [[i16; 2]];
    /// Both at once.
    fn split(&mut self) -> (&mut [i32], &mut [[i16; 2]]);
    /// The cells of [`EdgeBuffers::work`], to read.
    fn cells(&self) -> &[[i16; 2]];
    /// Edges a turn, N.
    fn edges(&self) -> usize;
}

/// Buffers for `M` lines of `C` edge classes, N = M x C, as a `static` or a field.
pub struct StaticBuffers<const M: usize, const C: usize> {
    sum: [[i32; C]; M],
    work: [[[i16; 2]; C]; M],
}

impl<const M: usize, const C: usize> StaticBuffers<M, C> {
    /// Zeroed buffers.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            sum: [[0; C]; M],
            work: [[[0; 2]; C]; M],
        }
    }
}

impl<const M: usize, const C: usize> Default for StaticBuffers<M, C> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize, const C: usize> EdgeBuffers for StaticBuffers<M, C> {
    fn sum(&mut self) -> &mut [i32] {
        self.sum.as_flattened_mut()
    }

    fn work(&mut self) -> &mut [[i16; 2]] {
        self.work.as_flattened_mut()
    }

    fn split(&mut self) -> (&mut [i32], &mut [[i16; 2]]) {
        (self.sum.as_flattened_mut(), self.work.as_flattened_mut())
    }

    fn cells(&self) -> &[[i16; 2]] {
        self.work.as_flattened()
    }

    fn edges(&self) -> usize {
        M * C
    }
}

impl<T: EdgeBuffers + ?Sized> EdgeBuffers for &mut T {
    fn sum(&mut self) -> &mut [i32] {
        (**self).sum()
    }

    fn work(&mut self) -> &mut [[i16; 2]] {
        (**self).work()
    }

    fn split(&mut self) -> (&mut [i32], &mut [[i16; 2]]) {
        (**self).split()
    }

    fn cells(&self) -> &[[i16; 2]] {
        (**self).cells()
    }

    fn edges(&self) -> usize {
        (**self).edges()
    }
}

/// Reads the two cells of an edge as one 32-bit number.
pub(super) fn read_wide(cells: [i16; 2]) -> i32 {
    (i32::from(cells[1]) << 16) | i32::from(cells[0].cast_unsigned())
}

/// Writes one 32-bit number over the two cells of an edge.
pub(super) fn write_wide(value: i32) -> [i16; 2] {
    #[allow(clippy::cast_possible_truncation)]
    [value as i16, (value >> 16) as i16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_number_survives_the_two_cells() {
        for value in [
            0,
            1,
            -1,
            32767,
            32768,
            -32768,
            -32769,
            65535,
            65536,
            i32::MAX,
            i32::MIN,
            0x1234_8765,
        ] {
            assert_eq!(read_wide(write_wide(value)), value);
        }
    }
}
