//! Ranges and conflicts of shaft, drive and duration.

use std::path::PathBuf;

use super::{ANGLE_ADVICE, Checker, DAMPING_MAX, TIME_MAX, TORQUE_MAX};
use crate::twin::curve::POINTS_MAX;
use crate::twin::{Drive, Duration, Step, Twin};

const TIMES_RISE: &str = "times start at 0 or later and do not fall";

/// Speeds over time.
fn check_speeds(c: &mut Checker<'_>, key: &str, points: &[Step]) {
    let mut last = 0.0;
    for (i, point) in points.iter().enumerate() {
        let time = format!("{key}[{i}].t_s");
        c.between(&time, point.t_s, last, TIME_MAX, TIMES_RISE);
        c.speed(&format!("{key}[{i}].r_min"), point.r_min);
        last = point.t_s;
    }
}

/// Points of a curve in the twin or in a file of their own.
fn check_source(c: &mut Checker<'_>, key: &str, points: usize, csv: &Option<PathBuf>) {
    c.require(
        (points > 0) != csv.is_some(),
        key,
        match points {
            0 => "no points",
            _ => "points and csv",
        },
        "points, or the csv file that has them",
        "give one of the two",
    );
    c.list(&format!("{key}.points"), points, POINTS_MAX);
}

impl Twin {
    pub(super) fn check_shaft(&self, c: &mut Checker<'_>) {
        let s = &self.shaft;
        let inertia = s.inertia_or_one();
        c.positive(
            "shaft.inertia_kg_m2",
            inertia,
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
        let damping = (s.viscous_n_m_s + s.stiffness_n_m_s) / inertia;
        c.require(
            damping <= DAMPING_MAX,
            if s.viscous_n_m_s > s.stiffness_n_m_s {
                "shaft.viscous_n_m_s"
            } else {
                "shaft.stiffness_n_m_s"
            },
            s.viscous_n_m_s.max(s.stiffness_n_m_s),
            &format!("up to {:?} with this inertia", DAMPING_MAX * inertia),
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
            s.stiffness_n_m_s == 0.0 || self.follows_a_speed(),
            "shaft.stiffness_n_m_s",
            s.stiffness_n_m_s,
            "0 with a speed loop or a torque",
            "take it out: it pulls an open-loop drive towards a declared speed",
        );
    }

    pub(super) fn check_friction(&self, c: &mut Checker<'_>) {
        let s = &self.shaft;
        for (key, value) in [
            ("shaft.drag_n_m_s2", s.drag_n_m_s2),
            ("shaft.stribeck_n_m", s.stribeck_n_m),
        ] {
            c.between(key, value, 0.0, TORQUE_MAX, "friction can't be negative");
        }
        c.between(
            "shaft.stribeck_rad_s",
            s.stribeck_rad_s,
            0.0,
            1e6,
            "give the speed over which the friction goes",
        );
        c.require(
            s.stribeck_n_m == 0.0 || s.stribeck_rad_s >= 1e-6,
            "shaft.stribeck_rad_s",
            s.stribeck_rad_s,
            "1e-6 or more with stribeck_n_m",
            "give the speed over which the friction goes",
        );
        let speed = self.drive.nominal_rad_s().abs().max(1.0);
        let most = 0.5 * DAMPING_MAX * s.inertia_or_one() / speed;
        c.require(
            s.drag_n_m_s2 <= most,
            "shaft.drag_n_m_s2",
            s.drag_n_m_s2,
            &format!("up to {most:?} with this inertia and speed"),
            "lower it or raise the inertia: the time constant is below a microsecond",
        );
        let most = DAMPING_MAX * s.inertia_or_one() * s.stribeck_rad_s;
        c.require(
            s.stribeck_n_m <= most,
            "shaft.stribeck_n_m",
            s.stribeck_n_m,
            &format!("up to {most:?} with this inertia and stribeck_rad_s"),
            "lower it or raise stribeck_rad_s: the time constant is below a microsecond",
        );
    }

    /// Whether an open-loop drive follows a declared speed, or may do so: nothing is said against it where the drive is not known.
    pub(super) fn follows_a_speed(&self) -> bool {
        !matches!(self.drive, Drive::SpeedLoop { .. } | Drive::Torque(_))
    }

    pub(super) fn check_drive(&self, c: &mut Checker<'_>) {
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
                check_speeds(c, "drive.steps", steps);
            }
            Drive::Profile(profile) => {
                check_source(c, "drive.profile", profile.points.len(), &profile.csv);
                check_speeds(c, "drive.profile.points", &profile.points);
            }
            Drive::Torque(torque) => {
                c.speed("drive.torque.start_r_min", torque.start_r_min);
                check_source(c, "drive.torque", torque.points.len(), &torque.csv);
                let mut last = 0.0;
                for (i, point) in torque.points.iter().enumerate() {
                    let key = |name: &str| format!("drive.torque.points[{i}].{name}");
                    c.between(&key("t_s"), point.t_s, last, TIME_MAX, TIMES_RISE);
                    c.between(
                        &key("torque_n_m"),
                        point.torque_n_m,
                        -TORQUE_MAX,
                        TORQUE_MAX,
                        "give the drive's torque, negative for reverse",
                    );
                    last = point.t_s;
                }
            }
            Drive::Unknown => {}
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
                nominal != 0.0 || self.drive == Drive::Unknown,
                "duration.turns",
                turns,
                "seconds for a drive that starts and stays at 0 r/min",
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
}
