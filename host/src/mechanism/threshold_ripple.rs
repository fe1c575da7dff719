//! `threshold_ripple`: pick-up on the comparator's level.
//!
//! Mains or PWM moves the level by dL; the signal, of slope dV/dtheta, then meets it a = dL / (dV/dtheta) later where it rises and
//! earlier where it falls:
//! `e = -+ a sin(2 pi f t + phi): - on rising edges, + on falling ones`
//! Linear in cos and sin; f is searched for in the spectrum of rises against falls. Simulated in `sim/shift.rs`.
//!
//! Source: a threshold crossing moves by the level's change over the signal's slope (P. Horowitz, W. Hill, The Art of Electronics,
//! comparators).

use super::card::{ERROR_RAD, FREQUENCIES_HZ};
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::classes::{change_of, round};
use crate::diagnose::mended::{Mended, channel, wave};
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::ThresholdRipple;

/// Its card.
pub const CARD: Card = Card {
    title: "pick-up on the comparator's level",
    physics: "Mains or PWM is picked up by the comparator's level: a level that is higher is met later by a rising signal and earlier by \
              a falling one.",
    equation: "e = -+ a sin(2 pi f t + phi): - on rising edges, + on falling ones",
    source: "a threshold crossing moves by the level's change over the signal's slope (P. Horowitz, W. Hill, The Art of Electronics, \
             comparators)",
    twin: "threshold_ripple",
    parameters: &[
        Quantity::new("f_hz", "Hz", FREQUENCIES_HZ, "f, its frequency"),
        Quantity::new("angle_rad", "rad", [0.0, ERROR_RAD], "a, its amplitude"),
        Quantity::phase("phi, its phase at the recording's time 0"),
    ],
    locked_to: &[LockedTo::Frequency],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[Mechanism::TorqueTone, Mechanism::CaptureLatency],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording at another speed: the frequency stays, and rises and falls move against each other; a torque tone moves \
                   both alike.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::LevelTone { .. }),
        columns,
        values,
        text: |shows| {
            let (f_hz, edges) = (shows.f_hz(), shows.edges);
            format!("{f_hz:.4} Hz, rising against falling edges ({edges})")
        },
        mends,
        ..Handling::NONE
    },
};

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::LevelTone { f_hz, channel } = basis else {
        return Vec::new();
    };
    let turning = std::f64::consts::TAU * f_hz;
    let mut both = round(seen, |at| turning * seen.times_s[at]);
    for column in &mut both {
        for (at, value) in column.iter_mut().enumerate() {
            let change = change_of(seen.class(at), seen.classes);
            let size = match change.on(channel) {
                false => 0.0,
                true if change.rises => -1.0,
                true => 1.0,
            };
            *value *= size;
        }
    }
    both
}

fn values(numbers: &Numbers<'_>) -> Named {
    let Basis::LevelTone { f_hz, .. } = numbers.basis() else {
        return Named::new();
    };
    let at = numbers.strongest();
    vec![
        ("f_hz".to_owned(), numbers.searched(f_hz, 0)),
        ("angle_rad".to_owned(), Numbers::amplitude(at)),
        ("phase_rad".to_owned(), Numbers::phase(at)),
    ]
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    if let Basis::LevelTone { f_hz, channel: on } = basis {
        let (angle_rad, phase_rad) = wave(sizes);
        mended.twin.threshold_ripple.push(ThresholdRipple {
            f_hz,
            phase_rad,
            angle_rad,
            channel: on.map(channel),
        });
    }
}
