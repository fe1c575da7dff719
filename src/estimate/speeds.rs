//! The turns taken, by their speed: how often, how long, and how well neighbours agree. All moments that solving needs
//! come from here.

use super::locked::Locked;
use super::low::LOW_ORDERS;
use crate::log2::{LOG2_BITS, exp2, log2};
use crate::recip::Recip;

/// Speed bins, half an octave each.
pub(super) const BINS: usize = 27;

/// The bin of the first turn taken.
const FIRST: i32 = BINS as i32 / 2;

/// Turns of about one speed.
#[derive(Clone, Copy, Default)]
pub(super) struct Bin {
    /// Turns that count plus and minus in the contrast.
    pub turns: [u16; 2],
    /// Sum of (duration / first turn's)^2 over each of them, Q32.
    pub squares: [u64; 2],
    /// Sum of squared second differences of two turns' deviations over one turn, and how many turns.
    pub jitter: u64,
    pub jitter_turns: u16,
    /// Pairs of turns compared, and for each of the lowest orders the sum of the squared differences.
    pub pairs: u16,
    pub scatter: [u64; LOW_ORDERS],
}

impl Bin {
    pub(super) fn count(&self) -> u32 {
        u32::from(self.turns[0]) + u32::from(self.turns[1])
    }

    /// Rows of turns one right after the other.
    pub(super) fn runs(&self) -> u32 {
        self.count().saturating_sub(self.jitter_turns.into())
    }

    pub(super) fn square(&self) -> u64 {
        self.squares[0].saturating_add(self.squares[1])
    }
}

/// All turns taken, by speed.
pub(super) struct Speeds {
    pub bins: [Bin; BINS],
    /// Duration of the first turn taken, ticks; everything is relative to it.
    reference: u64,
    reference_log: i32,
    pub locked: Locked,
}

/// Where a turn's duration falls.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub bin: usize,
    /// duration / first turn's, Q32.
    pub ratio_q32: u64,
}

impl Speeds {
    pub(super) const NONE: Self = Self {
        bins: [Bin {
            turns: [0; 2],
            squares: [0; 2],
            jitter: 0,
            jitter_turns: 0,
            pairs: 0,
            scatter: [0; LOW_ORDERS],
        }; BINS],
        reference: 0,
        reference_log: 0,
        locked: Locked::NONE,
    };

    /// Duration that all others are relative to, ticks; zero before the first turn.
    pub(super) fn reference(&self) -> u64 {
        self.reference
    }

    /// Bin of a turn; the first one sets the reference. None where the speed is more than 90 times off it.
    pub(super) fn place(&mut self, duration: u64) -> Option<Place> {
        if self.reference == 0 {
            self.reference = duration;
            self.reference_log = log2(duration.into());
        }
        let octaves = log2(duration.into()) - self.reference_log;
        // To the nearest half octave.
        let bin = FIRST + ((octaves + (1 << (LOG2_BITS - 2))) >> (LOG2_BITS - 1));
        let bin = usize::try_from(bin).ok().filter(|&bin| bin < BINS)?;
        let recip = Recip::of_u64(self.reference);
        let product = u128::from(duration) * u128::from(recip.mantissa);
        let ratio_q32 = u64::try_from(product >> (recip.shift - 32)).ok()?;
        Some(Place { bin, ratio_q32 })
    }

    /// Bins that turns were taken in.
    pub(super) fn taken(&self) -> impl Iterator<Item = (usize, &Bin)> {
        let bins = self.bins.iter().enumerate();
        bins.filter(|(_, bin)| bin.count() > 0)
    }

    /// The bin of a place.
    pub(super) fn bin(&mut self, place: Place) -> Option<&mut Bin> {
        self.bins.get_mut(place.bin)
    }

    /// Counts a turn with its sign in the contrast.
    pub(super) fn count(&mut self, place: Place, plus: bool) {
        let Some(bin) = self.bins.get_mut(place.bin) else {
            return;
        };
        let side = usize::from(!plus);
        bin.turns[side] = bin.turns[side].saturating_add(1);
        let square = (u128::from(place.ratio_q32) * u128::from(place.ratio_q32)) >> 32;
        let square = u64::try_from(square).unwrap_or(u64::MAX);
        bin.squares[side] = bin.squares[side].saturating_add(square);
    }
}

/// Octaves by which the mean duration of a bin is above that of the first turn, Q16.
pub(super) fn octaves_q16(bin: usize) -> i32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
    let steps = bin as i32 - FIRST;
    steps << (LOG2_BITS - 1)
}

/// 2^(`log2_q16`), at least one.
pub(super) fn power_of_two(log2_q16: i32) -> u64 {
    exp2(log2_q16).max(1)
}

/// How turns of different speed are weighed in the sum: by the square of the speed, to the nearest power of two.
///
/// Torque noise makes angle errors whose power falls with the cube of the speed; the square is within 3 % of the best, and
/// makes the plain sum the second moment that geometry and locked torque are told apart with (see `separate`).
#[derive(Clone, Copy)]
pub(super) struct Weighing {
    /// A turn of bin b has the weight 2^(exponent - b).
    exponent: i32,
    /// Sum of the weights in the unit of now, Q16.
    total_q16: u64,
}

/// What the next turn does to the sum: all that is there is shifted down, the turn itself up, or down where turns as slow
/// count less than one.
#[derive(Clone, Copy, Default)]
pub(super) struct Shifts {
    pub sum_down: u32,
    pub turn_up: u32,
    pub turn_down: u32,
}

/// Log2 of a turn's weight at most, and weight of all together.
const TURN_BITS: i32 = 9;
const TOTAL_MAX_Q16: u64 = 1 << (15 + 16);

impl Weighing {
    pub(super) const NEW: Self = Self {
        exponent: FIRST + 8,
        total_q16: 0,
    };

    /// Weight of a bin's turns, Q16.
    pub(super) fn weight_q16(&self, bin: usize) -> u64 {
        let log2 = self.log2_weight(bin);
        if log2 < -16 {
            0
        } else {
            1 << (16 + log2.min(30))
        }
    }

    fn log2_weight(&self, bin: usize) -> i32 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        let bin = bin as i32;
        self.exponent - bin
    }

    /// Makes room for a turn of `bin`.
    pub(super) fn add(&mut self, bin: usize) -> Shifts {
        let mut sum_down = 0;
        while sum_down < 31
            && (self.log2_weight(bin) > TURN_BITS
                || self.total_q16 + self.weight_q16(bin) > TOTAL_MAX_Q16)
        {
            self.exponent -= 1;
            self.total_q16 >>= 1;
            sum_down += 1;
        }
        self.total_q16 += self.weight_q16(bin);
        let log2 = self.log2_weight(bin);
        Shifts {
            sum_down,
            turn_up: log2.max(0).unsigned_abs(),
            turn_down: log2.min(0).unsigned_abs().min(31),
        }
    }
}
