//! What swings: whether it is one with what a section has, and the sum of both.

use std::f64::consts::TAU;

use nalgebra::Complex;

use crate::diagnose::rig::Recorded;

/// How far a recording goes.
pub struct Span {
    /// Turns from the least place to the greatest.
    pub turns: f64,
    /// From the first edge to the last.
    pub seconds: f64,
}

impl Span {
    /// Of a recording.
    pub fn of(one: &Recorded) -> Self {
        let edges = &one.edges;
        let ends = edges.place.iter().min().zip(edges.place.iter().max());
        let places = ends.map_or(0, |(least, most)| most - least);
        let ends_s = edges.time_s.first().zip(edges.time_s.last());
        Self {
            turns: places as f64 / f64::from(edges.grid_edges.max(1)),
            seconds: ends_s.map_or(0.0, |(first, last)| last - first),
        }
    }

    /// Whether two orders part by a tenth of a cycle at the most, and so are one.
    pub fn same_order(&self, one: f64, other: f64) -> bool {
        (one - other).abs() * self.turns <= 0.1
    }

    /// The same of frequencies.
    pub fn same_frequency(&self, one: f64, other: f64) -> bool {
        (one - other).abs() * self.seconds <= 0.1
    }
}

/// Amplitude and phase of an effect's sizes, of cosine and sine, as a complex number: amplitude sin(x + phase) is cos sin(phase) and
/// sin cos(phase) of them. Nothing where it does not swing.
pub fn wave(sizes: &[f64]) -> Complex<f64> {
    match *sizes {
        [cos, sin] => Complex::new(sin, cos),
        _ => Complex::default(),
    }
}

/// Adds a wave to an amplitude and a phase.
pub fn add_to(wave: Complex<f64>, amplitude: &mut f64, phase_rad: &mut f64) {
    let sum = wave + Complex::from_polar(*amplitude, *phase_rad);
    (*amplitude, *phase_rad) = (sum.norm(), sum.arg().rem_euclid(TAU));
}

/// The section that is the same as a new one, or the new one in its place.
pub fn same_or<S>(sections: &mut Vec<S>, same: impl Fn(&S) -> bool, new: S) -> &mut S {
    let at = sections.iter().position(same).unwrap_or_else(|| {
        sections.push(new);
        sections.len() - 1
    });
    &mut sections[at]
}
