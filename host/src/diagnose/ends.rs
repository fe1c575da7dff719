//! Ends of a task's busy times: an edge that the task held up is stamped there, wherever the shaft was, and says nothing of it.

/// Ends of a task's busy times on a recording's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The task's rate, Hz.
    pub f_hz: f64,
    /// One of them, s.
    pub end_s: f64,
    /// How far a stamp that was held up may be from one, s.
    pub within_s: f64,
}

impl Ends {
    /// Whether a stamp may be that of an edge that was held up. A share of those that were not come there too and are left out with
    /// them: by their stamp alone, so that the others are as good as before.
    #[must_use]
    pub fn has(&self, time_s: f64) -> bool {
        let periods = (time_s - self.end_s) * self.f_hz;
        (periods - periods.round()).abs() < self.within_s * self.f_hz
    }

    /// Share of the time in which stamps are left out.
    #[must_use]
    pub fn share(&self) -> f64 {
        2.0 * self.within_s * self.f_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_near_any_end_are_there_and_others_are_not() {
        let ends = Ends {
            f_hz: 100.0,
            end_s: 0.503,
            within_s: 1e-5,
        };
        for period in [-50.0, 0.0, 7.0, 9000.0] {
            let end = 0.503 + 0.01 * period;
            assert!(ends.has(end) && ends.has(end - 9e-6) && ends.has(end + 9e-6));
            assert!(!ends.has(end - 1.1e-5) && !ends.has(end + 1.1e-5) && !ends.has(end + 5e-3));
        }
        assert!((ends.share() - 2e-3).abs() < 1e-12);
    }
}
