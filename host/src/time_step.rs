//! The step of a recording's time stamps, which may be longer than a tick: a logic analyser samples at its own rate and writes
//! nanoseconds.

use crate::recording::NANOSECOND_HZ;

/// Times from which on a step is believed; fewer may have one by chance.
const TIMES_LEAST: u64 = 200;

/// Ticks that a time rounded to one may be off another.
const ROUNDING: f64 = 1.001;

/// Usual sample rates that are no whole number of nanoseconds, Hz; such times have no common divisor. Faster ones can't be told from
/// nanoseconds.
const RATES_HZ: [f64; 27] = [
    48e3, 3e6, 6e6, 12e6, 15e6, 16e6, 24e6, 30e6, 32e6, 36e6, 48e6, 60e6, 64e6, 72e6, 75e6, 80e6,
    84e6, 90e6, 96e6, 120e6, 128e6, 150e6, 160e6, 168e6, 180e6, 192e6, 240e6,
];

/// Takes times one by one.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeStep {
    first: Option<u64>,
    times: u64,
    last: u64,
    /// Largest common divisor of all times from the first on, ticks.
    divisor: u64,
    /// Rates that all times fit so far.
    rates: Vec<f64>,
}

impl TimeStep {
    /// Of a recording of `clock_hz` ticks a second.
    #[must_use]
    pub fn new(clock_hz: u64) -> Self {
        let rounded = clock_hz == NANOSECOND_HZ;
        Self {
            first: None,
            times: 0,
            last: 0,
            divisor: 0,
            rates: if rounded {
                RATES_HZ.to_vec()
            } else {
                Vec::new()
            },
        }
    }

    /// The next time, ticks.
    #[allow(clippy::cast_precision_loss)]
    pub fn push(&mut self, ticks: u64) {
        let first = *self.first.get_or_insert(ticks);
        if self.times > 0 && ticks == self.last {
            return;
        }
        self.times += 1;
        self.last = ticks;
        let since = ticks.saturating_sub(first);
        self.divisor = divisor(self.divisor, since);
        self.rates.retain(|rate| {
            let step = NANOSECOND_HZ as f64 / rate;
            let off = since as f64 / step;
            (off - off.round()).abs() * step <= ROUNDING
        });
    }

    /// The step, ticks: 1 where every tick is used; none with few times.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn ticks(&self) -> Option<f64> {
        if self.times < TIMES_LEAST {
            return None;
        }
        // A faster rate fits wherever a slower one does that divides it.
        let steps = self.rates.iter().map(|rate| NANOSECOND_HZ as f64 / rate);
        Some(steps.fold(self.divisor.max(1) as f64, f64::max))
    }
}

fn divisor(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step of edges about 12 us apart, sampled at a rate and written in nanoseconds.
    fn step_at(rate_hz: f64, rows: u64) -> Option<f64> {
        let mut step = TimeStep::new(NANOSECOND_HZ);
        for k in 0..rows {
            let seconds = 1e-3 + 12.34e-6 * k as f64 + 1e-7 * (k as f64).sin();
            let sampled = (seconds * rate_hz).round() / rate_hz;
            step.push((sampled * 1e9).round() as u64);
        }
        step.ticks()
    }

    #[test]
    fn an_analyser_s_rate_is_found_in_rounded_times() {
        for (rate, expected) in [
            (24e6, 1000.0 / 24.0),
            (16e6, 62.5),
            (100e6, 10.0),
            (240e6, 1000.0 / 240.0),
            (1e6, 1000.0),
            (1e9, 1.0),
        ] {
            let found = step_at(rate, 1000).unwrap();
            assert!((found - expected).abs() < 1e-9, "{rate}: {found}");
        }
        assert_eq!(step_at(24e6, 100), None);
    }

    #[test]
    fn ticks_of_a_timer_have_their_divisor_and_no_rates() {
        let mut step = TimeStep::new(84_000_000);
        (0..500_u64).for_each(|k| step.push(1000 + 12 * k * k));
        assert_eq!(step.ticks(), Some(12.0));
    }
}
