//! What a calibration found, in radians and with the names an engineer uses.

mod delays;
mod speed_loop;
mod torque;

use quadcal::estimate::ORDERS_MAX;
use quadcal::units::RAD_PER_TURN32;

pub use delays::{Delay, DelayFindings};
pub use speed_loop::LoopSuspicion;
pub use torque::Torque;

use crate::calibrate::Calibration;
use crate::sensor::SensorKind;

/// A number with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Short name for files: `xi_a`.
    pub id: &'static str,
    /// Name for people.
    pub name: &'static str,
    /// Value, rad.
    pub rad: f64,
    /// Standard error, rad; NaN where it is not known.
    pub standard_error_rad: f64,
}

/// An order that the table leaves alone, see [`quadcal::estimate::LockedOrder`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftAlone {
    /// Cycles a turn.
    pub order: u16,
    /// Peak size in angle, rad.
    pub amplitude_rad: f64,
}

/// A solved calibration as numbers in radians.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Names of the edge classes, edge 0 first.
    pub class_names: &'static [&'static str],
    /// Mean error of every class, rad; they sum to zero.
    pub class_offsets_rad: Vec<f64>,
    /// Standard error of a class offset, rad; NaN with fewer than 64 edges a turn, where it is not known.
    pub class_standard_error_rad: f64,
    /// xi_A, xi_B and p of a quadrature encoder; what stands in their place for other sensors.
    pub parameters: Vec<Parameter>,
    /// Whole error of every edge, class offset included, rad.
    pub error_rad: Vec<f64>,
    /// Line position error eps of every edge, rad.
    pub eps_rad: Vec<f64>,
    /// RMS error to expect without the table, rad.
    pub before_rad: f64,
    /// RMS error to expect with the table, which is also the standard error of one edge's error, rad.
    pub after_rad: f64,
    /// Weight 0..=1 of orders 1, 2, ..: how far each is believed. Orders past the end are weighed like the last.
    pub weights: Vec<f64>,
    /// Orders that one speed can't decide.
    pub left_alone: Vec<LeftAlone>,
    /// Torque locked to the shaft, where the speeds differ enough to tell it; the largest swing of the angle first.
    pub torques: Vec<Torque>,
    /// How late edges of each class are captured.
    pub delays: DelayFindings,
    /// Orders that look as if a speed loop had run; none where one was undone.
    pub loop_suspicion: Option<LoopSuspicion>,
}

impl Findings {
    /// Of a calibration.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn of(calibration: &Calibration) -> Self {
        let (solution, kind) = (&calibration.solution, calibration.plan.kind);
        let classes = kind.classes() as usize;
        let class_offsets_rad: Vec<f64> = (0..classes)
            .map(|class| f64::from(solution.class_offset(class).0) * RAD_PER_TURN32)
            .collect();
        let eps_rad: Vec<f64> = solution
            .entries()
            .iter()
            .map(|&entry| (i64::from(entry) << solution.shift()) as f64 * RAD_PER_TURN32)
            .collect();
        let error_rad = eps_rad
            .iter()
            .zip(class_offsets_rad.iter().cycle())
            .map(|(eps, offset)| eps + offset)
            .collect();
        // The core takes it from orders that are like their neighbours, and few edges have none.
        let class_standard_error_rad = if eps_rad.len() < 64 {
            f64::NAN
        } else {
            f64::from(solution.class_standard_error()) * RAD_PER_TURN32
        };
        let after_rad = calibration.standard_error_rad();
        let orders = (eps_rad.len() / 2).min(ORDERS_MAX + 1);
        let lines = eps_rad.len() / classes.max(1);
        let suspect = || LoopSuspicion::of(&order_amplitudes(&eps_rad), ORDERS_MAX, lines);
        let loop_suspicion = if calibration.loops_undone {
            None
        } else {
            suspect()
        };
        Self {
            class_names: class_names(kind),
            parameters: parameters(kind, &class_offsets_rad, class_standard_error_rad),
            class_offsets_rad,
            class_standard_error_rad,
            error_rad,
            eps_rad,
            before_rad: f64::from(solution.uncorrected_rms()) * RAD_PER_TURN32,
            after_rad,
            weights: (1..=orders)
                .map(|order| f64::from(solution.order_weight(order)) / 32_768.0)
                .collect(),
            left_alone: solution
                .locked_orders()
                .iter()
                .map(|locked| LeftAlone {
                    order: locked.order,
                    amplitude_rad: f64::from(locked.amplitude) * RAD_PER_TURN32,
                })
                .collect(),
            torques: torque::torques(calibration),
            delays: DelayFindings::of(calibration),
            loop_suspicion,
        }
    }

    /// RMS of the line position error eps, rad.
    #[must_use]
    pub fn eps_rms_rad(&self) -> f64 {
        rms(&self.eps_rad)
    }
}

/// Names of a sensor's edge classes, edge 0 first.
#[must_use]
pub const fn class_names(kind: SensorKind) -> &'static [&'static str] {
    match kind {
        SensorKind::Quadrature { .. } => &["A rises", "B rises", "A falls", "B falls"],
        SensorKind::Hall => &[
            "A falls", "B rises", "C falls", "A rises", "B falls", "C rises",
        ],
        SensorKind::Wheel {
            both_edges: true, ..
        } => &["tooth begins", "tooth ends"],
        SensorKind::Wheel { .. } => &["tooth"],
    }
}

/// Differences of class means that have a name of their own. `offsets` are all with one standard error, and sum to zero.
#[must_use]
pub fn parameters(kind: SensorKind, offsets: &[f64], standard_error: f64) -> Vec<Parameter> {
    // Offsets less their mean, so the difference of two has the variance of two free means.
    let classes = f64::from(kind.classes());
    let free = standard_error * (classes / (classes - 1.0).max(1.0)).sqrt();
    let difference = |id, name, plus: &[usize], minus: &[usize]| {
        let (rad, errors) = contrast(offsets, plus, minus);
        Parameter {
            id,
            name,
            rad,
            standard_error_rad: free * errors,
        }
    };
    match kind {
        SensorKind::Quadrature { .. } => vec![
            difference("xi_a", "Signal width error xi_A", &[2], &[0]),
            difference("xi_b", "Signal width error xi_B", &[3], &[1]),
            difference("p", "Quadrature error p", &[1], &[0]),
        ],
        SensorKind::Hall => vec![
            difference("width_a", "Width of A", &[0], &[3]),
            difference("width_b", "Width of B", &[4], &[1]),
            difference("width_c", "Width of C", &[2], &[5]),
            difference("shift_b", "Shift of B against A", &[1, 4], &[0, 3]),
            difference("shift_c", "Shift of C against A", &[2, 5], &[0, 3]),
        ],
        SensorKind::Wheel {
            both_edges: true, ..
        } => vec![difference("width", "Tooth width error", &[1], &[0])],
        SensorKind::Wheel { .. } => Vec::new(),
    }
}

/// Mean of the classes in `plus` less that of those in `minus`, and its standard error in those of one class.
#[allow(clippy::cast_precision_loss)]
fn contrast(of_class: &[f64], plus: &[usize], minus: &[usize]) -> (f64, f64) {
    let mean = |which: &[usize]| -> f64 {
        which.iter().map(|&class| of_class[class]).sum::<f64>() / which.len() as f64
    };
    let variance = 1.0 / plus.len() as f64 + 1.0 / minus.len() as f64;
    (mean(plus) - mean(minus), variance.sqrt())
}

/// Class means of a list of edge errors, less their own mean: the unique form in which estimate and truth can be compared.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn class_means(error_rad: &[f64], classes: usize) -> Vec<f64> {
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0.0_f64), |(sum, count), e| (sum + e, count + 1.0));
        sum / count.max(1.0)
    };
    let middle = mean(&mut error_rad.iter().copied());
    (0..classes)
        .map(|class| mean(&mut error_rad.iter().skip(class).step_by(classes).copied()) - middle)
        .collect()
}

/// Root mean square.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// RMS of `values - other` with the mean taken out: the angle's zero is nobody's to know.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn distance(values: &[f64], other: &[f64]) -> f64 {
    let mut rest: Vec<f64> = values.iter().zip(other).map(|(a, b)| a - b).collect();
    let mean = rest.iter().sum::<f64>() / rest.len().max(1) as f64;
    rest.iter_mut().for_each(|v| *v -= mean);
    rms(&rest)
}

/// Peak amplitude of orders 1, 2, .. up to half the edges.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn order_amplitudes(error_rad: &[f64]) -> Vec<f64> {
    let edges = error_rad.len();
    let fft = realfft::RealFftPlanner::<f64>::new().plan_fft_forward(edges);
    let (mut input, mut output) = (error_rad.to_vec(), fft.make_output_vec());
    // The buffers are the plan's own length, so nothing can fail.
    if fft.process(&mut input, &mut output).is_err() {
        return Vec::new();
    }
    let scale = |order: usize| if 2 * order == edges { 1.0 } else { 2.0 };
    output
        .iter()
        .enumerate()
        .skip(1)
        .map(|(order, value)| scale(order) * value.norm() / edges as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_are_peaks_by_order() {
        let wave = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / 64.0;
            3e-5 * (2.0 * angle + 0.3).cos() + 1e-5 * if k.is_multiple_of(2) { 1.0 } else { -1.0 }
        };
        let found = order_amplitudes(&(0..64).map(wave).collect::<Vec<_>>());
        assert_eq!(found.len(), 32);
        assert!((found[1] - 3e-5).abs() < 1e-15 && (found[31] - 1e-5).abs() < 1e-15);
        assert!(found[0] < 1e-15);
    }

    #[test]
    fn class_differences_are_named_in_unique_form() {
        let offsets = class_means(&[0.0, 3.0, 1.0, 5.0, 0.0, 3.0, 1.0, 5.0], 4);
        assert_eq!(offsets, [-2.25, 0.75, -1.25, 2.75]);
        let found = parameters(SensorKind::Quadrature { index_state: None }, &offsets, 0.3);
        assert_eq!([1.0, 2.0, 3.0], [found[0].rad, found[1].rad, found[2].rad]);
        // Variance of an offset is 3/4 of a free mean's; a difference has two of those.
        let expected = 0.3 * (8.0_f64 / 3.0).sqrt();
        assert!((found[0].standard_error_rad - expected).abs() < 1e-15);
        let hall = parameters(SensorKind::Hall, &[4.0, 1.0, 0.0, 0.0, 3.0, 0.0], 0.1);
        let value = |id| hall.iter().find(|p| p.id == id).map(|p| p.rad);
        assert_eq!(value("width_a"), Some(4.0));
        assert_eq!(value("width_b"), Some(2.0));
        assert_eq!(value("shift_b"), Some(0.0));
    }
}
