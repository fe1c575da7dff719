//! Jumps that a filter knows nothing of, as its innovations show them.

use std::array::from_fn;

use super::State::{Angle, Drift};
use super::{DRIFTING, Gain};
use crate::diagnose::lsq::dot;
use crate::diagnose::square::{Square, identity, through, times};

/// How innovations pull at jumps that the filter knows nothing of, of the drift and of the speed, for unit of each (P. de Jong, J. Penzer,
/// JASA 93, 1998).
#[derive(Clone, Copy, Debug, Default)]
pub struct Pull {
    /// Sum of the innovations times what each jump does to them.
    pub score: [f64; 2],
    /// Sum of products of what they do: of the drift's, of both, of the speed's.
    pub information: [f64; 3],
    /// By how much an error of the edge's stamp alone makes the sum of squares less.
    pub of_stamp: f64,
}

impl Pull {
    /// By how much the jump of the drift that fits best makes the sum of squares less, and its size.
    pub fn of_drift(&self) -> (f64, f64) {
        let ([score, _], [information, ..]) = (self.score, self.information);
        if information > 0.0 {
            (score * score / information, score / information)
        } else {
            (0.0, 0.0)
        }
    }

    /// The same of both jumps.
    pub fn of_both(&self) -> (f64, [f64; 2]) {
        let ([a, b], [aa, ab, bb]) = (self.score, self.information);
        let determinant = aa * bb - ab * ab;
        if determinant <= 1e-9 * aa * bb {
            return (0.0, [0.0; 2]);
        }
        let sizes = [
            (bb * a - ab * b) / determinant,
            (aa * b - ab * a) / determinant,
        ];
        (a * sizes[0] + b * sizes[1], sizes)
    }
}

/// How weighed innovations pull at jumps within the interval before each edge.
pub(super) fn pulls<const N: usize>(
    gains: &[Gain<N>],
    innovations: &[f64],
    weights: &[f64],
) -> Vec<Pull> {
    let mut pulls = vec![Pull::default(); gains.len()];
    if N < DRIFTING {
        return pulls;
    }
    // Of the state before each edge, from the last one back.
    let mut score = [0.0; N];
    let mut information = Square::<N>::default();
    let each = innovations.iter().zip(weights).zip(&mut pulls);
    for (((innovation, weight), pull), step) in each.zip(gains).rev() {
        let scale = step.scale * weight;
        // Later edges go by what an error of this one makes of the state.
        let of_gain = information.0.map(|row| dot(&step.gain, &row));
        let error = scale * innovation - dot(&step.gain, &score);
        let shows = scale * scale + dot(&step.gain, &of_gain);
        pull.of_stamp = if shows > 0.0 {
            error * error / shows
        } else {
            0.0
        };
        let mut after = identity::<N>();
        for (row, gain) in after.0.iter_mut().zip(&step.gain) {
            row[Angle as usize] -= gain;
        }
        let across = Square(from_fn(|row| from_fn(|column| after.0[column][row])));
        score = times(&across, &score.map(|of| [of])).map(|[of]| of);
        information = through(&across, &information);
        score[Angle as usize] += scale * innovation;
        information[(Angle, Angle)] += scale * scale;
        // In the mean of the interval's ends.
        let pushes = [Drift, step.driven].map(|state| {
            let mut push = step.way.0.map(|row| 0.5 * row[state as usize]);
            push[state as usize] += 0.5;
            push
        });
        pull.score = pushes.map(|push| dot(&push, &score));
        let [drift, speed] = pushes;
        let [of_drift, of_speed] = pushes.map(|push| information.0.map(|row| dot(&push, &row)));
        pull.information = [
            dot(&drift, &of_drift),
            dot(&speed, &of_drift),
            dot(&speed, &of_speed),
        ];
        let before = Square(from_fn(|row| from_fn(|column| step.way.0[column][row])));
        score = times(&before, &score.map(|of| [of])).map(|[of]| of);
        information = through(&before, &information);
    }
    pulls
}
