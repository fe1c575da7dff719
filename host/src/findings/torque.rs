//! Torque ripple as the shaft feels it.

use std::f64::consts::TAU;

use quadcal::units::RAD_PER_TURN32;

use crate::calibrate::Calibration;

/// Torque locked to the shaft at one order, see [`quadcal::estimate::TorqueOrder`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torque {
    /// Cycles a turn.
    pub order: u16,
    /// Peak swing of the shaft's angle in the slowest turn learned from, rad.
    pub angle_rad: f64,
    /// Its standard error, rad.
    pub angle_standard_error_rad: f64,
    /// Peak angular acceleration, rad/s^2, the same at every speed: the torque over the inertia.
    pub acceleration_rad_s2: f64,
    /// Its standard error, rad/s^2.
    pub acceleration_standard_error_rad_s2: f64,
}

impl Torque {
    /// Peak swing of the speed in the slowest turn, as a share of it.
    #[must_use]
    pub fn speed_share(&self) -> f64 {
        f64::from(self.order) * self.angle_rad
    }

    /// Peak torque and its standard error, N m, on a shaft of `inertia_kg_m2`.
    #[must_use]
    pub fn torque_n_m(&self, inertia_kg_m2: f64) -> [f64; 2] {
        [
            self.acceleration_rad_s2,
            self.acceleration_standard_error_rad_s2,
        ]
        .map(|acceleration| inertia_kg_m2 * acceleration)
    }
}

/// The torque that a calibration told from geometry, the largest swing of the angle first.
#[allow(clippy::cast_precision_loss)]
pub(super) fn torques(calibration: &Calibration) -> Vec<Torque> {
    let solution = &calibration.solution;
    let reference = solution.reference_duration().max(1) as f64;
    let omega = TAU * calibration.clock_hz as f64 / reference;
    // The angle falls with the square of the speed.
    let slowest = (calibration.totals.longest as f64 / reference).powi(2);
    let mut torques: Vec<Torque> = solution
        .torque_orders()
        .iter()
        .map(|found| {
            let angle = f64::from(found.amplitude) * RAD_PER_TURN32;
            let error = f64::from(found.standard_error) * RAD_PER_TURN32;
            let square = (f64::from(found.order) * omega).powi(2);
            Torque {
                order: found.order,
                angle_rad: angle * slowest,
                angle_standard_error_rad: error * slowest,
                acceleration_rad_s2: angle * square,
                acceleration_standard_error_rad_s2: error * square,
            }
        })
        .collect();
    torques.sort_by(|one, other| other.angle_rad.total_cmp(&one.angle_rad));
    torques
}
