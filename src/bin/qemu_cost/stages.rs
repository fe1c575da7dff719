//! The edge path, one function a stage, never inlined: so each stage has a symbol whose machine code can be looked into.

use core::hint::black_box;

use quadcal::corrector::{CorrectedEdge, Corrector};
use quadcal::decoder::QuadratureDecoder;
use quadcal::edge::Sample;
use quadcal::estimate::{EdgeBuffers, Estimator, Progress};
use quadcal::replay::Event;
use quadcal::step::Outcome;
use quadcal::timebase::Timebase32;
use quadcal::units::{Ticks, Turn32};

/// Time base and decoder. An overflow is an outcome without an edge.
#[inline(never)]
pub fn front(base: &mut Timebase32, decoder: &mut QuadratureDecoder, event: &Event) -> Outcome {
    match *event {
        Event::Overflow => {
            base.overflow();
            Outcome::Idle
        }
        Event::Capture {
            raw,
            levels,
            overflow_pending,
        } => {
            let ticks = base.capture_first(raw, overflow_pending);
            decoder.push(Sample { ticks, levels })
        }
    }
}

/// Estimator.
#[inline(never)]
pub fn learn<B: EdgeBuffers>(estimator: &mut Estimator<B>, outcome: &Outcome) -> Progress {
    estimator.push(outcome)
}

/// Corrector.
#[inline(never)]
pub fn correct(corrector: &mut Corrector<'_>, outcome: &Outcome) -> Option<CorrectedEdge> {
    corrector.push(outcome)
}

/// Angle between edges.
#[inline(never)]
pub fn angle_at(corrector: &Corrector<'_>, now: Ticks) -> Option<Turn32> {
    corrector.angle_at(now)
}

/// What a loop and a call cost by themselves.
#[inline(never)]
pub fn nothing<T>(item: &T) {
    black_box(item);
}
