//! Estimator memory for a line count that is only known at run time.

use quadcal::estimate::EdgeBuffers;

/// Buffers of any size on the heap.
pub struct HeapBuffers {
    sum: Vec<i32>,
    work: Vec<[i16; 2]>,
}

impl HeapBuffers {
    /// Zeroed buffers for `edges` edges a turn.
    #[must_use]
    pub fn new(edges: usize) -> Self {
        Self {
            sum: vec![0; edges],
            work: vec![[0; 2]; edges],
        }
    }
}

impl EdgeBuffers for HeapBuffers {
    fn sum(&mut self) -> &mut [i32] {
        &mut self.sum
    }

    fn work(&mut self) -> &mut [[i16; 2]] {
        &mut self.work
    }

    fn split(&mut self) -> (&mut [i32], &mut [[i16; 2]]) {
        (&mut self.sum, &mut self.work)
    }

    fn cells(&self) -> &[[i16; 2]] {
        &self.work
    }

    fn edges(&self) -> usize {
        self.sum.len()
    }
}
