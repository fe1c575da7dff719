//! Ranges and conflicts of a twin's values.

mod cost;
mod delay;
mod effect;
mod elastic;
mod encoder;
mod inertia;
mod motion;
mod rotating;
mod signal;
mod torque;

use std::fmt::Debug;

use super::{BadValue, Channel, Encoder, Place, Twin};

/// Keeps the first value that is not allowed.
struct Checker<'a> {
    name: &'a str,
    bad: Option<BadValue>,
}

impl Checker<'_> {
    fn require(
        &mut self,
        ok: bool,
        key: &str,
        value: impl Debug,
        allowed: &str,
        advice: &'static str,
    ) {
        if !ok && self.bad.is_none() {
            self.bad = Some(BadValue {
                place: Place {
                    name: self.name.to_owned(),
                    position: None,
                },
                key: key.to_owned(),
                value: format!("{value:?}"),
                allowed: allowed.to_owned(),
                advice,
            });
        }
    }

    /// A finite number from `min` to `max`.
    fn between(&mut self, key: &str, value: f64, min: f64, max: f64, advice: &'static str) {
        let ok = (min..=max).contains(&value);
        self.require(ok, key, value, &format!("{min:?} to {max:?}"), advice);
    }

    /// A number above 0 and up to `max`.
    fn positive(&mut self, key: &str, value: f64, max: f64, advice: &'static str) {
        let ok = value >= f64::MIN_POSITIVE && value <= max;
        self.require(
            ok,
            key,
            value,
            &format!("above 0 and up to {max:?}"),
            advice,
        );
    }

    fn count(&mut self, key: &str, value: u32, min: u32, max: u32, advice: &'static str) {
        let ok = (min..=max).contains(&value);
        self.require(ok, key, value, &format!("{min} to {max}"), advice);
    }

    /// A list of up to `most` entries.
    fn list(&mut self, key: &str, entries: usize, most: usize) {
        self.require(
            entries <= most,
            key,
            format_args!("{entries} entries"),
            &format!("up to {most} entries"),
            "leave out the smallest ones",
        );
    }

    fn seed(&mut self, key: &str, seed: u64) {
        let largest = i64::MAX.unsigned_abs();
        self.require(
            seed <= largest,
            key,
            seed,
            &format!("0 to {largest}"),
            "TOML holds no larger number",
        );
    }

    /// A phase.
    fn phase(&mut self, key: &str, phase_rad: f64) {
        self.between(key, phase_rad, -1e3, 1e3, "give radians");
    }

    /// A channel that this encoder has.
    fn channel(&mut self, key: &str, channel: Option<Channel>, encoder: &Encoder) {
        let ok = match channel {
            None | Some(Channel::A) => true,
            Some(Channel::B) => !matches!(encoder, Encoder::Wheel { .. }),
            Some(Channel::C) => matches!(encoder, Encoder::Hall { .. }),
        };
        self.require(
            ok,
            key,
            channel,
            "a channel of this encoder",
            "name another channel, or leave it out for all",
        );
    }

    fn speed(&mut self, key: &str, r_min: f64) {
        self.between(
            key,
            r_min,
            -1e6,
            1e6,
            "give a speed in r/min, negative for reverse",
        );
    }
}

const TORQUE_MAX: f64 = 1e6;
const TIME_MAX: f64 = 1e7;
/// Largest friction and stiffness over inertia, 1/s.
const DAMPING_MAX: f64 = 1e6;
const ANGLE_ADVICE: &str = "give radians of the shaft";

impl Twin {
    /// The first value that is out of range or contradicts another.
    pub(in crate::twin) fn find_bad_value(&self) -> Option<BadValue> {
        let mut c = Checker {
            name: &self.name,
            bad: None,
        };
        self.check_encoder(&mut c);
        self.check_errors(&mut c);
        self.check_defects(&mut c);
        self.check_shaft(&mut c);
        self.check_friction(&mut c);
        self.check_drive(&mut c);
        self.check_inertia(&mut c);
        self.check_ripple(&mut c);
        self.check_loads(&mut c);
        self.check_rotating(&mut c);
        self.check_tones(&mut c);
        self.check_noise(&mut c);
        self.check_drift(&mut c);
        self.check_elastic(&mut c);
        self.check_delays(&mut c);
        self.check_thresholds(&mut c);
        self.check_play(&mut c);
        self.check_slips(&mut c);
        self.check_latency(&mut c);
        self.check_effects(&mut c);
        self.check_capture(&mut c);
        self.check_cost(&mut c);
        c.bad
    }

    fn check_capture(&self, c: &mut Checker<'_>) {
        c.seed("seed", self.seed);
        let t = &self.timer;
        c.require(
            (1..=1_000_000_000_000).contains(&t.clock_hz),
            "timer.clock_hz",
            t.clock_hz,
            "1 to 1000000000000",
            "give the timer's tick rate",
        );
        c.require(
            matches!(t.bits, 16 | 32 | 64),
            "timer.bits",
            t.bits,
            "16, 32 or 64",
            "give the register's width",
        );
        c.between(
            "timer.jitter_s",
            t.jitter_s,
            0.0,
            1.0,
            "give an RMS in seconds",
        );
        let f = &self.faults;
        c.between(
            "faults.lost_probability",
            f.lost_probability,
            0.0,
            1.0,
            "give a probability",
        );
        c.between(
            "faults.glitch_probability",
            f.glitch_probability,
            0.0,
            1.0,
            "give a probability",
        );
        c.between(
            "faults.glitch_width_s",
            f.glitch_width_s,
            0.0,
            1.0,
            "give a short time",
        );
        c.require(
            f.glitch_probability == 0.0 || f.glitch_width_s > 0.0,
            "faults.glitch_width_s",
            f.glitch_width_s,
            "above 0 with glitches",
            "give the glitches a length",
        );
    }
}
