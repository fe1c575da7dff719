//! Where in a white residual something repeats: rhythms along the turn and along time, of all edges or of edges against each other.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::basis::{change_of, channels};
use super::board::Bench;
use super::spectrum::Spectrum;

/// Which edges a rhythm is looked for in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Among {
    /// All alike.
    All,
    /// Rises against falls of all channels.
    Level,
    /// Rises against falls of one channel.
    LevelOf(usize),
    /// A channel against the others.
    Channel(usize),
}

/// What a rhythm goes along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// The turn.
    Turn,
    /// Time.
    Time,
}

/// A rhythm that stands out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Recording.
    pub bench: usize,
    /// Its edges.
    pub among: Among,
    /// What it goes along.
    pub along: Along,
    /// Cycles a turn.
    pub order: f64,
    /// Hz; at the mean speed where it goes along the turn.
    pub f_hz: f64,
    /// Its power, 1 is noise.
    pub power: f64,
    /// Power that noise reaches with the probability asked for.
    pub threshold: f64,
    /// Half the distance at which two orders are told apart.
    pub within: f64,
}

impl Among {
    /// All that a sensor with so many classes has.
    #[must_use]
    pub fn all(classes: i64) -> Vec<Self> {
        let channels = channels(classes);
        let mut all = vec![Self::All];
        if classes > 1 {
            all.push(Self::Level);
        }
        if channels > 1 {
            all.extend((0..channels).map(Self::LevelOf));
            all.extend((1..channels).map(Self::Channel));
        }
        all
    }

    /// Weight of a class.
    #[must_use]
    pub fn weight(self, class: usize, classes: i64) -> f64 {
        let change = change_of(class, classes);
        let sign = if change.rises { -1.0 } else { 1.0 };
        match self {
            Self::All => 1.0,
            Self::Level => sign,
            Self::LevelOf(channel) if channel == change.channel => sign,
            Self::LevelOf(_) => 0.0,
            Self::Channel(channel) if channel == change.channel => 1.0,
            Self::Channel(_) => -1.0 / (channels(classes).max(2) - 1) as f64,
        }
    }
}

/// Spectrum of some edges of a recording along the turn (cycles a turn) or time (Hz).
#[must_use]
pub fn spectrum(bench: &Bench, left: &[f64], among: Among, along: Along) -> Spectrum {
    let seen = &bench.seen;
    let weights: Vec<f64> = (0..6).map(|c| among.weight(c, seen.classes)).collect();
    let edges = seen.edges as f64;
    // Edges of one kind repeat every line; what is faster than half of that looks slower.
    let most = if among == Among::All {
        0.45
    } else {
        0.45 / seen.classes as f64
    };
    match along {
        Along::Turn => {
            let first = seen.places.iter().copied().min().unwrap_or(0);
            let last = seen.places.iter().copied().max().unwrap_or(0);
            let numbers = (0..seen.len()).map(|at| {
                let place = (seen.places[at] - first) as f64 / edges;
                (place, left[at] * weights[seen.class(at)])
            });
            Spectrum::of(
                numbers,
                (last - first + 1) as f64 / edges,
                1.0 / edges,
                most * edges,
            )
        }
        Along::Time => {
            let (first, length) = (seen.times_s.first().copied().unwrap_or(0.0), seen.seconds());
            let rate = seen.len() as f64 / length.max(f64::MIN_POSITIVE);
            let most = most.min(0.2) * rate;
            let numbers = (0..seen.len())
                .map(|at| (seen.times_s[at] - first, left[at] * weights[seen.class(at)]));
            Spectrum::of(numbers, length, 1.0 / (6.0 * most), most)
        }
    }
}

/// Rhythms that stand out of a recording, strongest first; noise alone gives one with this probability.
#[must_use]
pub fn peaks(bench: &Bench, number: usize, left: &[f64], probability: f64) -> Vec<Peak> {
    let seen = &bench.seen;
    let turns_a_second = seen.turns() / seen.seconds().max(f64::MIN_POSITIVE);
    let alongs: &[Along] = if steady(bench) {
        &[Along::Turn]
    } else {
        &[Along::Turn, Along::Time]
    };
    let amongs = Among::all(seen.classes);
    let each = probability / (alongs.len() * amongs.len()) as f64;
    let looked: Vec<(Along, Among)> = alongs
        .iter()
        .flat_map(|along| amongs.iter().map(move |among| (*along, *among)))
        .collect();
    let of = |(along, among): (Along, Among)| -> Vec<Peak> {
        let spectrum = spectrum(bench, left, among, along);
        let threshold = spectrum.threshold(each);
        let peaks = spectrum.peaks(threshold, 3).into_iter();
        let peaks = peaks.map(|(cycles, power)| {
            let (order, f_hz) = match along {
                Along::Turn => (cycles, cycles * turns_a_second),
                Along::Time => (cycles / turns_a_second, cycles),
            };
            Peak {
                bench: number,
                among,
                along,
                order,
                f_hz,
                power,
                threshold,
                within: 0.5 / seen.turns(),
            }
        });
        peaks.collect()
    };
    let mut found: Vec<Peak> = looked.into_par_iter().flat_map_iter(of).collect();
    found.sort_by(|a, b| b.power.total_cmp(&a.power));
    found
}

/// Whether the speed hardly changes, so that turn and time say the same.
#[must_use]
pub fn steady(bench: &Bench) -> bool {
    /// How far ahead of an even way or behind it a steady shaft gets, rad.
    const ASTRAY_RAD: f64 = 0.05 * TAU;
    let [low, high] = bench.seen.speed_range();
    let wander = (bench.noise.acceleration
        / (2.0 * (bench.law.damping(0.0, high) + bench.noise.forgets_per_s).max(1e-9)))
    .sqrt();
    low * high > 0.0
        && (high - low).abs() < 0.02 * high.abs().max(low.abs())
        && wander * bench.seen.seconds().sqrt() < ASTRAY_RAD
        && bench.seen.astray_rad() < ASTRAY_RAD
}
