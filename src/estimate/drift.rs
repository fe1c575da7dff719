//! Whether the mean of many turns gets better as their number says: means of 1, 2, 4, ... turns against those just after.
//!
//! Torque that forgets from turn to turn leaves half the power in a mean of twice as many turns. A load that swings over many
//! turns, or a mounting that warms up, does not, and then more turns do not help.

use super::low::{LOW_ORDERS, LowOrder};

/// Means of up to 2^(LEVELS - 1) turns are compared.
const LEVELS: usize = 6;

/// Orders looked at, the lowest: they hold nearly all of the noise.
const ORDERS: usize = 2;

/// Pairs of means that say something.
const PAIRS_MIN: u16 = 3;

/// Times the power to expect of white noise that is no accident with so few pairs of two orders each.
const EXCESS: u64 = 4;

/// Pairs of means of so many turns.
#[derive(Clone, Copy)]
struct Level {
    waiting: Option<[LowOrder; ORDERS]>,
    pairs: u16,
    /// Sum of squared distances over pairs and orders.
    scatter: u64,
}

/// The turns of one speed, as they come.
pub(super) struct Drift {
    bin: usize,
    levels: [Level; LEVELS],
}

impl Drift {
    pub(super) const NONE: Self = Self {
        bin: 0,
        levels: [Level {
            waiting: None,
            pairs: 0,
            scatter: 0,
        }; LEVELS],
    };

    /// Takes the lowest orders of a turn of a speed bin; another bin starts anew.
    pub(super) fn take(&mut self, bin: usize, low: &[LowOrder; LOW_ORDERS]) {
        if bin != self.bin {
            *self = Self { bin, ..Self::NONE };
        }
        let mut mean = [low[0], low[1]];
        for level in &mut self.levels {
            let Some(before) = level.waiting.take() else {
                level.waiting = Some(mean);
                break;
            };
            for (one, other) in mean.iter_mut().zip(before) {
                level.scatter = level.scatter.saturating_add(one.distance(other));
                *one = one.between(other);
            }
            level.pairs = level.pairs.saturating_add(1);
        }
    }

    /// The next turn does not follow the last one.
    pub(super) fn interrupt(&mut self) {
        for level in &mut self.levels {
            level.waiting = None;
        }
    }

    /// Bin of the turns and the power in the mean of them all that more turns won't take away, orders 1 and 2 together,
    /// squared units of [`LowOrder`].
    pub(super) fn standing(&self) -> (usize, u64) {
        let power = |level: &Level| level.scatter / (2 * u64::from(level.pairs.max(1)));
        let white = power(&self.levels[0]);
        let standing = (0..LEVELS)
            .rev()
            .find(|&level| self.levels[level].pairs >= PAIRS_MIN)
            .map_or(0, |level| {
                let (seen, white) = (power(&self.levels[level]), white >> level);
                if seen / EXCESS > white {
                    seen - white
                } else {
                    0
                }
            });
        (self.bin, standing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u32) -> i32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 16).cast_signed() - (1 << 15)
    }

    fn turn(re: i32, im: i32) -> [LowOrder; LOW_ORDERS] {
        [LowOrder { re, im }; LOW_ORDERS]
    }

    #[test]
    fn turns_that_forget_leave_nothing_standing() {
        let mut found = 0;
        for seed in 0..200 {
            let (mut drift, mut state) = (Drift::NONE, seed * 7919);
            for _ in 0..48 {
                drift.take(3, &turn(random(&mut state), random(&mut state)));
            }
            found += u32::from(drift.standing().1 > 0);
        }
        assert!(found <= 6, "{found}");
    }

    #[test]
    fn a_swing_over_many_turns_stands() {
        for seed in 0..50 {
            let (mut drift, mut state) = (Drift::NONE, seed * 7919);
            for i in 0..48 {
                let swing =
                    (80_000.0 * (core::f64::consts::TAU * f64::from(i) / 40.0).sin()) as i32;
                let noise = [random(&mut state), random(&mut state)];
                drift.take(3, &turn(noise[0] + swing, noise[1]));
            }
            assert!(drift.standing().1 > 1 << 28, "{:?}", drift.standing());
        }
    }
}
