//! What was compared, in words: turns, or slips of a shaft that sticks.

use super::words::probability;
use crate::diagnose::diagnosis::Fit;

/// Whether edges were compared slip by slip, as of a shaft that sticks and slips.
#[must_use]
pub const fn by_slips(fit: &Fit) -> bool {
    fit.edge_to_edge.rms_before_rad.is_none()
}

/// What the residual is of.
#[must_use]
pub const fn residual(fit: &Fit) -> &'static str {
    match by_slips(fit) {
        true => "Residual within slips, RMS",
        false => "Residual, RMS",
    }
}

/// What findings are judged on.
#[must_use]
pub const fn judged_on(fit: &Fit) -> &'static str {
    match by_slips(fit) {
        true => "slips",
        false => "turns",
    }
}

/// What the residual along a recording is.
#[must_use]
pub const fn what_is_left(fit: &Fit) -> &'static str {
    match by_slips(fit) {
        true => {
            "How far the edges of each slip stand away from the twin's course, the slip's own instant and place taken off: the twin as \
             given goes on steadily."
        }
        false => {
            "How far each edge comes from where the twin and the edges before it let it expect."
        }
    }
}

/// Probability that what is left is noise, before and after, each with its word.
#[must_use]
pub fn is_noise(fit: &Fit, found: bool, names: [&str; 2]) -> Option<String> {
    let before = probability(fit.whiteness_p_before?);
    if !found {
        return Some(before);
    }
    let after = probability(fit.whiteness_p?);
    Some(format!("{before} {}, {after} {}", names[0], names[1]))
}
