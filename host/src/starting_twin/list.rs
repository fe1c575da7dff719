//! Writes the list of the disc's errors beside a starting twin.

use std::fmt::Write as _;

use super::estimate::Starting;
use crate::diagnose::edges::Sensor;
use crate::diagnose::record;
use crate::twin::Encoder;

/// The disc's errors as `calibrate --csv` writes them, edges numbered as the twin does.
#[must_use]
pub fn errors_csv(starting: &Starting) -> Option<String> {
    let disc = starting.disc.as_ref()?;
    let encoder = &starting.found.encoder;
    let pulses = matches!(
        starting.found.sensor,
        Sensor::Wheel {
            both_edges: false,
            ..
        }
    );
    let mut text = "edge,class,error_rad,standard_error_rad\n".to_owned();
    for (edge, error) in (0_u32..).zip(&disc.errors_rad) {
        let (class, real) = if pulses {
            ("tooth", encoder.is_real(2 * edge))
        } else {
            (class_name(encoder, edge), encoder.is_real(edge))
        };
        if real {
            // Writing to a string never fails.
            let _ = writeln!(
                text,
                "{edge},{class},{error:.7e},{:.4e}",
                disc.spread.edge_rad
            );
        }
    }
    Some(text)
}

/// What changes at an edge, as an error table has it.
fn class_name(encoder: &Encoder, edge: u32) -> &'static str {
    let classes = encoder.edges_per_line();
    let change = record::change((edge % classes) as usize, classes.into());
    match (encoder, change.channel, change.rises) {
        (Encoder::Wheel { .. }, _, true) => "tooth begins",
        (Encoder::Wheel { .. }, _, false) => "tooth ends",
        (_, 0, true) => "A rises",
        (_, 0, false) => "A falls",
        (_, 1, true) => "B rises",
        (_, 1, false) => "B falls",
        (_, _, true) => "C rises",
        (_, _, false) => "C falls",
    }
}
