//! A whole session, bytes in and bytes out: learn from the first turns, then correct the rest; or correct all with a table learned
//! before. The same code runs in a firmware image and on the host, so that the two can be held against each other byte for byte.

use core::fmt;

use super::corrected::{CorrectedHeader, emit_edge, emit_faults};
use super::{Event, EventReader, ReadError, TimerWidth, Wiring};
use crate::corrector::Corrector;
use crate::decoder::{DecoderConfig, QuadratureDecoder};
use crate::edge::Sample;
use crate::estimate::{
    Anchor, EdgeBuffers, Estimator, Progress, Slice, Solution, SolveError, Solver, Totals,
};
use crate::shape::{EncoderShape, ShapeError};
use crate::slot::{self, Delays, Slot, SlotHeader};
use crate::step::{Faults, SensorError};
use crate::table::{Entry, ErrorTable, TableError};
use crate::timebase::{Timebase16, Timebase32};
use crate::units::Ticks;

/// Turns that are learned where the event file names none.
pub const TURNS_DEFAULT: u32 = 11;

/// Edge classes of a quadrature encoder.
const CLASSES: u32 = 4;

/// What the bytes handed to a sink belong to. All of the slot comes before the corrected file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Part {
    /// The learned table, as [`crate::slot`] describes.
    Slot,
    /// The corrected edges and the fault counts, as [`super::corrected`] describes.
    Corrected,
}

/// What a session did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Turns taken and rejected while learning.
    pub learned: Totals,
    /// Edges corrected.
    pub corrected: u32,
    /// Faults of the whole stream.
    pub faults: Faults,
}

/// Why a session ended early; `F` is the error of the file or memory behind source and sink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SessionError<F> {
    /// The events can't be read.
    Read(ReadError<F>),
    /// The sink failed.
    Sink(F),
    /// Not a quadrature encoder.
    Wiring(Wiring),
    /// Another number of lines than this session has memory for.
    Lines {
        /// Lines of the event file.
        wanted: u32,
        /// Edges a turn that there is memory for.
        edges: usize,
    },
    /// The encoder can't be described.
    Shape(ShapeError),
    /// The decoder can't be set up.
    Sensor(SensorError),
    /// The stream ended before enough turns were whole.
    TooFewTurns(Totals),
    /// The turns can't be solved: fewer than two were asked for.
    Solve(SolveError),
    /// The solved table can't be used.
    Table(TableError),
}

impl<F> From<ReadError<F>> for SessionError<F> {
    fn from(error: ReadError<F>) -> Self {
        Self::Read(error)
    }
}

impl<F: fmt::Display> fmt::Display for SessionError<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => error.fmt(f),
            Self::Sink(error) => error.fmt(f),
            Self::Wiring(wiring) => write!(f, "{wiring:?} wired, expected quadrature"),
            Self::Lines { wanted, edges } => {
                write!(f, "{wanted} lines, but memory for {edges} edges")
            }
            Self::Shape(error) => write!(f, "encoder out of range: {error:?}"),
            Self::Sensor(error) => write!(f, "decoder refused: {error:?}"),
            Self::TooFewTurns(totals) => write!(
                f,
                "the stream ended after {} whole turns ({} broken, {} irregular, {} with a change of speed)",
                totals.turns, totals.broken, totals.irregular, totals.speed_change
            ),
            Self::Solve(error) => write!(f, "can't solve: {error:?}"),
            Self::Table(error) => write!(f, "table out of range: {error:?}"),
        }
    }
}

impl<F: fmt::Debug + fmt::Display> core::error::Error for SessionError<F> {}

/// Time base and decoder: from events to outcomes.
struct Front<'a, S> {
    events: EventReader<'a, S>,
    clock: Clock,
    decoder: QuadratureDecoder,
}

enum Clock {
    Bits16(Timebase16),
    Bits32(Timebase32),
}

impl Clock {
    fn sample(&mut self, event: Event) -> Option<Sample> {
        match (event, self) {
            (Event::Overflow, Self::Bits16(base)) => base.overflow(),
            (Event::Overflow, Self::Bits32(base)) => base.overflow(),
            (
                Event::Capture {
                    raw,
                    levels,
                    overflow_pending,
                },
                clock,
            ) => {
                let ticks = match clock {
                    Self::Bits16(base) => base.capture_first(raw, overflow_pending),
                    Self::Bits32(base) => base.capture_first(raw, overflow_pending),
                };
                return Some(Sample { ticks, levels });
            }
        }
        None
    }
}

impl<'a, S, F> Front<'a, S>
where
    S: FnMut(&mut [u8]) -> Result<usize, F>,
{
    /// Reads the header; the stream must be of an encoder with so many edges a turn.
    fn new(source: S, block: &'a mut [u8], edges: usize) -> Result<Self, SessionError<F>> {
        let events = EventReader::new(source, block)?;
        let header = *events.header();
        if header.wiring != Wiring::Quadrature {
            return Err(SessionError::Wiring(header.wiring));
        }
        if u64::from(header.lines) * u64::from(CLASSES) != edges as u64 {
            return Err(SessionError::Lines {
                wanted: header.lines,
                edges,
            });
        }
        let decoder = QuadratureDecoder::new(DecoderConfig::new(header.lines))
            .map_err(SessionError::Sensor)?;
        Ok(Self {
            events,
            clock: match header.timer {
                TimerWidth::Bits16 => Clock::Bits16(Timebase16::new()),
                TimerWidth::Bits32 => Clock::Bits32(Timebase32::new()),
            },
            decoder,
        })
    }

    fn next_sample(&mut self) -> Result<Option<Sample>, ReadError<F>> {
        while let Some(event) = self.events.next_event()? {
            if let Some(sample) = self.clock.sample(event) {
                return Ok(Some(sample));
            }
        }
        Ok(None)
    }

    /// Corrects what is left of the stream into a corrected file, and says how many edges that were.
    fn correct<E: Entry>(
        &mut self,
        table: ErrorTable<'_, E>,
        mut sink: impl FnMut(&[u8]) -> Result<(), F>,
    ) -> Result<u32, SessionError<F>> {
        let header = self.events.header();
        let head = CorrectedHeader {
            lines: header.lines,
            clock_hz: header.clock_hz,
        };
        let mut sink = |bytes: &[u8]| sink(bytes).map_err(SessionError::Sink);
        sink(&head.emit())?;
        let mut corrector = Corrector::new(table, Anchor::Index);
        let mut corrected = 0_u32;
        while let Some(sample) = self.next_sample()? {
            if let Some(edge) = corrector.push(&self.decoder.push(sample)) {
                corrected = corrected.saturating_add(1);
                sink(&emit_edge(&edge))?;
            }
        }
        sink(&emit_faults(self.decoder.faults()))?;
        Ok(corrected)
    }
}

/// Learns the turns that the event file asks for, hands `sink` the table as a slot, corrects the rest of the stream and
/// hands on every corrected edge and, in the end, the faults of the whole stream.
///
/// `source` is as for [`EventReader::new`], `block` its memory; `buffers` must have four edges for every line.
///
/// # Errors
/// [`SessionError`]; what the sink was given until then is no whole file.
pub fn run<B, S, K, F>(
    source: S,
    block: &mut [u8],
    buffers: B,
    mut sink: K,
) -> Result<Report, SessionError<F>>
where
    B: EdgeBuffers,
    S: FnMut(&mut [u8]) -> Result<usize, F>,
    K: FnMut(Part, &[u8]) -> Result<(), F>,
{
    let mut front = Front::new(source, block, buffers.edges())?;
    let header = *front.events.header();
    let shape = EncoderShape::new(header.lines * CLASSES, CLASSES).map_err(SessionError::Shape)?;
    let turns = match header.turns {
        0 => TURNS_DEFAULT,
        turns => turns,
    };
    let (solution, learned, learned_until) = learn(&mut front, shape, buffers, turns)?;
    slot::write(
        &SlotHeader::of(&solution, learned_until, header.clock_hz.into()),
        solution.entries(),
        |bytes| sink(Part::Slot, bytes),
    )
    .map_err(SessionError::Sink)?;

    let table = ErrorTable::new(
        shape,
        *solution.class_offsets(),
        solution.entries(),
        solution.shift(),
    )
    .map_err(SessionError::Table)?
    .with_delays(Delays::found(solution.class_delays(), header.clock_hz.into()).of_class);
    let corrected = front.correct(table, |bytes| sink(Part::Corrected, bytes))?;
    Ok(Report {
        learned,
        corrected,
        faults: *front.decoder.faults(),
    })
}

/// Corrects a whole stream with a table that was learned before, hands `sink` every corrected edge and the faults, and says how many
/// edges were corrected. `source` and `block` are as for [`EventReader::new`].
///
/// # Errors
/// [`SessionError`]; what the sink was given until then is no whole file.
pub fn correct<S, K, F>(
    source: S,
    block: &mut [u8],
    slot: &Slot<'_>,
    sink: K,
) -> Result<u32, SessionError<F>>
where
    S: FnMut(&mut [u8]) -> Result<usize, F>,
    K: FnMut(&[u8]) -> Result<(), F>,
{
    let mut front = Front::new(source, block, slot.header.shape.edges() as usize)?;
    let clock_hz = front.events.header().clock_hz;
    let table = slot
        .table_at(clock_hz.into())
        .map_err(SessionError::Table)?;
    front.correct(table, sink)
}

/// What was learned: the table, the turns it rests on, and the tick at which the last of them was over.
type Learned<B> = (Solution<B>, Totals, Ticks);

/// Learns `turns` turns and solves. Not inlined, so that the stack it needs is free again for what comes after.
#[inline(never)]
fn learn<B, S, F>(
    front: &mut Front<'_, S>,
    shape: EncoderShape,
    buffers: B,
    turns: u32,
) -> Result<Learned<B>, SessionError<F>>
where
    B: EdgeBuffers,
    S: FnMut(&mut [u8]) -> Result<usize, F>,
{
    let mut estimator = match Estimator::new(shape, Anchor::Index, buffers) {
        Ok(estimator) => estimator,
        Err(error) => return Err(SessionError::Shape(error)),
    };
    while let Some(sample) = front.next_sample()? {
        let progress = estimator.push(&front.decoder.push(sample));
        if matches!(progress, Progress::TurnTaken(taken) if taken >= turns) {
            let learned = *estimator.totals();
            let mut solver = Solver::new();
            let findings = loop {
                match estimator.slice(&mut solver) {
                    Ok(Slice::More(_)) => {}
                    Ok(Slice::Solved(findings)) => break findings,
                    Err(error) => return Err(SessionError::Solve(error)),
                }
            };
            return Ok((estimator.finish(findings), learned, sample.ticks));
        }
    }
    Err(SessionError::TooFewTurns(*estimator.totals()))
}

#[cfg(test)]
mod tests;
