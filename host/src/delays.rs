//! Delays of a table's edge classes, with the names and units an engineer uses.

use quadcal::slot::Delays;
use quadcal::units::{TICK_FRACTION_BITS, TickDelta8};
use serde::Serialize;

use crate::findings::class_names;
use crate::report::si;
use crate::sensor::SensorKind;

/// How much later than the mean of all classes one kind of edge is captured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClassDelay {
    /// The electrical edge: how the level changes, whatever the direction.
    pub class: &'static str,
    /// Delay, s.
    pub seconds: f64,
    /// Delay in ticks of the table's clock.
    pub ticks: f64,
    /// Standard error, s.
    pub standard_error_seconds: f64,
}

/// Delays of a sensor's classes, edge 0 first; none where the table has no delays.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn class_delays(kind: SensorKind, delays: &Delays) -> Vec<ClassDelay> {
    if delays.is_zero() {
        return Vec::new();
    }
    let clock_hz = delays.clock_hz as f64;
    let standard_error = TickDelta8(delays.standard_error.min(i32::MAX as u32).cast_signed());
    class_names(kind)
        .iter()
        .zip(delays.of_class)
        .map(|(&class, delay)| ClassDelay {
            class,
            seconds: delay.seconds(clock_hz),
            ticks: f64::from(delay.0) / f64::from(1_u32 << TICK_FRACTION_BITS),
            standard_error_seconds: standard_error.seconds(clock_hz),
        })
        .collect()
}

/// All of them in a line; none where there are none.
#[must_use]
pub fn describe(delays: &[ClassDelay]) -> Option<String> {
    let first = delays.first()?;
    let each: Vec<String> = delays
        .iter()
        .map(|delay| {
            // The same minus sign as in the time.
            let ticks = format!("{:.2}", delay.ticks).replace('-', "\u{2212}");
            let time = si(delay.seconds, "s");
            format!("{} {time} ({ticks} ticks)", delay.class)
        })
        .collect();
    let error = si(first.standard_error_seconds, "s");
    Some(format!("{}; standard error {error}", each.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_told_in_time_and_ticks_and_only_where_there_are_some() {
        let kind = SensorKind::Quadrature { index_state: None };
        assert!(class_delays(kind, &Delays::NONE).is_empty());
        assert_eq!(describe(&[]), None);
        let delays = Delays {
            of_class: [2688, -2688, 672, -672, 0, 0].map(TickDelta8),
            standard_error: 215,
            clock_hz: 84_000_000,
        };
        let text = describe(&class_delays(kind, &delays)).unwrap();
        assert_eq!(
            text.replace('\u{a0}', " "),
            "A rises 125 ns (10.50 ticks), B rises \u{2212}125 ns (\u{2212}10.50 ticks), A falls 31.2 ns (2.62 ticks), \
             B falls \u{2212}31.2 ns (\u{2212}2.62 ticks); standard error 10.0 ns"
        );
    }
}
