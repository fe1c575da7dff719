//! Local defects of the disc.

use std::f64::consts::TAU;

use super::Class;
use super::shift::channel_of;
use crate::twin::{Flank, Twin};

/// What all defects add to the error of an edge of this class at a grid angle, rad.
pub(super) fn error_rad(twin: &Twin, class: Class, grid_rad: f64) -> f64 {
    let (_, rises) = class.bit_and_rise();
    let flank = if rises { Flank::Rise } else { Flank::Fall };
    let hit = twin.local_defect.iter().filter(|defect| {
        (defect.channel.is_none() || defect.channel == channel_of(class))
            && defect.edge.is_none_or(|edge| edge == flank)
    });
    hit.map(|defect| {
        let way = (grid_rad - defect.angle_rad).rem_euclid(TAU);
        let widths = way.min(TAU - way) / defect.width_rad;
        // Beyond, the bump is below the smallest number.
        if widths > 39.0 {
            return 0.0;
        }
        defect.error_rad * libm::exp(-0.5 * widths * widths)
    })
    .sum()
}
