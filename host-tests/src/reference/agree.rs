//! Whether a turn agrees with those before it, by its lowest orders.

use realfft::num_complex::Complex64;

/// Lowest orders, compared from turn to turn.
pub(super) const LOW_ORDERS: usize = 6;

/// Squared differences of the lowest orders of two turns, turns squared.
pub(super) type Squares = [f64; LOW_ORDERS];

/// What is compared of a turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Its duration.
    pub duration: f64,
    /// The same over that of the first turn, in half octaves, rounded.
    pub bin: i32,
    /// Its lowest orders, turns.
    pub low: [Complex64; LOW_ORDERS],
}

/// How turns have agreed so far.
#[derive(Default)]
pub(super) struct Agreement {
    taken: Option<Seen>,
    rejected: Option<Seen>,
    in_a_row: u32,
}

impl Agreement {
    /// What comes next does not follow on what came before.
    pub(super) fn interrupt(&mut self) {
        (self.rejected, self.in_a_row) = (None, 0);
    }

    /// How far a turn is off the turn taken last, and whether that is too far; `usual` gives how much each pair of turns of a bin
    /// differed.
    pub(super) fn off(&self, turn: &Seen, usual: &impl Fn(i32) -> Vec<Squares>) -> (f64, bool) {
        // What disturbed one turn may be in the next.
        let wary = if self.in_a_row > 0 { 3.0 } else { 1.0 };
        self.taken
            .map_or((0.0, false), |taken| turn.off(&taken, usual, wary))
    }

    /// Leaves out a turn that does not agree, but not without end: not the fourth in a row that is like the third, nor the ninth.
    pub(super) fn reject(&mut self, turn: Seen, usual: &impl Fn(i32) -> Vec<Squares>) -> bool {
        let before = self.rejected;
        let like_before = before.is_some_and(|before| !turn.off(&before, usual, 1.0).1);
        let rejected = self.in_a_row < if like_before { 3 } else { 8 };
        if rejected {
            self.in_a_row += 1;
            self.rejected = Some(turn);
        }
        rejected
    }

    /// Takes a turn; the squared differences to the one taken before, of like speed, or to the one rejected before where it does not
    /// agree.
    pub(super) fn take(&mut self, turn: Seen, agrees: bool) -> Option<Squares> {
        let like = |taken: &Seen| (turn.duration - taken.duration).abs() <= turn.duration / 16.0;
        let pair = if agrees {
            self.taken.filter(like)
        } else {
            self.rejected
        };
        self.taken = Some(turn);
        self.interrupt();
        pair.map(|other| turn.squares(&other))
    }
}

impl Seen {
    fn squares(&self, other: &Self) -> Squares {
        std::array::from_fn(|index| (self.low[index] - other.low[index]).norm_sqr())
    }

    fn off(&self, other: &Self, usual: &impl Fn(i32) -> Vec<Squares>, wary: f64) -> (f64, bool) {
        let change = (self.duration - other.duration).abs();
        if change > self.duration / 3.0 {
            return (0.0, false);
        }
        let mut squares = self.squares(other);
        if change > self.duration / 16.0 {
            // Locked torque goes with the square of the duration.
            let ratio = 1.0 + change / self.duration.min(other.duration);
            let locked = (2.0 * (ratio * ratio - 1.0)).powi(2);
            for ((square, one), other) in squares.iter_mut().zip(self.low).zip(other.low) {
                *square = (*square - locked * one.norm_sqr().min(other.norm_sqr())).max(0.0);
            }
        }
        let level_of = level(&squares);
        let mut slower = 1.0;
        let mut pairs = usual(self.bin);
        if pairs.len() < 3 {
            pairs = usual(other.bin);
            // Noise of slower turns is greater.
            slower = 4.0_f64.powi((self.bin - other.bin).max(0));
        }
        if pairs.len() < 3 {
            return (level_of, false);
        }
        let count = pairs.len() as f64;
        let passed = |level: fn(&Squares) -> f64, limit: f64| {
            let mean = pairs.iter().map(level).sum::<f64>() / count;
            wary * level(&squares) > limit * slower * mean
        };
        let far = passed(level, 6.0 + 24.0 / count)
            || passed(|squares| squares.iter().sum(), 10.0 + 60.0 / count);
        (level_of, far)
    }
}

/// Torque noise falls with the fourth power of the order.
fn level(squares: &Squares) -> f64 {
    let by_order = squares.iter().zip(1..);
    by_order.map(|(x, n)| x * f64::from(n).powi(4)).sum()
}
