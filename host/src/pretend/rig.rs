//! The rig whose edges a pretend device sees.

use crate::twin::{Drive, Duration, Encoder, Errors, Noise, Per, Position, Twin};

use super::{CLOCK_HZ, Pretend};

/// The paper's rig with these lines and this speed, and errors in proportion to a line.
pub(super) fn twin(pretend: &Pretend) -> Twin {
    let line = 2500.0 / f64::from(pretend.lines.max(1));
    let mut twin = Twin::paper();
    twin.seed = pretend.seed;
    twin.duration = Duration::Seconds(1e6);
    twin.encoder = Encoder::Quadrature {
        lines: pretend.lines,
        index: true,
    };
    twin.errors = Errors {
        position: Some(Position::Uniform {
            amplitude_rad: 6.2832e-5 * line,
            per: Per::Edge,
        }),
        width_a_rad: 1.2566e-4 * line,
        width_b_rad: 1.1310e-4 * line,
        quadrature_rad: 1.2566e-4 * line,
        ..Errors::default()
    };
    twin.drive = Drive::Constant {
        r_min: pretend.r_min,
    };
    twin.ripple = Vec::new();
    twin.noise = Some(Noise::SpeedWander {
        rms_fraction: 1e-4,
        correlation_rad: Some(0.5),
        hold_s: None,
    });
    twin.timer.clock_hz = CLOCK_HZ;
    twin
}
