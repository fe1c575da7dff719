//! Memory of the estimator: a running sum and the turn coming in for every edge, three coarser sums for every block of edges.

/// Blocks of a turn that [`StaticBuffers`] has room for by default.
pub const BLOCKS: usize = 1024;

/// Fewest blocks a turn that an encoder of more edges is learned with.
const BLOCKS_MIN: usize = 128;

/// Memory that an [`Estimator`](super::Estimator) works in, six bytes an edge and twelve a block. Firmware takes
/// [`StaticBuffers`]; a host that learns the line count at run time brings slices of its own.
pub trait EdgeBuffers {
    /// All of it, to write.
    fn parts(&mut self) -> Parts<'_>;
    /// [`Parts::cells`], to read.
    fn cells(&self) -> &[i16];
    /// Edges a turn, N.
    fn edges(&self) -> usize;
}

/// The estimator's memory, part by part.
pub struct Parts<'a> {
    /// Weighted sum over turns of each interval's deviation, one entry an edge.
    pub sum: &'a mut [i32],
    /// The latest turn's deviation of each interval.
    pub cells: &'a mut [i16],
    /// Three sums over turns of each block's deviation: all turns counted alike; the same with signs that cancel whatever
    /// repeats; the weights of the sum with those signs. Each third has room for all blocks.
    pub coarse: &'a mut [i32],
}

/// Edges of a block where `capacity` blocks fit: the shortest block that divides the turn; none where all that do are too
/// long to show an order.
#[must_use]
pub const fn block_edges(edges: usize, capacity: usize) -> Option<usize> {
    let mut size = 1;
    while size <= edges {
        let blocks = edges / size;
        if blocks < BLOCKS_MIN && size > 1 {
            return None;
        }
        if blocks <= capacity && edges.is_multiple_of(size) {
            return Some(size);
        }
        size += 1;
    }
    None
}

/// Blocks to make room for: [`BLOCKS`], or one an edge for an encoder whose edges have no divisor that fits.
#[must_use]
pub const fn blocks_for(edges: usize) -> usize {
    if block_edges(edges, BLOCKS).is_some() {
        BLOCKS
    } else {
        edges
    }
}

/// Buffers for `M` lines of `C` edge classes, N = M x C, as a `static` or a field. `B` is the number of blocks; an
/// encoder whose N has no divisor between N / 128 and N / `B` needs more than the default: [`blocks_for`] tells.
pub struct StaticBuffers<const M: usize, const C: usize, const B: usize = BLOCKS> {
    sum: [[i32; C]; M],
    cells: [[i16; C]; M],
    coarse: [[i32; B]; 3],
}

impl<const M: usize, const C: usize, const B: usize> StaticBuffers<M, C, B> {
    /// Zeroed buffers.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            sum: [[0; C]; M],
            cells: [[0; C]; M],
            coarse: [[0; B]; 3],
        }
    }
}

impl<const M: usize, const C: usize, const B: usize> Default for StaticBuffers<M, C, B> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize, const C: usize, const B: usize> EdgeBuffers for StaticBuffers<M, C, B> {
    #[inline]
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: self.sum.as_flattened_mut(),
            cells: self.cells.as_flattened_mut(),
            coarse: self.coarse.as_flattened_mut(),
        }
    }

    fn cells(&self) -> &[i16] {
        self.cells.as_flattened()
    }

    fn edges(&self) -> usize {
        M * C
    }
}

impl<T: EdgeBuffers + ?Sized> EdgeBuffers for &mut T {
    #[inline]
    fn parts(&mut self) -> Parts<'_> {
        (**self).parts()
    }

    fn cells(&self) -> &[i16] {
        (**self).cells()
    }

    fn edges(&self) -> usize {
        (**self).edges()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_divide_the_turn_and_fit() {
        for (edges, size) in [
            (12, 1),
            (1024, 1),
            (2000, 2),
            (4096, 4),
            (10_000, 10),
            (65_536, 64),
            (14_400, 15),
        ] {
            assert_eq!(block_edges(edges, BLOCKS), Some(size), "{edges}");
        }
    }

    #[test]
    fn an_odd_line_count_takes_a_block_an_edge() {
        assert_eq!(block_edges(4 * 2503, BLOCKS), None);
        assert_eq!(blocks_for(4 * 2503), 4 * 2503);
        assert_eq!(block_edges(4 * 2503, 4 * 2503), Some(1));
    }
}
