//! One recording with the noise that makes its residual white.

use super::column::Part;
use super::every_turn::EveryTurn;
use super::kalman::{ShaftNoise, Whitener};
use super::noise_fit::{self, Free};
use super::seen::Seen;
use super::shaft::ShaftLaw;

/// Parts of each recording that sums are kept for: the last ones are held out, and what is real is in all of them.
pub const PARTS: usize = 10;
/// Parts that parameters are fitted on when the others judge.
pub const FITTED: usize = 7;

/// Evidence, as twice a difference of logarithms of likelihood, that torque noise is held and not white, or the other way round.
const SURELY: f64 = 12.0;

/// Edges up to which the noise is fitted from two starts.
const FEW: usize = 5000;

/// One recording.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Its residual.
    pub seen: Seen,
    /// Its shaft.
    pub law: ShaftLaw,
    /// Its noise.
    pub noise: ShaftNoise,
    /// What the twin says of it.
    pub declared: Option<ShaftNoise>,
    /// Best stamp its timer can give, s.
    pub least_stamp_s: f64,
    /// Torques that the twin declares: order and N m.
    pub torques: Vec<(f64, f64)>,
    /// Whether the mean speed is the recording's own, so that a steady push says nothing.
    pub free_speed: bool,
    /// Mean speed, rad/s, either way.
    pub mean_speed: f64,
    /// Time for which torque noise would be held, s, if it were.
    hold_s: f64,
    whitener: Whitener,
    /// The residual, white.
    pub white: Vec<f64>,
}

impl Bench {
    /// With the noise that a twin declares, else one found.
    #[must_use]
    pub fn new(
        seen: Seen,
        law: ShaftLaw,
        declared: Option<ShaftNoise>,
        least_stamp_s: f64,
        free_speed: bool,
        hold_s: f64,
    ) -> Self {
        let noise = declared.unwrap_or_else(|| first_guess(&seen, &law, least_stamp_s));
        let mut bench = Self {
            mean_speed: seen.mean_speed(),
            hold_s,
            seen,
            law,
            noise,
            declared,
            least_stamp_s,
            free_speed,
            torques: Vec::new(),
            whitener: Whitener::default(),
            white: Vec::new(),
        };
        if declared.is_none() {
            bench.noise = bench.noise_at_first();
            // Ties are decided from noise that has room for them.
            if free_speed && bench.law.held() && bench.seen.ties.is_empty() {
                bench.set_noise(bench.noise);
                bench.level();
                bench.noise = bench.noise_at_first();
            }
        }
        bench.set_noise(bench.noise);
        bench
    }

    /// The noise of a residual of which nothing is explained yet: without what comes again every turn, where that is worth its numbers
    /// (G. Schwarz, Annals of Statistics 6, 1978).
    fn noise_at_first(&self) -> ShaftNoise {
        let cost = |angles: &[f64], noise, numbers: usize| {
            let likely = noise_fit::cost(&self.seen.readings, angles, noise);
            likely + numbers as f64 * (self.seen.len() as f64).ln()
        };
        let whole = self.noise_of(&self.seen.angles);
        let mut best = (cost(&self.seen.angles, whole, 0), whole);
        let Some(every) = EveryTurn::of(&self.seen) else {
            return whole;
        };
        // A mean takes its share of the noise with it: of stamps what it has numbers for, of torque noise, which is slow, all.
        let taken = every.turns / (every.turns - 1.0);
        for (angles, numbers) in every.off(&self.seen) {
            let noise = self.noise_of(&angles);
            let there = cost(&angles, noise, numbers);
            if there < best.0 {
                let more = ShaftNoise {
                    acceleration: noise.acceleration * taken,
                    stamp_s: noise.stamp_s / (1.0 - numbers as f64 / self.seen.len() as f64).sqrt(),
                    drift: noise.drift * taken,
                    ..noise
                };
                best = (there, more);
            }
        }
        best.1
    }

    /// The noise that a residual shows.
    #[must_use]
    pub fn noise_of(&self, angles: &[f64]) -> ShaftNoise {
        let free = if self.law.held() || self.seen.pushed {
            Free::Sizes
        } else {
            Free::All
        };
        let readings = &self.seen.readings;
        let from = |start| noise_fit::fit(readings, angles, self.least_stamp_s, start, free);
        let mut noise = from(self.noise);
        // A few edges may let one noise pass for another: a fit from elsewhere says which it is.
        if self.seen.len() < FEW {
            let again = from(ShaftNoise {
                stamp_s: 3.0 * self.least_stamp_s,
                acceleration: self.noise.acceleration.min(noise.acceleration),
                ..self.noise
            });
            let cost = |noise| noise_fit::cost(readings, angles, noise);
            if cost(again) < cost(noise) {
                noise = again;
            }
        }
        if self.declared.is_some() || free == Free::All || self.hold_s == 0.0 {
            return noise;
        }
        // Whether the torque is white or held shows where stamps are good against what it does within an interval.
        let interval_s = self.seen.seconds() / self.seen.len() as f64;
        let swung2 = noise.acceleration * interval_s.powi(3) / 3.0;
        if (noise.stamp_s * self.mean_speed).powi(2) > 4.0 * swung2 {
            return noise;
        }
        let other = from(ShaftNoise {
            hold_s: if noise.hold_s > 0.0 { 0.0 } else { self.hold_s },
            ..noise
        });
        let cost = |noise| noise_fit::cost(readings, angles, noise);
        if cost(other) < cost(noise) - SURELY {
            other
        } else {
            noise
        }
    }

    /// Takes another noise.
    pub fn set_noise(&mut self, noise: ShaftNoise) {
        self.noise = noise;
        self.whitener = Whitener::new(&self.seen.readings, noise);
        self.white = self.whitened(self.seen.angles.clone());
    }

    /// Keeps so many of its first edges.
    pub fn shorten(&mut self, edges: usize) {
        let seen = &mut self.seen;
        seen.places.truncate(edges);
        seen.times_s.truncate(edges);
        seen.speeds.truncate(edges);
        seen.swung.truncate(edges);
        seen.pace.truncate(edges);
        seen.run_off.truncate(edges);
        seen.level_off.truncate(edges);
        seen.angles.truncate(edges);
        seen.readings.truncate(edges);
        self.set_noise(self.noise);
    }

    /// A row of angles, white.
    #[must_use]
    pub fn whitened(&self, mut angles: Vec<f64>) -> Vec<f64> {
        self.whitener.whiten(&mut angles);
        angles
    }

    /// A pattern, white, if it shows.
    #[must_use]
    pub fn part_white(&self, part: &Option<Part>) -> Option<Part> {
        let part = part.as_ref()?;
        Some(self.whitened(part.to_vec()).into())
    }

    /// Two rows of angles, white.
    #[must_use]
    pub fn both_whitened(&self, [mut one, mut other]: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
        self.whitener.whiten_both(&mut one, &mut other);
        [one, other]
    }

    /// The transposed filter.
    pub fn transposed(&self, white: &mut [f64]) {
        self.whitener.transposed(white);
    }

    /// Its filter.
    #[must_use]
    pub const fn whitener(&self) -> &Whitener {
        &self.whitener
    }

    /// Standard deviation of the expected angle of every edge, rad.
    pub fn deviations(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.whitener.deviations()
    }

    /// Leaves nothing of a row outside of some parts.
    pub fn cut(&self, row: &mut [f64], parts: &std::ops::Range<usize>) {
        let kept = self.part(parts.start).start..self.part(parts.end - 1).end;
        row[..kept.start].fill(0.0);
        row[kept.end..].fill(0.0);
    }

    /// Edges of a part.
    #[must_use]
    pub fn part(&self, part: usize) -> std::ops::Range<usize> {
        let count = self.seen.len();
        part * count / PARTS..(part + 1) * count / PARTS
    }
}

/// A thousandth of the speed, and stamps as good as the tick.
fn first_guess(seen: &Seen, law: &ShaftLaw, least_stamp_s: f64) -> ShaftNoise {
    let speed = seen.mean_speed();
    let wander = 1e-3 * speed;
    let damping = law.damping(0.0, speed);
    let unheld = !law.held() && !seen.pushed;
    // What is left to itself between pushes forgets nothing; its noise is a first guess.
    let damping = if seen.pushed { speed } else { damping };
    ShaftNoise {
        acceleration: 2.0 * if unheld { speed } else { damping } * wander * wander,
        stamp_s: 3.0 * least_stamp_s,
        drift: if unheld {
            1e-8 * speed * speed * speed
        } else {
            0.0
        },
        forgets_per_s: if unheld { speed } else { 0.0 },
        hold_s: 0.0,
        load: law.load,
    }
}
