//! Ranges and conflicts of a twin's values.

use std::f64::consts::PI;
use std::fmt::Debug;

use super::{BadValue, Drive, Duration, Encoder, Noise, Place, Position, Twin};

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
    pub(super) fn find_bad_value(&self) -> Option<BadValue> {
        let mut c = Checker {
            name: &self.name,
            bad: None,
        };
        self.check_encoder(&mut c);
        self.check_errors(&mut c);
        self.check_shaft(&mut c);
        self.check_drive(&mut c);
        self.check_ripple(&mut c);
        self.check_noise(&mut c);
        self.check_capture(&mut c);
        c.bad
    }

    fn check_encoder(&self, c: &mut Checker<'_>) {
        match self.encoder {
            Encoder::Quadrature { lines, .. } => {
                c.count(
                    "encoder.quadrature.lines",
                    lines,
                    1,
                    1_000_000,
                    "give the grating lines of one turn",
                );
            }
            Encoder::Hall { pole_pairs } => {
                c.count(
                    "encoder.hall.pole_pairs",
                    pole_pairs,
                    1,
                    10_000,
                    "give the magnet pole pairs of one turn",
                );
            }
            Encoder::Wheel { teeth, missing } => {
                c.count(
                    "encoder.wheel.teeth",
                    teeth,
                    1,
                    1_000_000,
                    "give the tooth places of one turn",
                );
                c.count(
                    "encoder.wheel.missing",
                    missing,
                    0,
                    teeth.saturating_sub(1),
                    "leave at least one tooth on the wheel",
                );
            }
        }
    }

    fn check_errors(&self, c: &mut Checker<'_>) {
        let e = &self.errors;
        match e.position {
            Some(Position::Uniform { amplitude_rad, .. }) => {
                c.between(
                    "errors.position.uniform.amplitude_rad",
                    amplitude_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
            }
            Some(Position::Normal { rms_rad, .. }) => {
                c.between(
                    "errors.position.normal.rms_rad",
                    rms_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
            }
            None => {}
        }
        let hall = matches!(self.encoder, Encoder::Hall { .. });
        let quadrature = matches!(self.encoder, Encoder::Quadrature { .. });
        for (key, value, has_channel) in [
            ("errors.width_a_rad", e.width_a_rad, true),
            ("errors.width_b_rad", e.width_b_rad, hall || quadrature),
            ("errors.width_c_rad", e.width_c_rad, hall),
            ("errors.quadrature_rad", e.quadrature_rad, quadrature),
            ("errors.shift_b_rad", e.shift_b_rad, hall),
            ("errors.shift_c_rad", e.shift_c_rad, hall),
        ] {
            c.between(key, value, -PI, PI, ANGLE_ADVICE);
            c.require(
                has_channel || value == 0.0,
                key,
                value,
                "0 for this kind of encoder",
                "take it out, or change the encoder's kind",
            );
        }
        for (key, harmonic) in [
            ("errors.eccentricity", e.eccentricity),
            ("errors.tilt", e.tilt),
        ] {
            if let Some(h) = harmonic {
                c.between(
                    &format!("{key}.amplitude_rad"),
                    h.amplitude_rad,
                    0.0,
                    PI,
                    ANGLE_ADVICE,
                );
                c.between(
                    &format!("{key}.phase_rad"),
                    h.phase_rad,
                    -1e3,
                    1e3,
                    ANGLE_ADVICE,
                );
            }
        }
        self.check_error_list(c);
    }

    fn check_error_list(&self, c: &mut Checker<'_>) {
        let e = &self.errors;
        let whole = if e.csv.is_some() {
            "errors.csv"
        } else {
            "errors.list_rad"
        };
        if e.csv.is_none() && e.list_rad.is_empty() {
            return;
        }
        let parts = super::Errors {
            list_rad: Vec::new(),
            csv: None,
            ..e.clone()
        };
        c.require(
            parts == super::Errors::default() && (e.csv.is_none() || e.list_rad.is_empty()),
            whole,
            "given together with other errors",
            "a list alone, or the parts alone",
            "a list is the whole of e: take out the other keys of [errors]",
        );
        if e.csv.is_none() {
            let edges = self.encoder.grid_edges() as usize;
            c.require(
                e.list_rad.len() == edges,
                whole,
                format_args!("{} numbers", e.list_rad.len()),
                &format!("{edges} numbers, one for each edge of a turn"),
                "give every edge its error",
            );
            for (k, value) in e.list_rad.iter().enumerate() {
                c.between(
                    &format!("errors.list_rad[{k}]"),
                    *value,
                    -PI,
                    PI,
                    ANGLE_ADVICE,
                );
            }
        }
    }

    fn check_shaft(&self, c: &mut Checker<'_>) {
        let s = &self.shaft;
        c.positive(
            "shaft.inertia_kg_m2",
            s.inertia_kg_m2,
            1e9,
            "give the inertia of all that turns",
        );
        c.between(
            "shaft.viscous_n_m_s",
            s.viscous_n_m_s,
            0.0,
            TORQUE_MAX,
            "friction can't be negative",
        );
        c.between(
            "shaft.coulomb_n_m",
            s.coulomb_n_m,
            0.0,
            TORQUE_MAX,
            "friction can't be negative",
        );
        c.between(
            "shaft.stiffness_n_m_s",
            s.stiffness_n_m_s,
            0.0,
            TORQUE_MAX,
            "leave it out for pure torque mode",
        );
        let damping = (s.viscous_n_m_s + s.stiffness_n_m_s) / s.inertia_kg_m2;
        c.require(
            damping <= DAMPING_MAX,
            if s.viscous_n_m_s > s.stiffness_n_m_s {
                "shaft.viscous_n_m_s"
            } else {
                "shaft.stiffness_n_m_s"
            },
            s.viscous_n_m_s.max(s.stiffness_n_m_s),
            &format!(
                "up to {:?} with this inertia",
                DAMPING_MAX * s.inertia_kg_m2
            ),
            "lower it or raise the inertia: the time constant is below a microsecond",
        );
        c.between(
            "shaft.initial_angle_rad",
            s.initial_angle_rad,
            -1e3,
            1e3,
            ANGLE_ADVICE,
        );
        c.require(
            s.stiffness_n_m_s == 0.0 || !matches!(self.drive, Drive::SpeedLoop { .. }),
            "shaft.stiffness_n_m_s",
            s.stiffness_n_m_s,
            "0 with a speed loop",
            "take it out: the loop itself holds the speed",
        );
    }

    fn check_drive(&self, c: &mut Checker<'_>) {
        match &self.drive {
            Drive::Constant { r_min } => c.speed("drive.constant.r_min", *r_min),
            Drive::Ramp {
                from_r_min,
                to_r_min,
                over_s,
            } => {
                c.speed("drive.ramp.from_r_min", *from_r_min);
                c.speed("drive.ramp.to_r_min", *to_r_min);
                c.positive(
                    "drive.ramp.over_s",
                    *over_s,
                    TIME_MAX,
                    "give the ramp a length",
                );
            }
            Drive::Steps(steps) => {
                c.require(
                    !steps.is_empty(),
                    "drive.steps",
                    "[]",
                    "one step or more",
                    "list { t_s, r_min } entries",
                );
                let mut last = 0.0;
                for (i, step) in steps.iter().enumerate() {
                    let key = format!("drive.steps[{i}].t_s");
                    c.between(
                        &key,
                        step.t_s,
                        last,
                        TIME_MAX,
                        "times start at 0 or later and do not fall",
                    );
                    c.speed(&format!("drive.steps[{i}].r_min"), step.r_min);
                    last = step.t_s;
                }
            }
            Drive::RunDown { r_min, off_s } => {
                c.speed("drive.run_down.r_min", *r_min);
                c.between(
                    "drive.run_down.off_s",
                    *off_s,
                    0.0,
                    TIME_MAX,
                    "say when the drive goes off",
                );
            }
            Drive::SpeedLoop { .. } => self.check_loop(c),
        }
        let nominal = self.drive.nominal_rad_s();
        if let Duration::Turns(turns) = self.duration {
            c.positive("duration.turns", turns, 1e9, "say how many turns to record");
            c.require(
                nominal != 0.0,
                "duration.turns",
                turns,
                "seconds for a drive at 0 r/min",
                "use duration.seconds",
            );
        }
        if let Duration::Seconds(seconds) = self.duration {
            c.positive(
                "duration.seconds",
                seconds,
                TIME_MAX,
                "say how many seconds to record",
            );
        }
    }

    fn check_loop(&self, c: &mut Checker<'_>) {
        let Drive::SpeedLoop {
            r_min,
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            timeout_s,
            limit_n_m,
        } = self.drive
        else {
            return;
        };
        c.speed("drive.speed_loop.r_min", r_min);
        c.require(
            r_min != 0.0,
            "drive.speed_loop.r_min",
            r_min,
            "not 0",
            "give the speed the loop holds",
        );
        c.between(
            "drive.speed_loop.f_hz",
            f_hz,
            1.0,
            1e7,
            "give the loop's sample rate",
        );
        if let Some(bandwidth) = bandwidth_hz {
            c.positive(
                "drive.speed_loop.bandwidth_hz",
                bandwidth,
                f_hz / 6.0,
                "a sampled loop is stable below f_hz / 6",
            );
            c.require(
                kp_n_m_s.is_none() && ki_n_m.is_none(),
                "drive.speed_loop.bandwidth_hz",
                bandwidth,
                "the bandwidth alone, or kp_n_m_s with ki_n_m",
                "take out one of the two ways to set the gains",
            );
        } else {
            for (key, gain) in [
                ("drive.speed_loop.kp_n_m_s", kp_n_m_s),
                ("drive.speed_loop.ki_n_m", ki_n_m),
            ] {
                c.require(
                    gain.is_some(),
                    key,
                    "missing",
                    "both gains, or bandwidth_hz",
                    "give the loop its gains",
                );
                c.between(
                    key,
                    gain.unwrap_or(0.0),
                    0.0,
                    1e9,
                    "give a gain of 0 or more",
                );
            }
        }
        if let Some(timeout) = timeout_s {
            c.positive(
                "drive.speed_loop.timeout_s",
                timeout,
                TIME_MAX,
                "leave it out for 20 intervals",
            );
        }
        if let Some(limit) = limit_n_m {
            c.positive(
                "drive.speed_loop.limit_n_m",
                limit,
                TORQUE_MAX,
                "leave it out for no limit",
            );
        }
    }

    fn check_ripple(&self, c: &mut Checker<'_>) {
        for (i, ripple) in self.ripple.iter().enumerate() {
            c.positive(
                &format!("ripple[{i}].order"),
                ripple.order,
                1e5,
                "give cycles a turn",
            );
            c.between(
                &format!("ripple[{i}].phase_rad"),
                ripple.phase_rad,
                -1e3,
                1e3,
                "give radians",
            );
            let key = format!("ripple[{i}]");
            match (ripple.torque_n_m, ripple.speed_fraction) {
                (Some(torque), None) => {
                    c.between(
                        &format!("{key}.torque_n_m"),
                        torque,
                        0.0,
                        TORQUE_MAX,
                        "turn the sign by the phase",
                    );
                }
                (None, Some(fraction)) => {
                    let key = format!("{key}.speed_fraction");
                    c.between(
                        &key,
                        fraction,
                        0.0,
                        0.9,
                        "give the swing over the nominal speed",
                    );
                    let turning = self.drive.nominal_rad_s() != 0.0;
                    c.require(
                        turning,
                        &key,
                        fraction,
                        "torque_n_m for a drive at 0 r/min",
                        "use torque_n_m",
                    );
                }
                (torque, _) => c.require(
                    false,
                    &key,
                    if torque.is_some() {
                        "both sizes"
                    } else {
                        "no size"
                    },
                    "one of torque_n_m and speed_fraction",
                    "give the ripple one size",
                ),
            }
        }
    }

    fn check_noise(&self, c: &mut Checker<'_>) {
        match self.noise {
            None => {}
            Some(Noise::White {
                psd_n2_m2_s,
                hold_s,
            }) => {
                c.between(
                    "noise.white.psd_n2_m2_s",
                    psd_n2_m2_s,
                    0.0,
                    1e12,
                    "a density can't be negative",
                );
                self.check_hold(c, "noise.white.hold_s", hold_s);
            }
            Some(Noise::SpeedWander {
                rms_fraction,
                correlation_rad,
                hold_s,
            }) => {
                c.between(
                    "noise.speed_wander.rms_fraction",
                    rms_fraction,
                    0.0,
                    0.3,
                    "give the RMS over the nominal speed",
                );
                self.check_hold(c, "noise.speed_wander.hold_s", hold_s);
                self.check_wander(c, rms_fraction, correlation_rad);
            }
        }
    }

    fn check_hold(&self, c: &mut Checker<'_>, key: &str, hold_s: Option<f64>) {
        match hold_s {
            Some(hold) => c.between(
                key,
                hold,
                1e-9,
                TIME_MAX,
                "leave it out for one nominal interval",
            ),
            None => c.require(
                self.drive.nominal_rad_s() != 0.0,
                key,
                "missing",
                "a time, as this drive has no nominal interval",
                "give the step of the noise's grid",
            ),
        }
    }

    fn check_wander(&self, c: &mut Checker<'_>, rms_fraction: f64, correlation_rad: Option<f64>) {
        let nominal = self.drive.nominal_rad_s().abs();
        let (key, s) = ("noise.speed_wander", &self.shaft);
        c.require(
            nominal != 0.0,
            key,
            rms_fraction,
            "a drive that turns",
            "use noise.white",
        );
        c.require(
            !matches!(self.drive, Drive::SpeedLoop { .. }),
            key,
            rms_fraction,
            "an open-loop drive",
            "use noise.white: a loop shapes the wander itself",
        );
        match correlation_rad {
            Some(correlation) => {
                let key = "noise.speed_wander.correlation_rad";
                c.positive(
                    key,
                    correlation,
                    1e6,
                    "give the angle over which the speed forgets",
                );
                let longest = s.inertia_kg_m2 * nominal / s.viscous_n_m_s;
                c.require(
                    correlation <= longest,
                    key,
                    correlation,
                    &format!("up to J w / viscous = {longest:?}"),
                    "lower it or the viscous friction, or raise the inertia",
                );
                c.require(
                    s.stiffness_n_m_s == 0.0,
                    key,
                    correlation,
                    "only where shaft.stiffness_n_m_s is left out",
                    "take out one: the correlation sets the stiffness",
                );
            }
            None => c.require(
                s.viscous_n_m_s + s.stiffness_n_m_s > 0.0,
                key,
                rms_fraction,
                "a shaft with viscous_n_m_s or stiffness_n_m_s, or a correlation_rad",
                "give correlation_rad: without friction a wander grows for ever",
            ),
        }
    }

    fn check_capture(&self, c: &mut Checker<'_>) {
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
