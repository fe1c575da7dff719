//! How even the speed is that a device hands out, and how soon it answers.

use std::thread;
use std::time::{Duration, Instant};

use quadcal::interval::SPEED_FRACTION_BITS;
use quadcal::wire::Live;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::drive::{CLOCK_HZ, Host};
use super::{TrialError, WAIT};

/// Waits from one sample to the next lie between these, so that all classes of edges and parts of a turn are met alike.
const PAUSE: [Duration; 2] = [Duration::from_micros(500), Duration::from_micros(4500)];

/// Longest time between two samples in which the way is sure to be less than half a turn.
const GAP_MAX: Duration = Duration::from_millis(40);

/// What a device reported, one edge's each.
#[derive(Clone, Debug, Default)]
pub struct Speeds(Vec<Live>);

/// What they come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Samples.
    pub samples: usize,
    /// Mean speed, r/min: way over time by the angles handed out.
    pub r_min: f64,
    /// RMS deviation of the speed without a table from its mean speed, as a share of it.
    pub raw: f64,
    /// The same of the speed handed out, which the table in use corrects.
    pub given: f64,
}

impl Speeds {
    /// Asks for so many, once the angle counts from the index; before that nothing is corrected.
    ///
    /// # Errors
    /// [`TrialError::Device`], [`TrialError::NoIndex`], [`TrialError::Standstill`].
    pub fn sample(host: &mut Host, count: usize) -> Result<Self, TrialError> {
        let begin = Instant::now();
        while !host.live()?.referenced {
            if begin.elapsed() > WAIT {
                return Err(TrialError::NoIndex);
            }
        }
        let (mut speeds, mut random) = (Self::default(), ChaCha8Rng::seed_from_u64(1));
        let mut last = 0;
        while speeds.0.len() < count {
            if begin.elapsed() > WAIT {
                return Err(TrialError::Standstill);
            }
            let live = host.live()?;
            // Never the same edge twice.
            if live.ticks != last && live.speed != 0 {
                speeds.add(&live);
            }
            last = live.ticks;
            thread::sleep(random.random_range(PAUSE[0]..PAUSE[1]));
        }
        Ok(speeds)
    }

    /// Adds one.
    pub fn add(&mut self, live: &Live) {
        self.0.push(*live);
    }

    /// What they come to; none from fewer than two, or from such as lie far apart.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn ripple(&self) -> Option<Ripple> {
        let per_tick = self.mean()?;
        let ripple = |speed: fn(&Live) -> i64| {
            let unit = 2.0_f64.powi(-SPEED_FRACTION_BITS.cast_signed()) / per_tick;
            let off = |live: &Live| (speed(live) as f64 * unit - 1.0).powi(2);
            (self.0.iter().map(off).sum::<f64>() / self.0.len() as f64).sqrt()
        };
        Some(Ripple {
            samples: self.0.len(),
            r_min: per_tick * 60.0 * f64::from(CLOCK_HZ),
            raw: ripple(|live| live.speed_raw),
            given: ripple(|live| live.speed),
        })
    }

    /// Turns a tick. The mean of the speeds is none: at any time the edge seen last tends to have come early.
    #[allow(clippy::cast_precision_loss)]
    fn mean(&self) -> Option<f64> {
        let gap_max = GAP_MAX.as_millis() * u128::from(CLOCK_HZ) / 1000;
        let (mut way, mut time) = (0.0, 0.0);
        for pair in self.0.windows(2) {
            let ticks = pair[1].ticks.saturating_sub(pair[0].ticks);
            if u128::from(ticks) < gap_max {
                let turn32 = pair[1].angle.wrapping_sub(pair[0].angle).cast_signed();
                way += f64::from(turn32) / 2.0_f64.powi(32);
                time += ticks as f64;
            }
        }
        (time > 0.0 && way != 0.0).then_some(way / time)
    }
}

/// Times that a device took to answer.
#[derive(Clone, Debug, Default)]
pub struct Answers(Vec<Duration>);

impl Answers {
    /// Times one answer.
    pub fn time<T>(&mut self, ask: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let answer = ask();
        self.0.push(begin.elapsed());
        answer
    }

    /// The one in the middle, and the longest; none without any.
    #[must_use]
    pub fn middle_and_longest(&self) -> Option<(Duration, Duration)> {
        let mut times = self.0.clone();
        times.sort_unstable();
        Some((*times.get(times.len() / 2)?, *times.last()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ripple_is_a_share_of_the_mean_whichever_way_the_shaft_turns() {
        for sign in [1_i32, -1] {
            let mut speeds = Speeds::default();
            assert_eq!(speeds.ripple(), None);
            // A turn in 2^24 ticks.
            let speed = i64::from(sign) << (SPEED_FRACTION_BITS - 24);
            for k in 0..4_i64 {
                speeds.add(&Live {
                    ticks: 1_000_000 * k as u64,
                    angle: (256_000_000 * k * i64::from(sign)) as u32,
                    speed_raw: if k % 2 == 0 {
                        speed / 4 * 5
                    } else {
                        speed / 4 * 3
                    },
                    speed,
                    ..Live::default()
                });
            }
            let ripple = speeds.ripple().unwrap();
            assert_eq!((ripple.samples, ripple.given), (4, 0.0));
            assert!((ripple.raw - 0.25).abs() < 1e-12);
            let r_min = f64::from(sign) * 60.0 * 84e6 / 2.0_f64.powi(24);
            assert!((ripple.r_min / r_min - 1.0).abs() < 1e-12);
        }
    }
}
