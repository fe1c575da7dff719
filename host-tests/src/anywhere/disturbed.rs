//! A rig whose running is disturbed: strong ripple, strong wander, load steps. Recordings, the truth, and which turns were hit.

use std::f64::consts::TAU;

use quadcal::estimate::Rejection;
use quadcal_host::calibrate::{CalibrateError, Calibration, RejectedTurn};
use quadcal_host::twin::{Drive, LoadStep, Noise, Ripple, Twin, TwinError};

use super::{
    COGGING_SWING, GivenGains, MARGIN_TURNS, RAMP_END_R_MIN, RAMP_MARGIN_TURNS, Rig, Run,
    SLOW_R_MIN, Scenario, WANDER, damping, ramp_s, slow_rad_s,
};

/// What the speed swings by at the slow speed with strong cogging, a part of it: the sum of the amplitudes of its four orders, 5, 10,
/// 15 and 30, which have the same each.
pub const STRONG_RIPPLE: f64 = 0.2;
/// RMS of a strong wander of the slow speed, a part of it.
pub const STRONG_WANDER: f64 = 0.02;
/// Loads: the speed that the shaft gives way by in the end at the slow speed, a part of it, and in which part of which turns the load
/// is there; 0 is the first index, 5.3 lies in turn number 6. The torque is the same at every speed.
pub const LOADS: [(f64, f64, f64); 2] = [(0.1, 5.3, 5.7), (0.2, 8.4, 9.7)];
/// The same on the ramp.
pub const RAMP_LOADS: [(f64, f64, f64); 2] = [(0.1, 20.3, 20.7), (0.2, 30.4, 31.7)];

/// Speeds near each other, r/min.
pub const NEAR_R_MIN: [f64; 2] = [100.0, 150.0];
/// Torque once a turn at these: the swing of the speed that it makes at the slow speed of the others, a part of it.
pub const UNBALANCE_SWING: f64 = 0.01;

/// What disturbs a rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// Cogging that makes [`STRONG_RIPPLE`]; 15 and 600 r/min.
    Ripple,
    /// Torque noise that makes [`STRONG_WANDER`]; 15 and 600 r/min, with the usual cogging.
    Wander,
    /// [`LOADS`] in each recording; 15 and 600 r/min, with the usual cogging.
    LoadSteps,
    /// `NEAR_R_MIN` instead of 15 and 600 r/min, and torque at order 1 beside the usual cogging.
    NearSpeeds,
    /// Strong cogging and [`RAMP_LOADS`] on the ramp from 15 to 1500 r/min.
    Ramp,
}

impl Disturbance {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Ripple,
        Self::Wander,
        Self::LoadSteps,
        Self::NearSpeeds,
        Self::Ramp,
    ];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ripple => "15 and 600 r/min, 20 % ripple",
            Self::Wander => "15 and 600 r/min, cogging, 2 % wander",
            Self::LoadSteps => "15 and 600 r/min, cogging, load steps",
            Self::NearSpeeds => "100 and 150 r/min, cogging and torque once a turn",
            Self::Ramp => "ramp 15 to 1500 r/min, 20 % ripple, load steps",
        }
    }

    fn strong_ripple(self) -> bool {
        matches!(self, Self::Ripple | Self::Ramp)
    }

    fn loads(self) -> &'static [(f64, f64, f64)] {
        match self {
            Self::Ripple | Self::Wander | Self::NearSpeeds => &[],
            Self::LoadSteps => &LOADS,
            Self::Ramp => &RAMP_LOADS,
        }
    }
}

/// A disturbed rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Disturbed {
    /// What disturbs it.
    pub by: Disturbance,
    /// Lines of its disc.
    pub lines: u32,
}

impl Disturbed {
    /// The rig without the disturbance.
    #[must_use]
    pub const fn rig(self) -> Rig {
        let scenario = match self.by {
            Disturbance::Ramp => Scenario::Ramp,
            _ => Scenario::TwoSpeeds,
        };
        Rig {
            scenario,
            lines: self.lines,
        }
    }

    /// The twins of its recordings.
    #[must_use]
    pub fn twins(self, seed: u64) -> Vec<Twin> {
        let mut twins = self.rig().twins(seed);
        for (twin, r_min) in twins.iter_mut().zip(NEAR_R_MIN) {
            if self.by == Disturbance::NearSpeeds {
                drive_at(twin, r_min);
            }
            self.disturb(twin);
        }
        twins
    }

    fn disturb(self, twin: &mut Twin) {
        if self.by.strong_ripple() {
            let times = STRONG_RIPPLE / (COGGING_SWING * twin.ripple.len() as f64);
            for torque in twin.ripple.iter_mut().filter_map(|r| r.torque_n_m.as_mut()) {
                *torque *= times;
            }
        }
        if self.by == Disturbance::Wander
            && let Some(Noise::SpeedWander { rms_fraction, .. }) = &mut twin.noise
        {
            *rms_fraction *= STRONG_WANDER / WANDER;
        }
        let inertia = twin.shaft.inertia_kg_m2;
        let drive = twin.drive.clone();
        twin.load_step = self
            .by
            .loads()
            .iter()
            .map(|&(share, from, until)| LoadStep {
                torque_n_m: -inertia * share * slow_rad_s() * damping(),
                from_s: time_s(&drive, from),
                until_s: Some(time_s(&drive, until)),
            })
            .collect();
    }

    /// Runs it.
    ///
    /// # Errors
    /// The simulator's.
    pub fn run(self, seed: u64) -> Result<Run, TwinError> {
        Run::of(&self.twins(seed))
    }

    /// As [`Rig::calibrate`].
    ///
    /// # Errors
    /// [`CalibrateError`] of the recordings.
    pub fn calibrate(self, run: &Run, seed: u64) -> Result<Calibration, CalibrateError> {
        self.rig().calibrate(run, seed, GivenGains::EXACT)
    }

    /// Numbers of the turns in which a load comes or goes, for each recording of a run.
    #[must_use]
    pub fn hit(self, run: &Run, seed: u64) -> Vec<Vec<u64>> {
        let edges = run.truth.len();
        let of = |(recorded, twin): (&super::Recorded, Twin)| {
            let clock = recorded.header.clock_hz as f64;
            let steps = twin.load_step.iter();
            let mut turns: Vec<u64> = steps
                .flat_map(|load| [Some(load.from_s), load.until_s])
                .flatten()
                .map(|at| {
                    let starts = recorded.times.iter().step_by(edges);
                    starts.filter(|&&t| t as f64 / clock <= at).count() as u64
                })
                .collect();
            turns.dedup();
            turns
        };
        run.recordings
            .iter()
            .zip(self.twins(seed))
            .map(of)
            .collect()
    }
}

/// Drives a twin at another constant speed, with the same torques.
fn drive_at(twin: &mut Twin, r_min: f64) {
    let times = r_min * TAU / 60.0 / twin.drive.nominal_rad_s();
    twin.drive = Drive::Constant { r_min };
    if let Some(Noise::SpeedWander {
        rms_fraction,
        hold_s,
        ..
    }) = &mut twin.noise
    {
        *rms_fraction /= times;
        *hold_s = hold_s.map(|hold| hold / times);
    }
    let inertia = twin.shaft.inertia_kg_m2;
    let slow = slow_rad_s();
    twin.ripple.push(Ripple {
        order: 1.0,
        phase_rad: -0.4,
        torque_n_m: Some(inertia * UNBALANCE_SWING * slow * damping().hypot(slow)),
        speed_fraction: None,
    });
}

/// When a shaft that nothing disturbs is so many turns past its first index.
fn time_s(drive: &Drive, turns: f64) -> f64 {
    match drive {
        Drive::Ramp { .. } => {
            let start = slow_rad_s();
            let rate = (RAMP_END_R_MIN / SLOW_R_MIN - 1.0) * start / ramp_s();
            let way = (turns + RAMP_MARGIN_TURNS) * TAU;
            ((start * start + 2.0 * rate * way).sqrt() - start) / rate
        }
        other => (turns + MARGIN_TURNS) * TAU / other.nominal_rad_s(),
    }
}

/// How the verdicts on turns fit what happened to them: of so many turns, so many were rejected. Turns rejected for a change of speed
/// are apart unless they were hit: the second one of the ramp is twice as fast as the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdicts {
    /// Turns in which a load comes or goes.
    pub hit: Share,
    /// The turn after such a turn, in which a fast shaft still settles, and which the turn before can't tell the bend of.
    pub after: Share,
    /// All others that a calibration looked at.
    pub spared: Share,
}

/// How many turns there were, and how many of them were rejected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Turns.
    pub turns: u64,
    /// Of those rejected.
    pub rejected: u64,
}

impl Share {
    /// Rejected turns over all.
    #[must_use]
    pub fn part(self) -> f64 {
        self.rejected as f64 / self.turns as f64
    }
}

impl Verdicts {
    /// Adds a calibration's on a run; `hit` as of [`Disturbed::hit`].
    pub fn add(&mut self, calibration: &Calibration, hit: &[Vec<u64>]) {
        for (used, hit) in calibration.recordings.iter().zip(hit) {
            let rejected = used.rejected.listed();
            let looked_at = used.totals.turns as usize + rejected.len();
            // The first turn of a recording only sets the rate.
            for number in 2..2 + looked_at as u64 {
                let verdict = rejected.iter().find(|turn| turn.number == number);
                let is_hit = hit.contains(&number);
                let share = if is_hit {
                    &mut self.hit
                } else if hit.contains(&(number - 1)) {
                    &mut self.after
                } else {
                    &mut self.spared
                };
                let counts = |turn: &&RejectedTurn| is_hit || turn.reason != Rejection::SpeedChange;
                share.turns += 1;
                share.rejected += u64::from(verdict.filter(counts).is_some());
            }
        }
    }
}
