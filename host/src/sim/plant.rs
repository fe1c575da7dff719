//! The twin's torques turned into accelerations: sizes of ripple and noise, speed at the start.

use std::f64::consts::TAU;

use super::drive::{Knot, Noise};
use super::random::{Purpose, Stream};
use super::taylor::RippleTerm;
use super::tone::Tone;
use crate::twin::{self, Drive, Twin};

/// Steps of the noise grid in one correlation time, at least.
const NOISE_STEPS: f64 = 50.0;

/// Constants of the equation of motion, all divided by the inertia.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    /// Viscous friction, 1/s.
    pub viscous: f64,
    /// Viscous friction and drive stiffness, 1/s.
    pub damping: f64,
    /// Coulomb friction, rad/s^2.
    pub coulomb: f64,
    /// Nominal speed, rad/s.
    pub nominal: f64,
    /// Grid step, rad.
    pub(super) step_rad: f64,
    /// Time of one grid step at the nominal speed, s; infinite at standstill.
    pub(super) nominal_interval_s: f64,
}

impl Plant {
    /// Of a twin.
    #[must_use]
    pub fn new(twin: &Twin) -> Self {
        let shaft = &twin.shaft;
        let inertia = shaft.inertia_or_one();
        let nominal = twin.drive.nominal_rad_s();
        let viscous = shaft.viscous_n_m_s / inertia;
        let damping = match twin.noise {
            Some(twin::Noise::SpeedWander {
                correlation_rad: Some(correlation),
                ..
            }) => nominal.abs() / correlation,
            _ => viscous + shaft.stiffness_n_m_s / inertia,
        };
        let step_rad = TAU / f64::from(twin.encoder.grid_edges());
        Self {
            viscous,
            damping,
            coulomb: shaft.coulomb_n_m / inertia,
            nominal,
            step_rad,
            nominal_interval_s: step_rad / nominal.abs(),
        }
    }

    /// Everything that is torque at an order, as accelerations.
    pub(super) fn ripples(&self, twin: &Twin) -> Vec<RippleTerm> {
        let inertia = twin.shaft.inertia_or_one();
        let term = |order: f64, phase_rad: f64, torque: Option<f64>, fraction: Option<f64>| {
            let size = self.size(inertia, order * self.nominal, torque, fraction);
            RippleTerm {
                order,
                phase_rad,
                amplitude: size,
            }
        };
        let ripples = twin.ripple.iter().chain(&twin.gear_mesh);
        let bearings = twin.bearing.iter().filter(|b| b.runout_rad.is_none());
        ripples
            .map(|r| term(r.order, r.phase_rad, r.torque_n_m, r.speed_fraction))
            .chain(bearings.map(|b| term(b.order, b.phase_rad, b.torque_n_m, b.speed_fraction)))
            .collect()
    }

    /// The tones as accelerations.
    pub(super) fn tones(&self, twin: &Twin) -> Vec<Tone> {
        let inertia = twin.shaft.inertia_or_one();
        let tones = twin.torque_tone.iter().map(|tone| {
            let turning = TAU * tone.f_hz;
            Tone {
                turning,
                phase_rad: tone.phase_rad,
                amplitude: self.size(inertia, turning, tone.torque_n_m, tone.speed_fraction),
            }
        });
        tones.collect()
    }

    /// Amplitude, rad/s^2, of a torque given as such or as the relative speed swing that it makes at `turning` rad/s.
    #[must_use]
    pub fn size(
        &self,
        inertia: f64,
        turning: f64,
        torque_n_m: Option<f64>,
        speed_fraction: Option<f64>,
    ) -> f64 {
        match (torque_n_m, speed_fraction) {
            (Some(torque), _) => torque / inertia,
            (None, fraction) => {
                let impedance = (turning * turning + self.damping * self.damping).sqrt();
                fraction.unwrap_or(0.0) * self.nominal.abs() * impedance
            }
        }
    }

    /// Noise on the far side of a torsional spring, if there is any: accelerations of that side.
    pub(super) fn far_noise(&self, twin: &Twin) -> Option<Noise> {
        let resonance = twin.torsional_resonance?;
        let psd = resonance.load_psd_n2_m2_s?;
        let hold = resonance
            .load_hold_s
            .unwrap_or(1.0 / (NOISE_STEPS * resonance.f_hz));
        let inertia = twin.shaft.inertia_or_one() * resonance.inertia_share;
        let random = Stream::new(twin.seed, Purpose::LoadTorque);
        Some(Noise::new(random, (psd / hold).sqrt() / inertia, hold))
    }

    /// How long a value of the torque noise is held, s, if there is any.
    #[must_use]
    pub fn hold_s(&self, twin: &Twin) -> Option<f64> {
        Some(match twin.noise? {
            twin::Noise::White { hold_s, .. } => hold_s.unwrap_or(self.nominal_interval_s),
            twin::Noise::SpeedWander { hold_s, .. } => {
                let coarsest = 1.0 / (NOISE_STEPS * self.damping);
                hold_s.unwrap_or(self.nominal_interval_s.min(coarsest))
            }
        })
    }

    /// The torque noise, if there is any.
    pub(super) fn noise(&self, twin: &Twin) -> Option<Noise> {
        let hold = self.hold_s(twin)?;
        let sigma = match twin.noise? {
            twin::Noise::White { psd_n2_m2_s, .. } => {
                (psd_n2_m2_s / hold).sqrt() / twin.shaft.inertia_or_one()
            }
            twin::Noise::SpeedWander { rms_fraction, .. } => {
                // Held noise makes the speed an AR(1) series on the grid, with this factor from step to step. Its variance is
                // (sigma / damping)^2 (1 - factor) / (1 + factor).
                let factor = libm::exp(-self.damping * hold);
                let ratio = ((1.0 + factor) / (1.0 - factor)).sqrt();
                rms_fraction * self.nominal.abs() * self.damping * ratio
            }
        };
        let random = Stream::new(twin.seed, Purpose::Torque);
        Some(Noise::new(random, sigma, hold))
    }

    /// Speed at time 0, rad/s: the profile's, with ripple and wander as if it had run so for long. A shaft at rest starts at rest.
    pub(super) fn start_speed(&self, twin: &Twin, first: &Knot, ripples: &[RippleTerm]) -> f64 {
        let speed = self.profile_speed(twin);
        if speed == 0.0 {
            return 0.0;
        }
        let swing = ripples.iter().map(|ripple| {
            let (sin, cos) =
                libm::sincos(ripple.order * twin.shaft.initial_angle_rad + ripple.phase_rad);
            let turning = ripple.order * speed;
            let square = turning * turning + first.damping * first.damping;
            ripple.amplitude * (first.damping * sin - turning * cos) / square
        });
        speed + swing.sum::<f64>() + self.start_wander(twin)
    }

    /// The profile's speed at time 0, rad/s.
    pub(super) fn profile_speed(&self, twin: &Twin) -> f64 {
        let rad_s = |r_min: f64| r_min * (TAU / 60.0);
        match &twin.drive {
            Drive::Ramp { from_r_min, .. } => rad_s(*from_r_min),
            Drive::Steps(steps) => steps.first().map_or(0.0, |step| rad_s(step.r_min)),
            Drive::Profile(profile) => rad_s(profile.start_r_min()),
            Drive::Constant { .. }
            | Drive::RunDown { .. }
            | Drive::SpeedLoop { .. }
            | Drive::Torque(_)
            | Drive::Unknown => self.nominal,
        }
    }

    /// What a wander adds to the speed at time 0, rad/s.
    pub(super) fn start_wander(&self, twin: &Twin) -> f64 {
        match twin.noise {
            Some(twin::Noise::SpeedWander { rms_fraction, .. }) => {
                rms_fraction * self.nominal * Stream::new(twin.seed, Purpose::StartSpeed).normal()
            }
            _ => 0.0,
        }
    }
}
