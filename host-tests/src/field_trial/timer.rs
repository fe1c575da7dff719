//! A 16-bit capture timer that runs on while edges come, as records of an event file.

use quadcal::edge::Sample;
use quadcal::replay::{Event, TimerWidth};
use quadcal::units::Ticks;

/// Ticks from one overflow to the next.
const PERIOD: Ticks = TimerWidth::Bits16.max() as Ticks + 1;

/// A timer that starts with the period of the first time it hears of, each handler being served at once.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Timer {
    /// The next overflow.
    wrap: Option<Ticks>,
}

impl Timer {
    /// Lets time go on, and gives the overflows up to `now` as records.
    pub fn pass(&mut self, now: Ticks, record: &mut impl FnMut(Event)) {
        let wrap = self.wrap.get_or_insert((now / PERIOD + 1) * PERIOD);
        while *wrap <= now {
            record(Event::Overflow);
            *wrap += PERIOD;
        }
    }

    /// Captures a change of level; times must not fall.
    #[allow(clippy::cast_possible_truncation)]
    pub fn capture(&mut self, sample: Sample, record: &mut impl FnMut(Event)) {
        self.pass(sample.ticks, record);
        record(Event::Capture {
            raw: (sample.ticks % PERIOD) as u32,
            levels: sample.levels,
            overflow_pending: false,
        });
    }
}

#[cfg(test)]
mod tests {
    use quadcal::edge::Levels;
    use quadcal::timebase::Timebase16;

    use super::*;

    #[test]
    fn a_time_base_counts_on_from_the_period_in_which_it_began() {
        let (mut timer, mut base) = (Timer::default(), Timebase16::new());
        let times = [
            3 * PERIOD + 5,
            4 * PERIOD - 1,
            4 * PERIOD,
            9 * PERIOD + 7,
            9 * PERIOD + 7,
        ];
        let mut seen = Vec::new();
        let mut record = |event| match event {
            Event::Overflow => base.overflow(),
            Event::Capture {
                raw,
                overflow_pending,
                ..
            } => seen.push(base.capture_first(raw, overflow_pending)),
        };
        for ticks in times {
            let levels = Levels(1);
            timer.capture(Sample { ticks, levels }, &mut record);
        }
        assert_eq!(seen, times.map(|ticks| ticks - 3 * PERIOD));
    }
}
