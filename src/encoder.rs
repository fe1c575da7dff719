//! The usual case in one type: captures of a quadrature encoder in, corrected angle and speed out.
//!
//! [`Encoder`] holds [time base](crate::timebase), [decoder](crate::decoder), [corrector](crate::corrector) and
//! [interval](crate::interval). Edges and speeds are theirs, bit for bit. One more step of settled motion it handles in one go: the next
//! edge's angle is looked up while there is time, and is the limit of what [`Encoder::now`] says meanwhile. Corrector and interval
//! are brought up to date when something else comes.
//!
//! # Interrupts
//! [`Encoder::edge`] and [`Encoder::overflow`] belong to the timer's interrupts, of one priority; captures are served before overflows,
//! as in [`Timebase::capture_first`]. Whoever reads from an interrupt that can preempt those masks them for the time of the read. The
//! type is `Send`, so that a critical section's mutex can share it.
//!
//! # Cost
//! The repository's `docs/cost.md` has the instructions. No method on the edge path divides, uses floating point, allocates or can
//! panic, nor do the reading ones.

mod config;
mod corrected;
mod drained;

use crate::corrector::{CorrectedEdge, Corrector};
use crate::decoder::QuadratureDecoder;
use crate::edge::{Direction, Sample};
use crate::estimate::Anchor;
use crate::interval::{Interval, IntervalConfig, Passed, Speed};
use crate::recip::Recip;
use crate::shape::{EncoderShape, Grid};
use crate::step::{Faults, Outcome, Step};
use crate::table::{Entry, ErrorTable};
use crate::timebase::Timebase;
use crate::units::{Ticks, Turn32, TurnDelta32};

pub use config::{Capture, EncoderConfig, EncoderError};
pub use corrected::Corrected;

/// The newest edge and the one ahead.
#[derive(Clone, Copy)]
struct Latest {
    ticks: Ticks,
    angle: Turn32,
    /// Angle of the next edge in this direction.
    ahead: Turn32,
    /// Way and time to here from the edge before, as captured.
    moved: TurnDelta32,
    interval: u32,
    number: u32,
    /// 1 forward, -1 in reverse.
    sign: i32,
    /// Whether there is an edge to go on from.
    known: bool,
    /// Whether it is known, and no delays are to be seen to.
    simple: bool,
}

/// A quadrature encoder: captures in, corrected angle and speed out. `E` is the kind of the table's entries, `BITS` the timer's width.
///
/// ```
/// use quadcal::edge::Levels;
/// use quadcal::encoder::{Capture, Encoder, EncoderConfig};
/// use quadcal::units::Turn32;
///
/// // 250 lines and no table yet; the timer has 16 bits and counts at 1 MHz.
/// let config = EncoderConfig::new(250, 100_000);
/// let mut encoder: Encoder = Encoder::new(config, None).unwrap();
/// // 60 r/min forward: 1000 edges a turn, so 1000 ticks an edge.
/// for k in 0..41_u32 {
///     let levels = Levels([1, 3, 2, 0][k as usize % 4]);
///     let corrected = encoder.edge(Capture { raw: 1000 * k, overflow_pending: false, levels });
///     // The first capture only says where counting begins.
///     assert_eq!(corrected.is_some(), k > 0);
///     if k > 1 {
///         assert!((corrected.unwrap().speed().rpm(1e6) - 60.0).abs() < 1e-6);
///     }
/// }
/// // Half an edge later.
/// let now = encoder.time(40_500, false);
/// let angle = encoder.now(now).unwrap();
/// assert!(angle.minus(Turn32((40.5 / 1000.0 * 2f64.powi(32)) as u32)).0.abs() < 10);
/// assert!((encoder.speed_at(now).rpm(1e6) - 60.0).abs() < 1e-6);
/// ```
pub struct Encoder<'a, E: Entry = [u8; 2], const BITS: u32 = 16> {
    latest: Latest,
    timebase: Timebase<BITS>,
    decoder: QuadratureDecoder,
    corrector: Corrector<'a, E>,
    interval: Interval,
    anchor: Anchor,
}

impl<'a, E: Entry, const BITS: u32> Encoder<'a, E, BITS> {
    /// An encoder that has seen nothing. Without a table angles are the grid's. Divides, so not for the edge path.
    ///
    /// # Errors
    /// [`EncoderError`] when a setting is out of range or the table is of another encoder.
    ///
    /// ```
    /// use quadcal::encoder::{Encoder, EncoderConfig, EncoderError};
    /// use quadcal::step::SensorError;
    ///
    /// let none = Encoder::<[u8; 2], 32>::new(EncoderConfig::new(0, 1000), None);
    /// assert_eq!(none.err(), Some(EncoderError::Sensor(SensorError::Slots)));
    /// ```
    pub fn new(
        config: EncoderConfig,
        table: Option<ErrorTable<'a, E>>,
    ) -> Result<Self, EncoderError> {
        let decoder = QuadratureDecoder::new(config.decoder).map_err(EncoderError::Sensor)?;
        let shape = EncoderShape::new(decoder.slots(), 4).map_err(EncoderError::Shape)?;
        let mut encoder = Self {
            latest: Latest {
                ticks: 0,
                angle: Turn32(0),
                ahead: Turn32(0),
                moved: TurnDelta32(0),
                interval: 0,
                number: 0,
                sign: 1,
                known: false,
                simple: false,
            },
            timebase: Timebase::new(),
            decoder,
            corrector: Corrector::uncorrected(Grid::new(shape)),
            interval: Interval::new(IntervalConfig::new(decoder.slots(), config.timeout)),
            anchor: config.anchor,
        };
        encoder.set_table(table)?;
        Ok(encoder)
    }

    /// Corrects with another table from the next edge on, or with none. Count, index and speed go on; [`Self::now`] knows
    /// nothing until that edge. Divides, so not for the edge path.
    ///
    /// # Errors
    /// [`EncoderError::Table`], with nothing done.
    ///
    /// ```
    /// use quadcal::encoder::{Encoder, EncoderConfig, EncoderError};
    /// use quadcal::shape::{CLASSES_MAX, EncoderShape};
    /// use quadcal::table::ErrorTable;
    /// use quadcal::units::TurnDelta32;
    ///
    /// let mut encoder: Encoder<'_, i16> = Encoder::new(EncoderConfig::new(4, 1000), None).unwrap();
    /// let shape = EncoderShape::new(12, 4).unwrap();
    /// let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &[0; 12], 0).unwrap();
    /// assert_eq!(encoder.set_table(Some(table)), Err(EncoderError::Table(shape)));
    /// ```
    pub fn set_table(&mut self, table: Option<ErrorTable<'a, E>>) -> Result<(), EncoderError> {
        let grid = self.corrector.table().grid();
        let table = table.unwrap_or(ErrorTable::of_grid(grid));
        if table.shape() != grid.shape() {
            return Err(EncoderError::Table(table.shape()));
        }
        self.catch_up();
        self.corrector = Corrector::new(table, self.anchor);
        self.look_ahead();
        Ok(())
    }

    /// Counts one wrap of the timer; from the overflow interrupt, together with clearing its flag.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// encoder.overflow();
    /// assert_eq!(encoder.time(5, false), 65_541);
    /// ```
    #[inline]
    pub const fn overflow(&mut self) {
        self.timebase.overflow();
    }

    /// Time of the counter value `counter`, read just before the overflow flag: what [`Self::now`] and [`Self::speed_at`] take.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// assert_eq!((encoder.time(5, false), encoder.time(5, true)), (5, 65_541));
    /// ```
    #[inline]
    #[must_use]
    pub const fn time(&self, counter: u32, overflow_pending: bool) -> Ticks {
        self.timebase.now(counter, overflow_pending)
    }

    /// The time base, for drives that can't serve captures first: see [`Timebase::capture`] and [`Self::edge_at`].
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// assert_eq!(encoder.timebase().capture(0xFFFF, 3, true), 0xFFFF);
    /// ```
    #[must_use]
    pub const fn timebase(&self) -> &Timebase<BITS> {
        &self.timebase
    }

    /// Takes a capture, from the capture interrupt, before a wrap of the timer that is pending is served. None where it is no edge:
    /// the first sample, a change of Z alone, a glitch, which takes the edge before back, or levels as before.
    /// See [`Encoder`] for an example.
    #[inline(always)]
    pub fn edge(&mut self, capture: Capture) -> Option<Corrected> {
        self.edge_at(Sample {
            ticks: self
                .timebase
                .capture_first(capture.raw, capture.overflow_pending),
            levels: capture.levels,
        })
    }

    /// As [`Self::edge`], for a time that is already extended to 64 bits.
    ///
    /// ```
    /// use quadcal::edge::{Levels, Sample};
    /// use quadcal::encoder::{Encoder, EncoderConfig};
    ///
    /// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// assert!(encoder.edge_at(Sample { ticks: 1 << 40, levels: Levels(1) }).is_none());
    /// let corrected = encoder.edge_at(Sample { ticks: (1 << 40) + 500, levels: Levels(3) });
    /// assert_eq!(corrected.unwrap().edge.ticks, (1 << 40) + 500);
    /// ```
    #[inline(always)]
    pub fn edge_at(&mut self, sample: Sample) -> Option<Corrected> {
        match self.decoder.push_plain(sample) {
            Some(step) => Some(self.follow(&step)),
            None => self.push_watchful(sample),
        }
    }

    /// A plain step that follows the one before plainly.
    #[inline(always)]
    fn follow(&mut self, step: &Step) -> Corrected {
        let Latest {
            angle: before,
            ahead: angle,
            number,
            sign,
            ..
        } = self.latest;
        let moved = angle.minus(before);
        let ahead = self.corrector.angle_beyond(step.edge, sign);
        self.latest = Latest {
            ticks: step.ticks,
            angle,
            ahead,
            moved,
            interval: step.interval,
            number: step.edge,
            ..self.latest
        };
        let delay = self.corrector.plain_delay(step.edge);
        let change = self.corrector.change(number, step.edge, moved);
        Corrected {
            edge: CorrectedEdge {
                ticks: step.ticks,
                angle,
                moved,
                interval: step.interval,
                late: delay.late,
                stretch: delay.stretch,
                flags: step.flags,
            },
            passed: self
                .interval
                .plainly(step.direction, step.interval, change, delay.stretch),
        }
    }

    /// Whatever is not a plain step.
    #[cold]
    #[inline(never)]
    fn push_watchful(&mut self, sample: Sample) -> Option<Corrected> {
        self.catch_up();
        let outcome = self.decoder.push_watchful(sample);
        let corrected = self.pass_on(&outcome);
        self.look_ahead();
        corrected
    }

    /// Corrector and interval take the last plain steps. Three: they remember two, and of the first of these the way from the one before.
    fn catch_up(&mut self) {
        let (number, direction) = self.corrector.place();
        let steps = match direction {
            Direction::Forward => self.latest.number.wrapping_sub(number),
            Direction::Reverse => number.wrapping_sub(self.latest.number),
        };
        // In reverse they may come from edge 0 to the last one, which wraps to a large number: at least one, and fewer than a turn.
        let steps = steps.min(steps.wrapping_add(self.decoder.slots())).min(3);
        for back in (0..steps).rev() {
            let step = self.decoder.past_plain(back);
            self.pass_on(&Outcome::Step(step));
        }
    }

    fn pass_on(&mut self, outcome: &Outcome) -> Option<Corrected> {
        let corrected = self.corrector.push_for_speed(outcome);
        match outcome {
            Outcome::Step(step) => {
                let (edge, change) = corrected?;
                self.interval.push_delayed(step, change, edge.stretch);
                let (passed, _) = self.interval.newest();
                return Some(Corrected { edge, passed });
            }
            Outcome::Glitch(_) => self.interval.withdraw(),
            Outcome::Idle | Outcome::Index(_) => {}
        }
        None
    }

    /// Gets ready for a plain step, and for readers.
    fn look_ahead(&mut self) {
        let (number, direction) = self.corrector.place();
        self.latest.number = number;
        let last = self.corrector.last();
        self.latest.known = last.is_some();
        self.latest.simple = last.is_some() && !self.corrector.table().has_delays();
        if let Some(last) = last {
            self.latest = Latest {
                ticks: last.ticks,
                angle: last.angle,
                ahead: self.corrector.angle_ahead(),
                moved: last.moved,
                interval: last.interval,
                sign: direction.sign(),
                ..self.latest
            };
        }
        if !self.corrector.follows(self.decoder.plain_flags()) {
            self.decoder.watch();
        }
        self.decoder.watch_last_edge();
    }

    /// Shaft angle at the time `ticks`, from any interrupt: from the newest edge on at the speed of the last interval, but never past the
    /// next edge, which would have been seen. 2^-32 turn; before the index its origin is where counting began. None before the
    /// first edge. Between two edges it only goes on. At most 2 e / t + 2 of 2^-32 turn off [`Corrector::angle_at`], where e is the time
    /// since the edge and t the last interval. No division; with a table that has delays, and after 2^24 ticks, it takes longer.
    /// See [`Encoder`] for an example.
    #[inline]
    #[must_use]
    pub fn now(&self, ticks: Ticks) -> Option<Turn32> {
        let latest = &self.latest;
        let elapsed = ticks.wrapping_sub(latest.ticks);
        // Times before the edge are long as well; an interval of 0 ticks is none.
        if !latest.simple || latest.interval.wrapping_sub(1) >> 24 != 0 || elapsed >> 24 != 0 {
            return self.now_watchful(ticks);
        }
        let Recip { mantissa, shift } = Recip::of_u32(latest.interval);
        // Way in 2^digits ticks, which is at most the interval and more than half of it.
        let digits = shift.wrapping_sub(32) & 31;
        let rate = (u64::from(latest.moved.0.unsigned_abs()) * u64::from(mantissa)) >> 32;
        let way = rate * Ticks::from(elapsed as u32);
        let most = latest.ahead.minus(latest.angle).0.unsigned_abs();
        // Shifted in words: a shift of 64 bits takes twice as long.
        let (high, low) = ((way >> 32) as u32, way as u32);
        let way = if high >> digits != 0 {
            most
        } else {
            ((high << 1) << (31 - digits) | low >> digits).min(most)
        };
        let way = TurnDelta32((way as i32).wrapping_mul(latest.sign));
        Some(latest.angle.plus(way))
    }

    #[cold]
    #[inline(never)]
    fn now_watchful(&self, ticks: Ticks) -> Option<Turn32> {
        let last = self.last()?.edge;
        Some(self.corrector.go_on(&last, self.latest.number, ticks))
    }

    /// The newest edge; none before the first.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// assert!(encoder.last().is_none());
    /// ```
    #[must_use]
    pub fn last(&self) -> Option<Corrected> {
        if !self.latest.known {
            return None;
        }
        let (passed, _) = self.passed();
        let edge = match self.last_plain() {
            None => self.corrector.last()?,
            Some(step) => {
                let delay = self.corrector.plain_delay(step.edge);
                CorrectedEdge {
                    ticks: step.ticks,
                    angle: self.latest.angle,
                    moved: self.latest.moved,
                    interval: step.interval,
                    late: delay.late,
                    stretch: delay.stretch,
                    flags: step.flags,
                }
            }
        };
        Some(Corrected { edge, passed })
    }

    /// The newest step, if it was plain and interval and corrector do not know of it yet.
    fn last_plain(&self) -> Option<Step> {
        let (number, _) = self.corrector.place();
        (number != self.latest.number).then(|| self.decoder.past_plain(0))
    }

    /// The newest interval and when it ended.
    fn passed(&self) -> (Passed, Ticks) {
        let latest = &self.latest;
        let (number, direction) = self.corrector.place();
        if number == latest.number {
            return self.interval.newest();
        }
        let stretch = self.corrector.plain_delay(latest.number).stretch;
        let back = direction.opposite();
        let before = self.corrector.next_edge(latest.number, back);
        let change = self.corrector.change(before, latest.number, latest.moved);
        let passed = self
            .interval
            .plainly(direction, latest.interval, change, stretch);
        (passed, latest.ticks)
    }

    /// Speed at the time `now`, equations (2) and (3), 2^-60 turn a tick, forward positive: the mean over the last interval, but no more
    /// than one step since the newest edge allows, and 0 after the timeout. The same as [`Interval::speed_at`]. No division.
    /// See [`Encoder`] for an example.
    #[must_use]
    pub fn speed_at(&self, now: Ticks) -> Speed {
        let (passed, end) = self.passed();
        self.interval.speed_after(&passed, end, now)
    }

    /// Position, direction, index and faults as the decoder has them.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// assert!(!encoder.decoder().is_referenced());
    /// assert_eq!(encoder.faults().total(), 0);
    /// ```
    #[must_use]
    pub const fn decoder(&self) -> &QuadratureDecoder {
        &self.decoder
    }

    /// Faults so far, a saturating count of each kind.
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        self.decoder.faults()
    }

    /// Moves the count to where the fingerprint found the shaft, as [`QuadratureDecoder::locate`] does. Divides, so not for the edge path.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// // Nothing has moved yet.
    /// assert!(!encoder.locate(4));
    /// ```
    pub fn locate(&mut self, offset: u32) -> bool {
        self.catch_up();
        self.decoder.locate(offset)
    }

    /// Stops correcting for good, as [`Corrector::release`] does.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// encoder.release();
    /// assert!(encoder.is_released());
    /// ```
    pub fn release(&mut self) {
        self.catch_up();
        self.corrector.release();
        self.look_ahead();
    }

    /// Whether the table was given up; see [`Corrector::is_released`].
    #[must_use]
    pub const fn is_released(&self) -> bool {
        self.corrector.is_released()
    }
}

#[cfg(test)]
mod tests;
