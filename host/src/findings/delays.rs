//! Delays of the edge classes against each other: rise against fall, channel against channel.

use crate::calibrate::Calibration;
use crate::sensor::SensorKind;

use super::contrast;

/// How much later one kind of edge is captured than another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Short name for files: `edge_delay_a`.
    pub id: &'static str,
    /// Name for people.
    pub name: &'static str,
    /// Value, s.
    pub seconds: f64,
    /// Standard error, s.
    pub standard_error_s: f64,
}

/// What a calibration knows of delays.
#[derive(Clone, Debug, PartialEq)]
pub enum DelayFindings {
    /// The sensor has one class of edges: there is nothing to be late against.
    OneClass,
    /// The speeds were too alike to tell a delay from an error in angle.
    SpeedsAlike,
    /// None stands out.
    None,
    /// Found, and taken out of the class offsets.
    Found(Vec<Delay>),
}

impl DelayFindings {
    /// Of a calibration.
    pub(super) fn of(calibration: &Calibration) -> Self {
        let (kind, clock_hz) = (calibration.plan.kind, calibration.clock_hz);
        let classes = kind.classes() as usize;
        match calibration.solution.class_delays() {
            _ if classes < 2 => Self::OneClass,
            None if calibration.two_speeds() => Self::None,
            None => Self::SpeedsAlike,
            Some(found) => {
                #[allow(clippy::cast_precision_loss)]
                let tick = 1.0 / (256.0 * clock_hz.max(1) as f64);
                let seconds: Vec<f64> = found.of_class[..classes]
                    .iter()
                    .map(|delay| f64::from(delay.0) * tick)
                    .collect();
                Self::Found(delays(
                    kind,
                    &seconds,
                    f64::from(found.standard_error) * tick,
                ))
            }
        }
    }

    /// The delays found.
    #[must_use]
    pub fn found(&self) -> &[Delay] {
        match self {
            Self::Found(delays) => delays,
            _ => &[],
        }
    }
}

/// Differences of class delays `seconds` that have a name; `error` is the standard error of one class.
fn delays(kind: SensorKind, seconds: &[f64], error: f64) -> Vec<Delay> {
    let difference = |id, name, late: &[usize], early: &[usize]| {
        let (seconds, errors) = contrast(seconds, late, early);
        Delay {
            id,
            name,
            seconds,
            standard_error_s: error * errors,
        }
    };
    match kind {
        SensorKind::Quadrature { .. } => vec![
            difference("edge_delay_a", "Delay of A, fall less rise", &[2], &[0]),
            difference("edge_delay_b", "Delay of B, fall less rise", &[3], &[1]),
            difference("channel_skew", "Channel skew, B less A", &[1, 3], &[0, 2]),
        ],
        SensorKind::Hall => vec![
            difference("edge_delay_a", "Delay of A, fall less rise", &[0], &[3]),
            difference("edge_delay_b", "Delay of B, fall less rise", &[4], &[1]),
            difference("edge_delay_c", "Delay of C, fall less rise", &[2], &[5]),
            difference("channel_skew_b", "Channel skew, B less A", &[1, 4], &[0, 3]),
            difference("channel_skew_c", "Channel skew, C less A", &[2, 5], &[0, 3]),
        ],
        SensorKind::Wheel { .. } => vec![difference(
            "edge_delay",
            "Delay, tooth's end less its start",
            &[1],
            &[0],
        )],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_named_by_edge_and_channel() {
        let quadrature = SensorKind::Quadrature { index_state: None };
        let found = delays(quadrature, &[-3e-9, 1e-9, -1e-9, 3e-9], 1e-10);
        let expected = [
            ("edge_delay_a", 2.0),
            ("edge_delay_b", 2.0),
            ("channel_skew", 4.0),
        ];
        for (delay, (id, nanoseconds)) in found.iter().zip(expected) {
            assert_eq!(delay.id, id);
            assert!(
                (delay.seconds * 1e9 - nanoseconds).abs() < 1e-9,
                "{delay:?}"
            );
        }
        assert!((found[0].standard_error_s - 2_f64.sqrt() * 1e-10).abs() < 1e-20);
        assert!((found[2].standard_error_s - 1e-10).abs() < 1e-20);
    }
}
