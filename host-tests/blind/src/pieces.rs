//! A speed in straight pieces: ramps, holds, dwells and reversals as a real drive makes them.

/// Knots of a course.
pub const KNOTS: usize = 12;

/// Speed that goes straight from one knot to the next and stays after the last; knots are (s, rad/s), the first at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pieces([(f64, f64); KNOTS]);

impl Pieces {
    /// Of knots in order of time.
    #[must_use]
    pub const fn new(knots: [(f64, f64); KNOTS]) -> Self {
        Self(knots)
    }

    /// Speed and its rate at a time, rad/s and rad/s^2. `inside_s` lies on the same side of every knot as the time.
    #[must_use]
    pub fn at(&self, time_s: f64, inside_s: f64) -> (f64, f64) {
        let after = self.0.partition_point(|&(t, _)| t <= inside_s);
        let Some((&(t0, v0), &(t1, v1))) =
            self.0.get(after.saturating_sub(1)).zip(self.0.get(after))
        else {
            return (self.0[KNOTS - 1].1, 0.0);
        };
        let rate = (v1 - v0) / (t1 - t0);
        (v0 + rate * (time_s - t0), rate)
    }

    /// Times of the knots, and of passing through standstill between them, s.
    #[must_use]
    pub fn sudden(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.0.iter().map(|knot| knot.0).collect();
        for pair in self.0.windows(2) {
            let [(t0, v0), (t1, v1)] = [pair[0], pair[1]];
            if v0 * v1 < 0.0 {
                times.push(t0 + (t1 - t0) * v0 / (v0 - v1));
            }
        }
        times
    }

    /// Speed at time 0, rad/s.
    #[must_use]
    pub const fn start(&self) -> f64 {
        self.0[0].1
    }

    /// The largest speed either way, rad/s.
    #[must_use]
    pub fn top(&self) -> f64 {
        self.0
            .iter()
            .fold(0.0, |most: f64, knot| most.max(knot.1.abs()))
    }

    /// Whether it goes both ways.
    #[must_use]
    pub fn reverses(&self) -> bool {
        self.0.iter().any(|knot| knot.1 * self.start() < 0.0)
    }

    /// Time of the last knot, s.
    #[must_use]
    pub const fn end_s(&self) -> f64 {
        self.0[KNOTS - 1].0
    }

    /// Way travelled up to the last knot, either way, rad.
    #[must_use]
    pub fn way_rad(&self) -> f64 {
        let each = self.0.windows(2).map(|pair| {
            let ((t0, v0), (t1, v1)) = (pair[0], pair[1]);
            let (from, to) = (v0.abs(), v1.abs());
            let share = if v0 * v1 < 0.0 {
                (from * from + to * to) / (2.0 * (from + to))
            } else {
                0.5 * (from + to)
            };
            share * (t1 - t0)
        });
        each.sum()
    }

    /// The same course in another time, so many times as long.
    #[must_use]
    pub fn stretched(&self, factor: f64) -> Self {
        Self(self.0.map(|(time, speed)| (factor * time, speed)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holds 2 rad/s for 1 s, reverses over 2 s, and stays.
    fn reversal() -> Pieces {
        let mut knots = [(3.0, -2.0); KNOTS];
        knots[0] = (0.0, 2.0);
        knots[1] = (1.0, 2.0);
        for (at, knot) in knots.iter_mut().enumerate().skip(3) {
            knot.0 += at as f64 - 2.0;
        }
        Pieces::new(knots)
    }

    #[test]
    fn speed_goes_straight_between_knots_and_stays_after_the_last() {
        let course = reversal();
        assert_eq!(course.at(0.5, 0.5), (2.0, 0.0));
        assert_eq!(course.at(1.5, 1.5), (1.0, -2.0));
        assert_eq!(course.at(99.0, 99.0), (-2.0, 0.0));
        assert!(course.reverses() && course.top() == 2.0);
    }

    #[test]
    fn standstill_is_a_sudden_change_and_the_way_counts_both_ways() {
        let course = reversal();
        assert!(course.sudden().contains(&2.0));
        // 2 rad held, 1 rad each side of the standstill, 9 s at -2 rad/s.
        assert!((course.way_rad() - 22.0).abs() < 1e-12);
        assert!((course.stretched(3.0).way_rad() - 66.0).abs() < 1e-12);
    }
}
