//! Curves of a diagnosis as the report draws them.

use crate::diagnose::shown::Line;
use crate::report::plot::{Axis, Series};

/// Lines of fewer points are drawn as points.
const FEW: usize = 64;

/// The units that a curve's label may end in, each as the axis takes it and what it is worth there.
const UNITS: [(&str, &str, f64); 6] = [
    ("degrees", "deg", 1.0),
    ("urad", "rad", 1e-6),
    ("rad", "rad", 1.0),
    ("us", "s", 1e-6),
    ("s", "s", 1.0),
    ("Hz", "Hz", 1.0),
];

/// The unit at the end of "angle of the disc, degrees".
fn unit(label: &str) -> Option<(&str, &'static str, f64)> {
    let (what, unit) = label.rsplit_once(", ")?;
    let known = UNITS.iter().find(|(name, ..)| *name == unit)?;
    Some((what, known.1, known.2))
}

/// An axis with the label's unit.
pub(super) fn axis_of(label: &str) -> Axis {
    let (what, unit) = unit(label).map_or((label, ""), |(what, unit, _)| (what, unit));
    let mut letters = what.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    Axis::new(first.unwrap_or_default() + letters.as_str(), unit)
}

/// What a number of the label's unit is worth on the axis.
pub(super) fn unit_factor(label: &str) -> f64 {
    unit(label).map_or(1.0, |(.., factor)| factor)
}

/// x and y apart, each in its axis' unit.
pub(super) fn columns(line: &Line, scale: [f64; 2]) -> [Vec<f64>; 2] {
    let (x, y) = line
        .iter()
        .map(|(x, y)| (scale[0] * x, scale[1] * y))
        .unzip();
    [x, y]
}

/// A line, or points where there are few.
pub(super) fn series(name: &str, line: &Line, scale: [f64; 2]) -> Series {
    let [x, y] = columns(line, scale);
    if line.len() < FEW {
        Series::points(name, &x, &y)
    } else {
        Series::line(name, &x, &y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_says_its_unit() {
        assert_eq!(
            axis_of("angle of the disc, degrees"),
            Axis::new("Angle of the disc", "deg")
        );
        assert_eq!(axis_of("residual, urad"), Axis::new("Residual", "rad"));
        assert_eq!(unit_factor("residual, urad"), 1e-6);
        assert_eq!(axis_of("cycles a turn"), Axis::new("Cycles a turn", ""));
        assert_eq!(axis_of("order, or so"), Axis::new("Order, or so", ""));
    }
}
