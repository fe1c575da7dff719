//! Learning a table: [`quadcal::estimate`].

use core::mem;

use quadcal::decoder::QuadratureDecoder;
use quadcal::edge::{Levels, Sample};
use quadcal::estimate::{
    Anchor, EdgeBuffers, Estimator, Parts, Progress, Slice, Solution, Solver, blocks_for,
};
use quadcal::shape::EncoderShape;
use quadcal::slot::{self, SlotHeader, slot_bytes};
use quadcal::units::Ticks;

use crate::memory::{fits, give, held, hold_filled, items, items_mut, status};
use crate::quadcal_status::*;
use crate::{quadcal_config, quadcal_status};

/// 64-bit words of a quadcal_learner.
pub const QUADCAL_LEARNER_WORDS: usize = 2016;

/// What learns a table, opaque; large, so best a static variable. Belongs to the main loop. Set it to all zeros (a static variable is) or
/// start it before any other call.
#[repr(C)]
// A host's numbers of 128 bits are aligned to as many; on a Cortex-M the words' own alignment is enough.
#[cfg_attr(not(target_os = "none"), repr(align(16)))]
pub struct quadcal_learner {
    /// Not to be touched.
    pub memory: [u64; QUADCAL_LEARNER_WORDS],
}

/// One capture with its whole time, as the capture interrupt queues it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct quadcal_sample {
    /// Time, ticks, from quadcal_capture_time.
    pub ticks: u64,
    /// Levels after the change: bit 0 is A, bit 1 is B, bit 2 is Z.
    pub levels: u8,
}

/// The caller's memory in the parts that the estimator wants.
struct Buffers {
    sum: &'static mut [i32],
    cells: &'static mut [i16],
    coarse: &'static mut [i32],
}

impl Buffers {
    /// Words of 32 bits for `edges` edges: the sums, the blocks and the cells.
    const fn words(edges: usize) -> usize {
        edges + 3 * blocks_for(edges) + edges / 2
    }

    /// The memory of so many edges, a multiple of four.
    ///
    /// # Safety
    /// `words` are the caller's to give away, and initialised.
    unsafe fn of(words: &'static mut [u32], edges: usize) -> Result<Self, quadcal_status> {
        let blocks = 3 * blocks_for(edges);
        let (sum, rest) = words
            .split_at_mut_checked(edges)
            .ok_or(QUADCAL_ERROR_MEMORY)?;
        let (coarse, rest) = rest
            .split_at_mut_checked(blocks)
            .ok_or(QUADCAL_ERROR_MEMORY)?;
        let cells = rest.get_mut(..edges / 2).ok_or(QUADCAL_ERROR_MEMORY)?;
        // SAFETY: words are aligned for all of these, and every pattern of bits is a value of each.
        let (sum, coarse, cells) = unsafe {
            (
                sum.align_to_mut().1,
                coarse.align_to_mut().1,
                cells.align_to_mut().1,
            )
        };
        Ok(Self { sum, cells, coarse })
    }
}

impl EdgeBuffers for Buffers {
    #[inline]
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: self.sum,
            cells: self.cells,
            coarse: self.coarse,
        }
    }

    fn cells(&self) -> &[i16] {
        self.cells
    }

    fn edges(&self) -> usize {
        self.sum.len()
    }
}

// One takes the place of the other.
#[allow(clippy::large_enum_variant)]
enum Stage {
    /// Takes samples, or, once `begun`, solves.
    Learning {
        estimator: Estimator<Buffers>,
        begun: bool,
    },
    Solved(Solution<Buffers>),
    /// Between two of them; never seen.
    Moving,
}

/// What stands behind a [`quadcal_learner`].
struct State {
    stage: Stage,
    solver: Solver,
    decoder: QuadratureDecoder,
    shape: EncoderShape,
    indexed: bool,
    clock_hz: u64,
    learned_until: Ticks,
}

const _: () = fits::<State, quadcal_learner>();

/// Bytes of memory that `quadcal_learn_start` wants for an encoder of so many lines, 0 for lines out of range. QUADCAL_LEARN_BYTES is the same at
/// compile time, for all line counts but those whose edges have no divisor that fits.
#[unsafe(no_mangle)]
pub extern "C" fn quadcal_learn_bytes(lines: u32) -> usize {
    EncoderShape::new(lines.saturating_mul(4), 4)
        .map_or(0, |shape| 4 * Buffers::words(shape.edges() as usize))
}

/// Starts to learn with nothing known. The memory is the learner's until it is started again; it is aligned to 4 bytes, and static
/// memory or set to zero.
///
/// # Safety
/// As said at `quadcal_learner`; `memory` has `length` initialised bytes that nobody else uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_learn_start(
    learner: *mut quadcal_learner,
    config: *const quadcal_config,
    memory: *mut u32,
    length: usize,
) -> quadcal_status {
    let start = || {
        // SAFETY: the caller's word, passed on, here and below.
        let [config] = unsafe { items(config, 1) }? else {
            return Err(QUADCAL_ERROR_POINTER);
        };
        let encoder = config.of_encoder();
        let decoder = QuadratureDecoder::new(encoder.decoder)
            .map_err(quadcal::encoder::EncoderError::Sensor)?;
        let shape = EncoderShape::new(decoder.slots(), 4).map_err(|_| QUADCAL_ERROR_LINES)?;
        let words = unsafe { items_mut(memory, length / 4) }?;
        let buffers = unsafe { Buffers::of(words, shape.edges() as usize) }?;
        let estimator =
            Estimator::new(shape, encoder.anchor, buffers).map_err(|_| QUADCAL_ERROR_MEMORY)?;
        let stage = Stage::Learning {
            estimator,
            begun: false,
        };
        let fill = |state: *mut State| {
            // SAFETY: the place is for a state, and every field of one is written. One by one, as all of it is much for a stack.
            unsafe {
                (&raw mut (*state).stage).write(stage);
                (&raw mut (*state).solver).write(Solver::new());
                (&raw mut (*state).decoder).write(decoder);
                (&raw mut (*state).shape).write(shape);
                (&raw mut (*state).indexed).write(encoder.anchor == Anchor::Index);
                (&raw mut (*state).clock_hz).write(config.clock_hz);
                (&raw mut (*state).learned_until).write(0);
            }
        };
        unsafe { hold_filled(learner, fill) }?;
        Ok(QUADCAL_OK)
    };
    status(start())
}

/// Learns from samples, in order and without a gap, all captures of A, B and Z; turns taken so far come in `turns`, unless it is null.
///
/// # Safety
/// As said at `quadcal_learner`; `samples` has `count` items, and `turns` is a number or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_learn_samples(
    learner: *mut quadcal_learner,
    samples: *const quadcal_sample,
    count: usize,
    turns: *mut u32,
) -> quadcal_status {
    let learn = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(learner) }?;
        let samples = unsafe { items(samples, count) }?;
        let Stage::Learning {
            estimator,
            begun: false,
        } = &mut state.stage
        else {
            return Err(QUADCAL_ERROR_STAGE);
        };
        for sample in samples {
            let outcome = state.decoder.push(Sample {
                ticks: sample.ticks,
                levels: Levels(sample.levels),
            });
            if let Progress::TurnTaken(_) = estimator.push(&outcome) {
                state.learned_until = sample.ticks;
            }
        }
        if !turns.is_null() {
            unsafe { give(turns, estimator.totals().turns) }?;
        }
        Ok(QUADCAL_OK)
    };
    status(learn())
}

/// Solves for a part, in fewer than 20,000 instructions of a Cortex-M4: QUADCAL_MORE until the table is there, then QUADCAL_OK. From the
/// first slice on samples are refused. How much is done comes in `percent`, unless it is null.
///
/// # Safety
/// As said at `quadcal_learner`; `percent` is a number or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_learn_slice(
    learner: *mut quadcal_learner,
    percent: *mut u32,
) -> quadcal_status {
    let solve = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(learner) }?;
        let Stage::Learning { estimator, begun } = &mut state.stage else {
            return Err(QUADCAL_ERROR_STAGE);
        };
        let slice = estimator
            .slice(&mut state.solver)
            .map_err(|_| QUADCAL_ERROR_TOO_FEW_TURNS)?;
        *begun = true;
        let (done, status) = match slice {
            Slice::More(done) => (u32::from(done), QUADCAL_MORE),
            Slice::Solved(findings) => {
                if let Stage::Learning { estimator, .. } =
                    mem::replace(&mut state.stage, Stage::Moving)
                {
                    state.stage = Stage::Solved(estimator.finish(findings));
                }
                (100, QUADCAL_OK)
            }
        };
        if !percent.is_null() {
            unsafe { give(percent, done) }?;
        }
        Ok(status)
    };
    status(solve())
}

/// Writes the learned table's bytes, with their check sum, and how many they are: 164 + 8 for each line. A place in flash or RAM takes them as
/// they are.
///
/// # Safety
/// As said at `quadcal_learner`; `bytes` has `room` initialised ones, and `length` is a number or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_learn_table(
    learner: *mut quadcal_learner,
    bytes: *mut u8,
    room: usize,
    length: *mut usize,
) -> quadcal_status {
    let write = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(learner) }?;
        let mut place = unsafe { items_mut(bytes, room) }?;
        let Stage::Solved(solution) = &state.stage else {
            return Err(QUADCAL_ERROR_STAGE);
        };
        let needed = slot_bytes(state.shape);
        if room < needed {
            return Err(QUADCAL_ERROR_MEMORY);
        }
        unsafe { give(length, needed) }?;
        let header = SlotHeader {
            indexed: state.indexed,
            ..SlotHeader::of(solution, state.learned_until, state.clock_hz)
        };
        slot::write(&header, solution.entries(), |piece| {
            let (now, later) = mem::take(&mut place)
                .split_at_mut_checked(piece.len())
                .ok_or(QUADCAL_ERROR_MEMORY)?;
            now.copy_from_slice(piece);
            place = later;
            Ok::<(), quadcal_status>(())
        })?;
        Ok(QUADCAL_OK)
    };
    status(write())
}
