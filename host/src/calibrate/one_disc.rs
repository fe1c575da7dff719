//! Whether recordings are of one disc: each is solved by itself, and their line patterns are compared at high orders, where a
//! shaft's inertia leaves nothing of torque.

use quadcal::estimate::{EdgeBuffers, ORDERS_MAX, Solution};
use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

/// Orders below the edges over this are not looked at with few edges, as torque may be there; with many, below 241.
const LOWEST_OF_EDGES: usize = 8;

/// Power of an order's noise over that of its geometry at the most; noisier orders are not looked at.
const NOISE_MOST: f64 = 0.5;

/// Size of the pattern over that of the class offsets at the least: what a swing of the speed makes of the offsets (amplitude
/// modulation) lies at high orders too, and differs with the speed.
const SIZE_LEAST: f64 = 0.05;

/// Standard deviations by which chance must be ruled out either way.
const SURE: f64 = 4.0;

/// How much of two recordings' patterns is alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Likeness {
    /// Coherence found: 1 for one pattern, 0 on average for two.
    pub found: f64,
    /// Coherence that one disc would show, its noise considered.
    pub of_one_disc: f64,
    /// Standard deviation by chance, of two discs.
    pub chance: f64,
}

impl Likeness {
    /// Whether these are two discs: less alike than half of what one would be, where that is well beyond chance.
    #[must_use]
    pub fn two_discs(&self) -> bool {
        let halfway = 0.5 * self.of_one_disc;
        halfway > SURE * self.chance && self.found < halfway
    }
}

/// The line pattern of one recording.
pub struct Pattern {
    /// Of orders 0, 1, ..: the estimate before it was weighed, and its noise over its geometry; none where it is not well known.
    orders: Vec<Option<(Complex64, f64)>>,
}

impl Pattern {
    /// Of a recording solved by itself.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn of<B: EdgeBuffers>(solution: &Solution<B>) -> Self {
        let shape = solution.shape();
        let edges = shape.edges() as usize;
        let lines = edges / shape.classes() as usize;
        // Solutions differ in the shift of their entries.
        let unit = f64::from(1_u32 << solution.shift());
        let entries = solution.entries().iter();
        let mut entries: Vec<f64> = entries.map(|&entry| unit * f64::from(entry)).collect();
        let fft = RealFftPlanner::<f64>::new().plan_fft_forward(edges);
        let mut spectrum = fft.make_output_vec();
        // The lengths fit, so nothing can go wrong; zeroes would be left out.
        let _ = fft.process(&mut entries, &mut spectrum);
        let lowest = (edges / LOWEST_OF_EDGES).clamp(3, ORDERS_MAX + 1);
        let known = |(order, value): (usize, &Complex64)| {
            // Multiples of the lines are the classes' means, which delays change with speed.
            if order < lowest || order.is_multiple_of(lines) {
                return None;
            }
            let weight = f64::from(solution.order_weight(order)) / 32_768.0;
            // The core draws Wiener's weight linearly to zero at 0.3.
            let noise = 1.0 / (0.3 + 0.7 * weight) - 1.0;
            (weight > 0.0 && noise <= NOISE_MOST).then(|| (value / weight, noise))
        };
        let orders: Vec<_> = spectrum.iter().enumerate().map(known).collect();
        let powers = orders.iter().flatten().map(|(value, _)| value.norm_sqr());
        // Each order stands for its mirror image too.
        let size = (2.0 * powers.sum::<f64>()).sqrt() / edges as f64;
        if size < SIZE_LEAST * offsets_rms(solution) {
            return Self { orders: Vec::new() };
        }
        Self { orders }
    }

    /// Compares two recordings' patterns; none where they know no order both.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn likeness(&self, other: &Self) -> Option<Likeness> {
        let (mut found, mut expected, mut count) = (0.0, 0.0, 0.0_f64);
        for (one, other) in self.orders.iter().zip(&other.orders) {
            let (Some((one, noise)), Some((other, other_noise))) = (one, other) else {
                continue;
            };
            let power = one.norm_sqr() + other.norm_sqr();
            if power > 0.0 {
                // Each order by its own size, so that no single one decides.
                found += 2.0 * (one * other.conj()).re / power;
                expected += 1.0 / (1.0 + 0.5 * (noise + other_noise));
                count += 1.0;
            }
        }
        (count > 0.0).then(|| Likeness {
            found: found / count,
            of_one_disc: expected / count,
            // One order's has a variance of a third for two discs of one size, and less else.
            chance: (3.0 * count).sqrt().recip(),
        })
    }
}

/// RMS of the class offsets, 2^-32 turn.
fn offsets_rms<B: EdgeBuffers>(solution: &Solution<B>) -> f64 {
    let classes = solution.shape().classes();
    let squares = solution
        .class_offsets()
        .iter()
        .map(|o| f64::from(o.0).powi(2));
    (squares.sum::<f64>() / f64::from(classes)).sqrt()
}
