//! Effects that push the shaft.

use std::f64::consts::TAU;

use super::{Carrier, Effect, Site};

impl Effect {
    /// Torque at a time, angle and speed, N m. `inside_s` lies on the same side of every sudden change as the time; `motion` is
    /// the sign of the motion that dry friction acts against.
    #[must_use]
    pub fn torque(&self, time_s: f64, inside_s: f64, theta: f64, speed: f64, motion: f64) -> f64 {
        let wave = |turns: f64| libm::sin(TAU * turns);
        match self {
            Self::TorqueRipple(o) | Self::GearMesh(o) | Self::BearingTorque(o) => {
                o.torque_n_m * libm::sin(o.order * theta + o.phase_rad)
            }
            Self::TorqueTone {
                f_hz,
                phase_rad,
                torque_n_m,
            } => torque_n_m * libm::sin(TAU * f_hz * time_s + phase_rad),
            Self::LoadStep {
                torque_n_m,
                from_s,
                until_s,
            } => {
                let there = inside_s >= *from_s && inside_s < *until_s;
                if there { *torque_n_m } else { 0.0 }
            }
            Self::Friction {
                viscous_n_m_s,
                drag_n_m_s2,
                ..
            } => {
                -viscous_n_m_s * speed
                    - drag_n_m_s2 * speed * speed.abs()
                    - motion * self.dry(speed)
            }
            Self::Chirp {
                f_hz,
                rate_hz_s,
                torque_n_m,
            } => torque_n_m * wave((f_hz + 0.5 * rate_hz_s * time_s) * time_s),
            Self::OrderChirp {
                order,
                rate_per_rad,
                torque_n_m,
            } => torque_n_m * libm::sin((order + 0.5 * rate_per_rad * theta) * theta),
            Self::ModulatedOrder {
                order,
                f_hz,
                rate_hz_s,
                torque_n_m,
            } => {
                let envelope = wave((f_hz + 0.5 * rate_hz_s * time_s) * time_s);
                torque_n_m * envelope * libm::sin(order * theta)
            }
            Self::Cell(cell) if cell.site == Site::Torque => {
                cell.value(time_s, inside_s, theta, speed)
            }
            _ => 0.0,
        }
    }

    /// Whether it changes the shaft's speed for long, and nothing else.
    #[must_use]
    pub const fn is_slow(&self) -> bool {
        match self {
            Self::Cell(cell) => {
                matches!((cell.site, cell.carrier), (Site::Torque, Carrier::Steady))
            }
            Self::Friction { .. } | Self::LoadStep { .. } | Self::SpeedDrift { .. } => true,
            _ => false,
        }
    }

    /// Dry friction at a speed, N m, without its sign.
    #[must_use]
    pub fn dry(&self, speed: f64) -> f64 {
        match self {
            Self::Friction {
                coulomb_n_m,
                stribeck_n_m,
                stribeck_rad_s,
                ..
            }
            | Self::StickSlip {
                coulomb_n_m,
                stribeck_n_m,
                stribeck_rad_s,
                ..
            } => {
                let slow = if *stribeck_n_m == 0.0 {
                    0.0
                } else {
                    libm::exp(-(speed / stribeck_rad_s) * (speed / stribeck_rad_s))
                };
                coulomb_n_m + stribeck_n_m * slow
            }
            _ => 0.0,
        }
    }

    /// Factor on the speed that the drive asks for, and its rate, 1/s.
    #[must_use]
    pub fn asked(&self, time_s: f64) -> (f64, f64) {
        match self {
            Self::SpeedDrift { fraction_per_s } => (1.0 + fraction_per_s * time_s, *fraction_per_s),
            _ => (1.0, 0.0),
        }
    }

    /// Fastest change it makes at a speed, rad/s; steps of the integrator stay well below its inverse.
    #[must_use]
    pub fn quickest(&self, speed: f64, until_s: f64) -> f64 {
        match self {
            Self::TorqueRipple(o) | Self::GearMesh(o) | Self::BearingTorque(o) => o.order * speed,
            Self::TorqueTone { f_hz, .. } | Self::TorsionalResonance { f_hz, .. } => TAU * f_hz,
            Self::Chirp {
                f_hz, rate_hz_s, ..
            } => TAU * (f_hz + rate_hz_s * until_s).max(*f_hz),
            Self::OrderChirp {
                order,
                rate_per_rad,
                ..
            } => (order + rate_per_rad * speed * until_s).max(*order) * speed,
            Self::ModulatedOrder {
                order,
                f_hz,
                rate_hz_s,
                ..
            } => order * speed + TAU * (f_hz + rate_hz_s * until_s).max(*f_hz),
            Self::Cell(cell) if cell.site == Site::Torque => cell.quickest(speed, until_s),
            _ => 0.0,
        }
    }

    /// Times at which it changes suddenly, s.
    #[must_use]
    pub fn sudden(&self, jumps: &[f64]) -> Vec<f64> {
        match self {
            Self::LoadStep {
                from_s, until_s, ..
            } => vec![*from_s, *until_s],
            Self::IndexSlip { at_s, .. } => vec![*at_s],
            Self::ThresholdDrift { from_s, .. } => vec![*from_s],
            Self::Telegraph { .. } => jumps.to_vec(),
            Self::Cell(cell) => cell.switches_s.clone(),
            _ => Vec::new(),
        }
    }
}
