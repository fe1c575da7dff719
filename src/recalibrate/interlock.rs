//! What the firmware allows, and how often flash is written.

use super::Obstacle;

/// Whether the firmware allows it now. Asked from the main loop, often; answers at once.
pub trait Interlock {
    /// Whether a calibration may start or go on. The drive may have to turn the shaft for it.
    ///
    /// # Errors
    /// What is in the way.
    fn may_calibrate(&self) -> Result<(), Obstacle>;

    /// Whether the table in use may be exchanged and flash written, which on many chips halts the processor: as a rule with the shaft
    /// at rest and the supply sure to stay. Asked when the command comes, and again right before flash is erased or written: a table is
    /// written at the next poll. What was begun is brought to its end.
    ///
    /// # Errors
    /// What is in the way.
    fn may_commit(&self) -> Result<(), Obstacle>;
}

/// How often flash may be erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WearConfig {
    /// Erasures in a row.
    pub burst: u8,
    /// Time until one more is allowed while flash is new, milliseconds. Half worn it is twice that, three quarters worn four times.
    pub refill_ms: u32,
}

impl Default for WearConfig {
    /// Eight in a row, then one an hour and ever less often: ten years without end don't use 10,000 up.
    fn default() -> Self {
        Self {
            burst: 8,
            refill_ms: 3_600_000,
        }
    }
}

/// Keeps erasures apart: a fault that commits without end must not wear the flash out.
#[derive(Clone, Copy, Debug)]
pub struct WearBudget {
    config: WearConfig,
    /// Erasures that each place may see.
    erasures_max: u32,
    /// Erasures allowed now.
    left: u8,
    /// When one was added last.
    added_ms: u64,
}

impl WearBudget {
    /// For places that may be erased `erasures_max` times. After a start one erasure is allowed, however often it starts.
    #[must_use]
    pub const fn new(config: WearConfig, erasures_max: u32, now_ms: u64) -> Self {
        Self {
            config,
            erasures_max,
            left: if config.burst == 0 { 0 } else { 1 },
            added_ms: now_ms,
        }
    }

    /// Whether a place that was erased `wear` times may be erased now.
    ///
    /// # Errors
    /// Milliseconds until it may; none where it may never.
    pub fn check(&mut self, wear: u32, now_ms: u64) -> Result<(), Option<u64>> {
        let life = self.erasures_max;
        let left = life
            .checked_sub(wear)
            .filter(|left| *left != 0)
            .ok_or(None)?;
        let refill_ms = u64::from(self.config.refill_ms) * u64::from(life) / u64::from(left);
        let passed = now_ms.saturating_sub(self.added_ms);
        let more = passed.checked_div(refill_ms).unwrap_or(u64::MAX);
        let room = self.config.burst.saturating_sub(self.left);
        if more >= room.into() {
            self.left = self.config.burst;
            self.added_ms = now_ms;
        } else {
            // Less than 256 of them.
            self.left += more as u8;
            self.added_ms += more * refill_ms;
        }
        if self.left != 0 {
            Ok(())
        } else if self.config.burst == 0 {
            Err(None)
        } else {
            Err(Some((self.added_ms + refill_ms).saturating_sub(now_ms)))
        }
    }

    /// Takes note of an erasure.
    pub fn spend(&mut self) {
        self.left = self.left.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: WearConfig = WearConfig {
        burst: 3,
        refill_ms: 1000,
    };

    #[test]
    fn one_at_the_start_then_one_a_while_and_a_burst_after_a_rest() {
        let mut budget = WearBudget::new(CONFIG, 100, 500);
        assert_eq!(budget.check(0, 500), Ok(()));
        budget.spend();
        assert_eq!(budget.check(0, 900), Err(Some(600)));
        assert_eq!(budget.check(0, 1500), Ok(()));
        budget.spend();
        for _ in 0..3 {
            assert_eq!(budget.check(0, 60_000), Ok(()));
            budget.spend();
        }
        assert_eq!(budget.check(0, 60_000), Err(Some(1000)));
    }

    #[test]
    fn worn_flash_is_written_less_often_and_at_last_not_at_all() {
        let mut budget = WearBudget::new(CONFIG, 100, 0);
        budget.spend();
        assert_eq!(budget.check(50, 0), Err(Some(2000)));
        assert_eq!(budget.check(99, 0), Err(Some(100_000)));
        assert_eq!(budget.check(99, 100_000), Ok(()));
        assert_eq!(budget.check(100, 100_000), Err(None));
        let none = WearConfig { burst: 0, ..CONFIG };
        assert_eq!(WearBudget::new(none, 100, 0).check(0, 9), Err(None));
    }

    #[test]
    fn ten_years_of_committing_without_end_do_not_wear_it_out() {
        let hours = 10 * 365 * 24;
        let (mut budget, mut wear) = (WearBudget::new(WearConfig::default(), 10_000, 0), 0);
        for minute in 0..60 * hours {
            if budget.check(wear, minute * 60_000) == Ok(()) {
                budget.spend();
                wear += 1;
            }
        }
        assert!(wear > 9000 && wear < 10_000, "{wear}");
    }
}
