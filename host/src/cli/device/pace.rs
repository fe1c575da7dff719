//! The shaft's speed against the window asked for, while a calibration waits for it.

use quadcal::recalibrate::SpeedWindow;
use quadcal::wire::Live;

/// Least weight of a look in the mean: a single one shows the encoder's own errors too.
const WEIGHT: f64 = 0.1;

/// Looks before the mean says something.
const LOOKS_LEAST: u32 = 3;

/// Where a speed is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Slower than the window, or none.
    Below,
    /// In the window.
    Within,
    /// Faster than the window.
    Above,
}

/// Where `speed`, r/min without sign, is.
pub fn place(speed: f64, window: SpeedWindow) -> Place {
    let thousandths = speed * 1e3;
    if thousandths < window.from.into() {
        Place::Below
    } else if thousandths > window.to.into() {
        Place::Above
    } else {
        Place::Within
    }
}

/// A speed outside of the window, to be read in a sentence; none within.
pub fn outside(speed: f64, window: SpeedWindow) -> Option<String> {
    let text = |word: &str, bound: u32| {
        let bound = f64::from(bound) / 1e3;
        format!("{speed:.0} r/min is {word} {bound} r/min")
    };
    match place(speed, window) {
        Place::Below => Some(text("below", window.from)),
        Place::Above => Some(text("above", window.to)),
        Place::Within => None,
    }
}

/// The speed so far.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    window: SpeedWindow,
    /// r/min for 2^-60 turn a tick.
    unit: f64,
    mean: f64,
    looks: u32,
    was_within: bool,
}

impl Pace {
    /// Nothing seen yet, by a device with a clock of `clock_hz`.
    #[allow(clippy::cast_precision_loss)]
    pub fn new(window: SpeedWindow, clock_hz: u64) -> Self {
        Self {
            window,
            unit: 60.0 * clock_hz as f64 / (1_u64 << 60) as f64,
            mean: 0.0,
            looks: 0,
            was_within: false,
        }
    }

    /// Takes a look at the shaft.
    #[allow(clippy::cast_precision_loss)]
    pub fn take(&mut self, live: &Live) {
        let speed = (live.speed as f64 * self.unit).abs();
        self.looks += 1;
        self.mean += (1.0 / f64::from(self.looks)).max(WEIGHT) * (speed - self.mean);
        self.was_within |= self.place() == Some(Place::Within);
    }

    /// Where the speed is by now, once that is sure.
    pub fn place(&self) -> Option<Place> {
        (self.looks >= LOOKS_LEAST).then(|| place(self.mean, self.window))
    }

    /// The speed by now, for people.
    pub fn text(&self) -> String {
        match outside(self.mean, self.window) {
            Some(text) => text,
            None => format!("{:.0} r/min, to be kept evenly", self.mean),
        }
    }

    /// The speed, r/min, if the shaft turned and was never in the window.
    pub fn missed(&self) -> Option<f64> {
        let outside = self.place().is_some_and(|place| place != Place::Within);
        (outside && !self.was_within).then_some(self.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: SpeedWindow = SpeedWindow {
        from: 400_000,
        to: 500_500,
    };

    #[test]
    fn a_speed_outside_is_said_with_the_bound_that_it_misses() {
        let [low, high] = [300.0, 600.0].map(|speed| outside(speed, WINDOW).unwrap());
        assert_eq!(low, "300 r/min is below 400 r/min");
        assert_eq!(high, "600 r/min is above 500.5 r/min");
        assert_eq!(outside(450.0, WINDOW), None);
        assert_eq!(outside(1.0, SpeedWindow::ANY), None);
    }

    #[test]
    fn a_window_is_missed_only_where_the_speed_was_never_in_it() {
        let look = |r_min: f64| {
            let speed = r_min / 60.0 / 1e6 * 2.0_f64.powi(60);
            Live {
                ticks: 0,
                angle: 0,
                referenced: true,
                speed_raw: 0,
                #[allow(clippy::cast_possible_truncation)]
                speed: speed as i64,
                faults: [0; 7],
            }
        };
        let mut pace = Pace::new(WINDOW, 1_000_000);
        assert_eq!(pace.missed(), None);
        // In reverse as well as ahead.
        for _ in 0..3 {
            pace.take(&look(-300.0));
        }
        assert!((pace.missed().unwrap() - 300.0).abs() < 1e-6);
        for _ in 0..40 {
            pace.take(&look(450.0));
        }
        assert_eq!(pace.missed(), None);
        for _ in 0..40 {
            pace.take(&look(900.0));
        }
        assert_eq!((pace.place(), pace.missed()), (Some(Place::Above), None));
    }
}
