//! From samples with 64-bit ticks to what a drive's interrupt handlers see of them: event records for [`quadcal::replay`].

use quadcal::edge::Sample;
use quadcal::replay::{Event, Header, TimerWidth};
use quadcal::units::Ticks;
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// How late the handlers run.
///
/// One handler serves the timer, as on an STM32: whenever it runs it takes every capture there is, in order, each with the
/// overflow flag as it stands, and only then serves the overflow. Every capture and every wrap asks for it, and it runs
/// after a wait drawn from the seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latency {
    /// Longest wait, in ticks; cut to just under half a timer period, beyond which no handler can tell the order.
    pub max: u32,
    /// Seed of the waits.
    pub seed: u64,
}

impl Latency {
    /// Handlers that run at once.
    pub const NONE: Self = Self { max: 0, seed: 0 };

    /// The longest wait that a timer of this width allows.
    #[must_use]
    pub const fn longest(timer: TimerWidth, seed: u64) -> Self {
        Self {
            max: timer.max() / 2,
            seed,
        }
    }
}

/// Events of one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Events {
    /// Start of the timer period in which the first sample lies: what the target's ticks are counted from.
    pub base: Ticks,
    /// In the order the handlers ran.
    pub events: Vec<Event>,
}

impl Events {
    /// The event file's bytes.
    #[must_use]
    pub fn file(&self, header: &Header) -> Vec<u8> {
        let records = self.events.iter().flat_map(Event::emit);
        header.emit().into_iter().chain(records).collect()
    }
}

/// Runs a timer of width `timer` over `samples`, whose times must not fall.
#[must_use]
pub fn events(samples: &[Sample], timer: TimerWidth, latency: Latency) -> Events {
    let period = Ticks::from(timer.max()) + 1;
    let base = samples
        .first()
        .map_or(0, |sample| sample.ticks / period * period);
    let max = latency.max.min(timer.max() / 2);
    let mut waits = ChaCha8Rng::seed_from_u64(latency.seed);
    let mut draw = || Ticks::from(waits.random_range(0..=max));
    let mut samples = samples.iter().peekable();
    // The next wrap not yet served, and when it has the handler run.
    let mut wrap = base + period;
    let mut wrap_served = wrap + draw();
    let mut events = Vec::new();
    let mut waiting = Vec::new();
    while samples.peek().is_some() {
        // The handler runs at the earliest time that anything asked for; captures made until then may ask for a sooner one.
        let mut now = wrap_served;
        while let Some(sample) = samples.next_if(|sample| sample.ticks <= now) {
            now = now.min(sample.ticks + draw());
            waiting.push(sample);
        }
        let overflow_pending = wrap <= now;
        for sample in waiting.drain(..) {
            events.push(Event::Capture {
                raw: (sample.ticks & Ticks::from(timer.max())) as u32,
                levels: sample.levels,
                overflow_pending,
            });
        }
        if overflow_pending {
            events.push(Event::Overflow);
            wrap += period;
            wrap_served = wrap + draw();
        }
    }
    Events { base, events }
}

#[cfg(test)]
mod tests;
