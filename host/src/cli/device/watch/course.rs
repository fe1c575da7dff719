//! The samples of a watch, and what they come to.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use quadcal::interval::SPEED_FRACTION_BITS;
use quadcal::wire::Live;
use serde::Serialize;

use super::super::super::output::Facts;

/// Samples kept for the chart.
const KEPT: usize = 1000;

/// Faults counted since the device's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct FaultCounts {
    illegal: u32,
    lost: u32,
    extra: u32,
    glitch: u32,
    abrupt_reversal: u32,
    interval_spike: u32,
    repeated: u32,
}

impl FaultCounts {
    const fn new(counts: [u32; 7]) -> Self {
        let [
            illegal,
            lost,
            extra,
            glitch,
            abrupt_reversal,
            interval_spike,
            repeated,
        ] = counts;
        Self {
            illegal,
            lost,
            extra,
            glitch,
            abrupt_reversal,
            interval_spike,
            repeated,
        }
    }

    /// All together.
    pub(super) fn total(self) -> u64 {
        let counts = [
            self.illegal,
            self.lost,
            self.extra,
            self.glitch,
            self.abrupt_reversal,
            self.interval_spike,
            self.repeated,
        ];
        counts.into_iter().map(u64::from).sum()
    }
}

/// The shaft at one time, as in the JSON.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Sample {
    kind: &'static str,
    pub time_s: f64,
    pub rev_per_min_before: f64,
    pub rev_per_min_after: f64,
    pub angle_rad: f64,
    pub referenced: bool,
    pub faults: FaultCounts,
}

/// What a watch came to, as in the JSON.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    kind: &'static str,
    port: String,
    seconds: f64,
    samples: u32,
    turns: f64,
    rev_per_min_mean: Option<f64>,
    rev_per_min_scatter_before: Option<f64>,
    rev_per_min_scatter_after: Option<f64>,
    faults: FaultCounts,
}

/// Scatter of a value from sample to sample.
#[derive(Clone, Copy, Debug, Default)]
struct Scatter {
    last: Option<f64>,
    sum: f64,
    count: u32,
}

impl Scatter {
    fn push(&mut self, value: f64) {
        if let Some(last) = self.last.replace(value) {
            self.sum += (value - last).powi(2);
            self.count += 1;
        }
    }

    /// RMS of the step from sample to sample over the root of two: of independent samples their standard deviation.
    fn rms(self) -> Option<f64> {
        (self.count > 0).then(|| (0.5 * self.sum / f64::from(self.count)).sqrt())
    }
}

/// All samples of a watch.
#[derive(Debug)]
pub(super) struct Course {
    clock_hz: f64,
    /// Ticks of the first sample and of the last one.
    ticks: Option<(u64, u64)>,
    turns: f64,
    samples: u32,
    sum: f64,
    before: Scatter,
    after: Scatter,
    faults: FaultCounts,
    pub kept: VecDeque<[f64; 2]>,
}

impl Course {
    /// Nothing seen of a device with such a clock.
    #[allow(clippy::cast_precision_loss)]
    pub fn new(clock_hz: u64) -> Self {
        Self {
            clock_hz: clock_hz.max(1) as f64,
            ticks: None,
            turns: 0.0,
            samples: 0,
            sum: 0.0,
            before: Scatter::default(),
            after: Scatter::default(),
            faults: FaultCounts::default(),
            kept: VecDeque::new(),
        }
    }

    /// Takes a sample.
    #[allow(clippy::cast_precision_loss)]
    pub fn push(&mut self, live: &Live) -> Sample {
        let unit = 0.5_f64.powi(SPEED_FRACTION_BITS as i32);
        let r_min = |speed: i64| speed as f64 * unit * self.clock_hz * 60.0;
        let (before, after) = (r_min(live.speed_raw), r_min(live.speed));
        let (first, last) = self.ticks.unwrap_or((live.ticks, live.ticks));
        let seconds = |ticks: u64| ticks as f64 / self.clock_hz;
        self.turns += (after / 60.0).abs() * seconds(live.ticks.saturating_sub(last));
        self.ticks = Some((first, live.ticks));
        self.samples += 1;
        self.sum += after;
        self.before.push(before);
        self.after.push(after);
        self.faults = FaultCounts::new(live.faults);
        self.kept.push_back([before, after]);
        if self.kept.len() > KEPT {
            self.kept.pop_front();
        }
        Sample {
            kind: "sample",
            time_s: seconds(live.ticks.saturating_sub(first)),
            rev_per_min_before: before,
            rev_per_min_after: after,
            angle_rad: f64::from(live.angle) / 2.0_f64.powi(32) * TAU,
            referenced: live.referenced,
            faults: self.faults,
        }
    }

    /// Samples taken.
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// Turns that the shaft made since the first sample, either way, as its speed has it.
    pub const fn turns(&self) -> f64 {
        self.turns
    }

    /// Scatter before and after correction, r/min.
    pub fn scatter(&self) -> [Option<f64>; 2] {
        [self.before.rms(), self.after.rms()]
    }

    #[allow(clippy::cast_precision_loss)]
    pub fn summary(&self, port: &str) -> Summary {
        let ticks = self
            .ticks
            .map_or(0, |(first, last)| last.saturating_sub(first));
        let [before, after] = self.scatter();
        Summary {
            kind: "summary",
            port: port.to_owned(),
            seconds: ticks as f64 / self.clock_hz,
            samples: self.samples,
            turns: self.turns,
            rev_per_min_mean: (self.samples > 0).then(|| self.sum / f64::from(self.samples)),
            rev_per_min_scatter_before: before,
            rev_per_min_scatter_after: after,
            faults: self.faults,
        }
    }
}

impl Summary {
    pub(super) fn describe(&self, facts: &mut Facts) {
        let r_min = |value: Option<f64>| match value {
            Some(value) => format!("{value:.4} r/min"),
            None => "not known from fewer than two samples".to_owned(),
        };
        facts
            .push("Port", &self.port)
            .push(
                "Watched",
                format!(
                    "{:.1} s, {} samples, about {:.0} turns",
                    self.seconds, self.samples, self.turns
                ),
            )
            .push("Mean speed", r_min(self.rev_per_min_mean))
            .push(
                "Scatter before correction",
                r_min(self.rev_per_min_scatter_before),
            )
            .push(
                "Scatter after correction",
                r_min(self.rev_per_min_scatter_after),
            )
            .push("Faults since the start", self.faults.total());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn live(ticks: u64, r_min: f64) -> Live {
        let speed = (r_min / 60.0 / 1e6 * 2.0_f64.powi(60)) as i64;
        Live {
            ticks,
            angle: 1 << 31,
            speed,
            speed_raw: -speed,
            ..Live::default()
        }
    }

    #[test]
    fn speeds_turns_and_times_are_in_their_units() {
        let mut course = Course::new(1_000_000);
        let first = course.push(&live(5_000_000, 60.0));
        assert!((first.rev_per_min_after - 60.0).abs() < 1e-6 && first.time_s == 0.0);
        assert!((first.rev_per_min_before + 60.0).abs() < 1e-6);
        assert!((first.angle_rad - TAU / 2.0).abs() < 1e-9);
        let second = course.push(&live(7_000_000, 60.0));
        assert!((second.time_s - 2.0).abs() < 1e-12 && (course.turns() - 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_steady_change_of_speed_hardly_scatters() {
        let mut course = Course::new(1_000_000);
        assert_eq!(course.scatter(), [None, None]);
        for step in 0..100_u32 {
            let noise = if step % 2 == 0 { 1.0 } else { -1.0 };
            let ramp = live(u64::from(step), 100.0 + 0.01 * f64::from(step));
            course.push(&Live {
                speed_raw: live(0, 100.0 + noise).speed,
                ..ramp
            });
        }
        let [before, after] = course.scatter().map(Option::unwrap);
        assert!((before - 2.0_f64.sqrt()).abs() < 0.02, "{before}");
        assert!((after - 0.01 / 2.0_f64.sqrt()).abs() < 1e-4, "{after}");
    }
}
