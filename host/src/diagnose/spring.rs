//! A share of the inertia behind a spring, as the shaft's law has it.
//!
//! Near side, with encoder and drive, and far side move together by y0 and swing against each other. With the share s of the inertia J
//! far, r = s / (1 - s), accelerations f = near torque / J and g = far torque / J, and friction b on the near side, the near side's angle
//! y and its part q of the swing go by
//! `y'' = (1 + r) (f - b y') - W q - d q',  q'' = r (f - b y') - g - W q - d q' ,  W = (2 pi f0)^2, d = 2 zeta (2 pi f0)`,
//! plus, in y'', no g: what pushes the far side comes through the spring (J. P. Den Hartog, Mechanical Vibrations, 1956, ch. 3).

use std::f64::consts::TAU;

use super::shaft::State;
use crate::twin::TorsionalResonance;

/// Terms of a series at the most, and the phase of the swing, rad, that a part of a step may take.
const TERMS: usize = 24;
const PHASE: f64 = 0.5;
/// Size of a term that is the last.
const SMALL: f64 = 1e-14;
/// Parts of a step, and doublings, at the most.
const PARTS_MOST: f64 = 1e4;
const DOUBLINGS: f64 = 200.0;

/// A spring and what is behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Square of the free frequency, 1/s^2.
    pub square: f64,
    /// Damping of the swing, 1/s.
    pub damping: f64,
    /// Inertia of the far side over that of the near one.
    pub ratio: f64,
}

impl Spring {
    /// Of a twin's mode.
    #[must_use]
    pub fn of(mode: &TorsionalResonance) -> Self {
        let free = TAU * mode.f_hz;
        Self {
            square: free * free,
            damping: 2.0 * mode.damping_ratio * free,
            ratio: mode.inertia_share / (1.0 - mode.inertia_share),
        }
    }

    /// Fastest rate at which a shaft with this friction changes, 1/s.
    #[must_use]
    pub fn fastest(&self, damping: f64) -> f64 {
        self.square.sqrt() + self.damping + (1.0 + self.ratio) * damping.abs()
    }

    /// A part of a time over which a series is short, and how often it doubles to the whole.
    #[must_use]
    pub fn part(&self, after_s: f64, damping: f64) -> (f64, i32) {
        let phase = self.fastest(damping) * after_s;
        let doublings = (phase / PHASE).log2().ceil().clamp(0.0, DOUBLINGS);
        (after_s / doublings.exp2(), doublings as i32)
    }

    /// How fast a state changes, pushed near by so much, rad/s^2.
    #[must_use]
    #[inline]
    pub fn slope(&self, damping: f64, [_, v, q, u]: State, push: f64) -> State {
        let near = push - damping * v;
        let swing = -self.square * q - self.damping * u;
        [
            v,
            (1.0 + self.ratio) * near + swing,
            u,
            self.ratio * near + swing,
        ]
    }

    /// State after a push given at start, middle and end, as a parabola has it, rad/s^2.
    #[must_use]
    pub fn step(&self, after_s: f64, damping: f64, mut state: State, push: [f64; 3]) -> State {
        let parts = self.fastest(damping) * after_s / PHASE;
        let parts = parts.ceil().clamp(1.0, PARTS_MOST);
        let [first, middle, last] = push;
        // The push over the whole time x from 0 to 1: first + linear x + square x^2.
        let square = 2.0 * (first - 2.0 * middle + last);
        let linear = last - first - square;
        for part in 0..parts as usize {
            let from = part as f64 / parts;
            let here = [
                first + from * (linear + from * square),
                (linear + 2.0 * from * square) / parts,
                square / (parts * parts),
            ];
            state = self.series(after_s / parts, damping, state, here);
        }
        state
    }

    /// State after a short time in which the push is this polynomial in the share of it, rad/s^2: Taylor's series.
    #[must_use]
    pub fn series(&self, after_s: f64, damping: f64, mut state: State, push: [f64; 3]) -> State {
        let mut term = state;
        let phase = self.fastest(damping) * after_s;
        let mut size = 1.0;
        for k in 0..TERMS {
            let push = if k < 3 { push[k] } else { 0.0 };
            // The k-th derivative of x^k is k!, which the terms before have divided by.
            let over = 1.0 / (k as f64 + 1.0);
            let slope = self.slope(damping, term, push);
            for at in 0..4 {
                term[at] = slope[at] * after_s * over;
                state[at] += term[at];
            }
            size *= phase * over;
            if k > 2 && size < SMALL {
                break;
            }
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::noise::TwoMass;
    use crate::diagnose::shaft::{AT_REST, Leap};

    const SHARE: f64 = 0.3;
    const MODE: TorsionalResonance = TorsionalResonance {
        f_hz: 40.0,
        damping_ratio: 0.05,
        inertia_share: SHARE,
        load_psd_n2_m2_s: None,
        load_hold_s: None,
    };

    /// Swing of the angle by sin(w t), once the start is forgotten, over that of a stiff shaft.
    #[test]
    fn a_push_swings_it_as_two_masses_do() {
        let masses = TwoMass {
            f_hz: MODE.f_hz,
            damping_ratio: MODE.damping_ratio,
            inertia_share: SHARE,
            load: 0.0,
        };
        for f_hz in [7.0, 33.0, 40.0, 95.0] {
            let w = TAU * f_hz;
            // Steps of a tenth of a period: parts of a step follow the swing.
            let leap = Leap {
                after_s: 0.1 / f_hz,
                damping: 30.0,
                spring: Some(Spring::of(&MODE)),
            };
            let mut state = AT_REST;
            let (mut sin, mut cos, mut count) = (0.0, 0.0, 0.0);
            for i in 0..20_000 {
                let at = |share: f64| (w * leap.after_s * (f64::from(i) + share)).sin();
                state = leap.step(state, [at(0.0), at(0.5), at(1.0)]);
                if i > 10_000 && i <= 20_000 {
                    let phase = w * leap.after_s * (f64::from(i) + 1.0);
                    sin += state[1] * phase.sin();
                    cos += state[1] * phase.cos();
                    count += 0.5;
                }
            }
            let swing = sin.hypot(cos) / count;
            let stiff = 1.0 / w.hypot(30.0);
            let expected = masses.gain(f_hz, 30.0).sqrt() * stiff;
            assert!(
                (swing / expected - 1.0).abs() < 2e-3,
                "{f_hz} Hz: {swing} {expected}"
            );
        }
    }
}
