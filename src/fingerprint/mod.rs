//! Finds where in the error table the shaft is, from a fraction of a turn and without the index, and notices when the table is
//! of another disc. eps is a fingerprint: no two places of a disc are alike.
//!
//! On the edge path a [`Trail`] keeps the last intervals. In the background [`Fingerprint::search`] works in slices:
//!
//! ```text
//! weigh the table -> gather a window -> quick search -> found -> watch: fits, or
//!   (once)              ^                  | unclear               | misfit
//!                       |                  v                       |
//!                       +-- undecided - full search -> other disc  |
//!                       +------------------------------------------+
//! ```
//!
//! # What is compared
//! A window is a row of blocks of 16 edges. Each gives nine contrasts of its edges' errors that smooth motion and class
//! offsets do not touch (see `block.rs`), so neither wander, cogging or a ramp nor drifting widths and delays matter; nothing needs to be
//! known of speed or noise. For a line k of the table, |y - x(k)|^2 over all contrasts is the residual R(k); R(none) = |y|^2 is
//! what no table leaves. Both get the noise that is there for certain added: of the timer's tick and of the table.
//!
//! # How sure it is
//! With nu contrasts and white normal noise of unknown size (its logarithm evenly distributed), the likelihood of a place is
//! proportional to R(k)^(-nu/2), and R(none)^(-nu/2) is that of a disc with a pattern of its own, of any size.
//!
//! *A wrong place.* Whatever the pattern and the noise, a given wrong place outweighs the true one by 2^b with a
//! probability of at most 2^-b / sqrt(pi nu): the noise must fall into a ball of relative radius 2^(-b/nu) about the wrong
//! pattern, and the density there, times the ball's volume, is greatest where the noise is as large as the pattern. So if the best
//! line stands `b` bits over every other one and over *none*, the union bound over M lines, and as many chances for
//! another disc, leaves 2^(log2 M + 1 - b).
//!
//! *Another disc.* The mean over all lines of (R(k) / R(none))^(-nu/2) is the odds of *this disc, anywhere* against
//! *another disc*; odds of windows multiply. By Ville's inequality this disc's own table is refused with a probability
//! of at most the odds reached, times the windows that the count may have begun at.
//!
//! *The watch* adds up, a block at a time, nu / 2 log2 (R(k) / R(none)) at the one place k, never below zero. Between two false alarms
//! at b bits lie 2^b blocks or more on average.
//!
//! Where the pattern is too weak to reach the bits asked for in one window, the answer is [`Verdict::Undecidable`], not a guess.
//! Noise that is not white (a rounding that repeats, a torque that swings within 16 edges) is not in the model; the tests measure
//! what it does.

mod block;
mod hunt;
mod odds;
mod stage;
mod trail;
mod verdict;
mod watch;

#[cfg(test)]
mod tests;

pub use odds::Doubt;
pub use trail::Trail;
pub use verdict::{FingerprintConfig, FingerprintError, Place, Verdict};

use block::{Block, CONTRASTS};
use hunt::{Hunt, NoWindow, Scale, Window};
use odds::{BIT, Bits, count_bits, likelier};
use stage::Stage;
use trail::wrap;
use watch::Watch;

use crate::table::{Entry, ErrorTable};

/// Windows that may end undecided before the verdict is [`Verdict::Undecidable`]; the search goes on.
const PATIENCE: u32 = 16;

/// The background part; a window is `BLOCKS` x 16 edges. For quadrature encoders. See the module's head.
pub struct Fingerprint<'a, const BLOCKS: usize, E: Entry = i16> {
    table: ErrorTable<'a, E>,
    bits: Bits,
    scale: Scale,
    stage: Stage,
    window: Window<BLOCKS>,
    epoch: u32,
    /// Intervals of the trail when a window was last taken.
    seen: u32,
    /// Evidence for another disc.
    against: Bits,
    /// Windows that decided nothing.
    undecided: u32,
    coarse: bool,
    misfit: Option<Doubt>,
}

impl<'a, const BLOCKS: usize, E: Entry> Fingerprint<'a, BLOCKS, E> {
    /// A search in `table`.
    ///
    /// # Errors
    /// [`FingerprintError`] when the table or the bits can't be used.
    pub fn new(
        table: ErrorTable<'a, E>,
        config: FingerprintConfig,
    ) -> Result<Self, FingerprintError> {
        const { assert!(BLOCKS >= 1 && BLOCKS <= 64) };
        let shape = table.shape();
        if shape.classes() != 4 {
            return Err(FingerprintError::Classes(shape.classes()));
        }
        if shape.edges() < Window::<BLOCKS>::EDGES {
            return Err(FingerprintError::Edges(shape.edges()));
        }
        if config.bits < 1 || config.bits > 60 {
            return Err(FingerprintError::Bits(config.bits));
        }
        let slots = shape.edges();
        let error = u64::from(config.standard_error >> table.shift()).min(1 << 24);
        Ok(Self {
            table,
            bits: Bits::from(config.bits) * BIT,
            scale: Scale {
                slots,
                span: ((15 << 32) / u64::from(slots.max(1))) >> table.shift(),
                table_noise: CONTRASTS as u64 * error * error + 1,
                power: 0,
            },
            stage: Stage::Weigh { line: 0, sum: 0 },
            window: Window::EMPTY,
            epoch: 0,
            seen: 0,
            against: 0,
            undecided: 0,
            coarse: false,
            misfit: None,
        })
    }

    /// Starts over, as after another table was refused and the encoder exchanged again.
    pub fn restart(&mut self) {
        if !matches!(self.stage, Stage::Weigh { .. } | Stage::Weak) {
            self.stage = Stage::Gather;
        }
        (self.seen, self.against, self.undecided) = (0, 0, 0);
        self.misfit = None;
    }

    /// One slice of work: about `budget` times eight edges of the table are looked at (the last place begun is finished). `trail` is
    /// a copy that stands still. Not for the edge path.
    pub fn search<const W: usize>(&mut self, trail: &Trail<W>, budget: u32) -> Verdict {
        const { assert!(W >= 16 * BLOCKS + 2) };
        let mut budget = budget.max(1);
        while budget > 0 {
            self.follow(trail);
            match &mut self.stage {
                Stage::Weigh { line, sum } => {
                    let entries = self.table.entries();
                    *sum += Block::EMPTY
                        .residual(entries, 4 * *line as usize, u64::MAX)
                        .0;
                    *line += 1;
                    budget = budget.saturating_sub(2);
                    if *line == self.scale.lines() {
                        let power = sum.checked_div(u64::from(*line)).unwrap_or(0);
                        self.weighed(power);
                    }
                }
                Stage::Gather => {
                    self.gather(trail);
                    break;
                }
                Stage::Hunt(hunt) => {
                    let entries = self.table.entries();
                    let found = hunt.advance(&self.window, entries, &self.scale, &mut budget);
                    if let Some(found) = found {
                        self.decide(found, trail);
                        break;
                    }
                }
                Stage::Watch(watch, _) => {
                    watch.look(trail, self.table.entries(), &self.scale);
                    let misfits = watch.misfits;
                    if misfits >= self.bits {
                        self.misfit = Some(Doubt::of(misfits));
                        self.regather();
                    }
                    break;
                }
                Stage::Weak | Stage::Refused(_) => break,
            }
        }
        self.verdict()
    }

    /// Begins a new stage where edges got other numbers.
    fn follow<const W: usize>(&mut self, trail: &Trail<W>) {
        let settled = matches!(
            self.stage,
            Stage::Weigh { .. } | Stage::Weak | Stage::Refused(_)
        );
        if settled || trail.epoch() == self.epoch {
            return;
        }
        self.epoch = trail.epoch();
        self.seen = 0;
        self.stage = if trail.is_referenced() && self.misfit.is_none() {
            Stage::Watch(Watch::new(0, 0), None)
        } else {
            Stage::Gather
        };
    }

    /// Judges the table itself.
    fn weighed(&mut self, power: u64) {
        self.scale.power = power;
        // The most that a window could ever tell.
        let noise = self.scale.table_noise;
        let most = likelier(noise, noise + power, Window::<BLOCKS>::FREEDOM);
        let needed = self.bits + count_bits(self.scale.lines()) + BIT;
        self.stage = if most < needed {
            Stage::Weak
        } else {
            Stage::Gather
        };
    }

    fn regather(&mut self) {
        self.stage = Stage::Gather;
        (self.against, self.undecided) = (0, 0);
    }

    /// Takes a window of edges that no window had before.
    fn gather<const W: usize>(&mut self, trail: &Trail<W>) {
        let count = trail.count();
        if count.saturating_add(3) < self.seen {
            self.seen = 0;
        }
        if count.saturating_sub(self.seen) < Window::<BLOCKS>::EDGES - 1 {
            return;
        }
        match Window::load(trail, &self.scale) {
            Ok(window) => {
                // A window may leave out the three newest edges; the next one must not reach back to them.
                self.seen = count.saturating_add(3);
                self.coarse = false;
                self.stage = Stage::Hunt(Hunt::quick(&window, &self.scale));
                self.window = window;
            }
            Err(reason) => self.coarse |= reason == NoWindow::Clock,
        }
    }

    /// Draws the conclusion of a whole search.
    fn decide<const W: usize>(&mut self, found: hunt::Found, trail: &Trail<W>) {
        // Each window is another chance to be wrong.
        let chances = count_bits(self.undecided + 1);
        let sure = found.bits - chances;
        if sure >= self.bits {
            let slots = self.scale.slots;
            let offset = wrap(4 * found.line + slots - self.window.first, slots);
            let place = Place {
                offset,
                doubt: Doubt::of(sure),
            };
            self.misfit = None;
            (self.against, self.undecided) = (0, 0);
            let told = trail.is_referenced() && offset == 0;
            let watch = Watch::new(offset, self.seen);
            self.stage = Stage::Watch(watch, (!told).then_some(place));
            return;
        }
        let Some(against) = found.against else {
            self.stage = Stage::Hunt(Hunt::full(&self.window));
            return;
        };
        self.against = (self.against + against).clamp(0, 1000 * BIT);
        self.undecided = self.undecided.saturating_add(1);
        let sure = self.against - chances;
        self.stage = if sure >= self.bits {
            Stage::Refused(Doubt::of(sure))
        } else {
            Stage::Gather
        };
    }

    fn verdict(&self) -> Verdict {
        let unsettled = |verdict| match self.misfit {
            Some(doubt) => Verdict::Misfit(doubt),
            None if self.coarse || self.undecided >= PATIENCE => Verdict::Undecidable,
            None => verdict,
        };
        match self.stage {
            Stage::Weigh { .. } | Stage::Hunt(_) => unsettled(Verdict::Searching),
            Stage::Gather => unsettled(Verdict::Gathering),
            Stage::Weak => Verdict::Undecidable,
            Stage::Watch(_, Some(place)) => Verdict::Found(place),
            Stage::Watch(watch, None) if watch.fits >= self.bits => Verdict::Fits,
            Stage::Watch(_, None) => Verdict::Gathering,
            Stage::Refused(doubt) => Verdict::OtherDisc(doubt),
        }
    }
}
