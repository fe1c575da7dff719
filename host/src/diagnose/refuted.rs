//! Findings that turns held out, or the mended twin, speak against.
//!
//! A finding that explains what it was fitted on and makes the fit worse elsewhere only resembles what is missing: it has no name.

use super::conclude::{Conclusion, Nameless};
use super::diagnosis::{Band, Fit};
use super::settle::Settled;
use crate::mechanism::Mechanism;

/// RMS on held-out turns with a finding over that without it, from which on they speak against it: what is right makes it smaller.
const WORSE: f64 = 1.2;
/// RMS that a mended twin leaves over that of the given one, and over the noise, from which on it goes another way.
const ASTRAY: f64 = 1.5;
const NOISE: f64 = 2.0;

/// The conclusion without what is refuted; none where nothing is.
#[must_use]
pub fn without(settled: &Settled) -> Option<Conclusion> {
    let mut concluded = settled.concluded.clone();
    let worse = |ratio: &Option<f64>| ratio.is_some_and(|ratio| ratio > WORSE);
    let worst: Vec<bool> = settled.held.named.iter().map(worse).collect();
    let of_disc = settled.pattern.as_ref().map_or(0.0, |one| one.score);
    let disc = concluded.pattern && worse(&settled.held.disc);
    if worst.contains(&true) || disc {
        let text = |name| format!("like {name}, but on turns held out the fit is worse with it");
        let mut squares = 0.0;
        let mut like = disc.then_some(Mechanism::LineError);
        for (name, worse) in concluded.named.iter().zip(&worst) {
            if *worse {
                squares += name.score;
                like = like.or(Some(name.hypothesis.mechanism));
            }
        }
        let mut gone = worst.iter();
        concluded
            .named
            .retain(|_| !gone.next().is_some_and(|gone| *gone));
        if disc {
            concluded.pattern = false;
            squares += of_disc;
        }
        put_nameless(&mut concluded, text(like?), squares);
        return Some(concluded);
    }
    let named = concluded
        .named
        .first()
        .map(|name| name.hypothesis.mechanism);
    let like = named.or_else(|| concluded.pattern.then_some(Mechanism::LineError))?;
    if !astray(&settled.fit) {
        return None;
    }
    let mut squares: f64 = concluded.named.iter().map(|name| name.score).sum();
    if concluded.pattern {
        squares += of_disc;
    }
    concluded.named.clear();
    concluded.pattern = false;
    let text = format!("like {like}, but a twin that has it goes another way than the recording");
    put_nameless(&mut concluded, text, squares);
    Some(concluded)
}

fn put_nameless(concluded: &mut Conclusion, text: String, squares: f64) {
    match &mut concluded.nameless {
        Some(known) => known.squares += squares,
        None => {
            concluded.nameless = Some(Nameless {
                text,
                squares,
                p_value: (-0.5 * squares).exp(),
                orders: Vec::new(),
                frequencies_hz: Vec::new(),
            });
        }
    }
}

/// Whether the mended twin leaves more than the given one did.
fn astray(fit: &Fit) -> bool {
    let fast = Band {
        rms_before_rad: fit.rms_before_rad,
        rms_after_rad: fit.rms_after_rad,
        floor_rad: fit.floor_rad,
    };
    [fast, fit.slow, fit.edge_to_edge].iter().any(|band| {
        let all = (band.rms_before_rad, band.rms_after_rad, band.floor_rad);
        let (Some(before), Some(after), Some(floor)) = all else {
            return false;
        };
        after > ASTRAY * before && after > NOISE * floor
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(fast: [f64; 3], slow: [f64; 3]) -> Fit {
        let band = |[before, after, floor]: [f64; 3]| Band {
            rms_before_rad: Some(before),
            rms_after_rad: Some(after),
            floor_rad: Some(floor),
        };
        let fast = band(fast);
        Fit {
            rms_before_rad: fast.rms_before_rad,
            rms_after_rad: fast.rms_after_rad,
            floor_rad: fast.floor_rad,
            slow: band(slow),
            ..Fit::default()
        }
    }

    #[test]
    fn a_mended_twin_that_fits_worse_than_noise_allows_goes_astray() {
        assert!(astray(&fit([4e-6, 3e-4, 2e-6], [1.0, 0.1, 0.1])));
        assert!(astray(&fit([4e-6, 2e-6, 2e-6], [1e-3, 0.09, 1e-4])));
        // What is no more than noise is nothing, and what fits better is none of it.
        assert!(!astray(&fit([1e-6, 1.9e-6, 1e-6], [1.0, 0.1, 0.1])));
        assert!(!astray(&fit([4e-6, 2e-6, 1e-9], [1.0, 0.5, 1e-6])));
    }
}
