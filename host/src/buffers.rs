//! Estimator memory for a line count that is only known at run time.

use quadcal::device::LearnerMemory;
use quadcal::estimate::{EdgeBuffers, Parts, blocks_for};
use quadcal::shape::EncoderShape;

/// Buffers of any size on the heap.
pub struct HeapBuffers {
    sum: Vec<i32>,
    cells: Vec<i16>,
    coarse: Vec<i32>,
}

impl HeapBuffers {
    /// Zeroed buffers for `edges` edges a turn.
    #[must_use]
    pub fn new(edges: usize) -> Self {
        Self {
            sum: vec![0; edges],
            cells: vec![0; edges],
            coarse: vec![0; 3 * blocks_for(edges)],
        }
    }
}

impl EdgeBuffers for HeapBuffers {
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: &mut self.sum,
            cells: &mut self.cells,
            coarse: &mut self.coarse,
        }
    }

    fn cells(&self) -> &[i16] {
        &self.cells
    }

    fn edges(&self) -> usize {
        self.sum.len()
    }
}

/// Buffers for a device's learner, made anew whenever it wants them.
pub struct HeapMemory(pub EncoderShape);

impl LearnerMemory for HeapMemory {
    type Buffers = HeapBuffers;

    fn take(&mut self) -> Option<HeapBuffers> {
        Some(HeapBuffers::new(self.0.edges() as usize))
    }
}
