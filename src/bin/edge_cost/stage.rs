//! Counting what a stage takes.

use core::hint::black_box;

use cortex_m_semihosting::hprintln;
use quadcal::edge::Sample;

use super::counter::InstructionCounter;
use super::rig::BLOCK;

/// Instructions of one stage, summed over blocks.
#[derive(Default)]
pub struct Stage {
    instructions: u64,
    edges: u64,
}

impl Stage {
    /// Counts what `work` takes for a block of edges.
    pub fn count(&mut self, counter: &InstructionCounter, work: impl FnOnce()) {
        let begin = counter.now();
        work();
        self.instructions += counter.now() - begin;
        self.edges += BLOCK as u64;
    }

    /// Prints instructions an edge to a tenth, `empty` taken off.
    pub fn print(&self, name: &str, empty: &Self) {
        let tenths = |stage: &Self| stage.instructions * 10 / stage.edges.max(1);
        let net = tenths(self).saturating_sub(tenths(empty));
        hprintln!("{}={}.{}", name, net / 10, net % 10);
    }
}

/// The loop over samples alone.
#[inline(never)]
pub fn idle(samples: &[Sample]) {
    for sample in samples {
        black_box(black_box(sample));
    }
}
