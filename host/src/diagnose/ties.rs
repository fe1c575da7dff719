//! Samples of a speed loop that fall on an edge: whether the loop saw the edge is not said by the stamps, and pushes otherwise.
//!
//! Either way it pushed, the edges after it tell: the push that makes them more likely, with how near the stamp is, is the one.

use super::bench::Bench;
use super::kalman::ShaftNoise;
use super::seen::Seen;
use super::shaft::{AT_REST, Leap};

/// A sample of the loop about which stamps leave a doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// When it was taken, s.
    pub at_s: f64,
    /// Until when its push lasts, s.
    pub until_s: f64,
    /// How far the edge's stamp is from it on the side that was taken, s.
    pub apart_s: f64,
    /// How much more the loop pushed until then if it saw otherwise, rad/s^2.
    pub push: f64,
    /// And how much more from then on, as its integral remembers, rad/s^2.
    pub after: f64,
    /// Whether it was decided against the order of the stamps.
    pub turned: bool,
}

/// Times that noise is found and ties are decided by turns.
const SETTLES: usize = 12;
/// Torque noise over that of the turn before, by which a turn is worth another.
const QUIETER: f64 = 0.9;
/// Least of it, as noise that is fitted on parts of a recording does not have the ties of all of it.
const SLOWLY: f64 = 0.01;
/// Variance of the white residual from which on the noise is not what the twin declares.
const VARIANCE: f64 = 1.1;
/// The same up to which noise that was fitted fits all of a recording, and times that it is made wider.
const FITS: f64 = 1.3;
const WIDER: usize = 40;
/// Parts of a recording that may each have a steady push of their own.
const STEADY: usize = 10;
/// Samples in which the push and its echo show.
const SAMPLES: f64 = 6.0;
/// Edges in which they show at the least: the filter takes a while to know.
const EDGES_LEAST: usize = 300;
/// Standard errors of a stamp that an edge is never off by.
const FAR: f64 = 12.0;
/// Times that all of them are gone through: neighbours lean on each other.
const PASSES: usize = 3;

/// Puts the pushes right of ties that were decided before: what a mended twin has more of decides none of them otherwise.
pub fn put_right(bench: &mut Bench, turned: &[f64]) {
    for tie in &mut bench.seen.ties {
        if turned.contains(&tie.at_s) {
            *tie = tie.otherwise();
        }
    }
    apply(bench);
    if bench.declared.is_none() {
        bench.set_noise(bench.noise_of(&bench.seen.angles));
    }
}

/// Takes off what the turned ties push otherwise, and the steady push.
fn apply(bench: &mut Bench) {
    for tie in bench.seen.ties.iter().filter(|tie| tie.turned) {
        let pushed = pushed(&bench.seen, &[tie.otherwise()], 0..bench.seen.len());
        for (angle, value) in bench.seen.angles.iter_mut().zip(&pushed) {
            *angle -= value;
        }
    }
    bench.set_noise(bench.noise);
    bench.level();
}

/// Decides the ties of a recording and puts the pushes right; with what stamps, s, or none where there are no ties.
///
/// What the twin does not have would pass for noise, in which no push of the loop shows: steady pushes, each for a part of the recording,
/// and what all edges of a class have are off while ties are decided. With less noise more of them are.
pub fn settle(bench: &mut Bench) -> Option<f64> {
    if bench.seen.ties.is_empty() {
        return None;
    }
    let mut there = bench.clone();
    for _ in 0..SETTLES {
        let before = there.noise;
        there.smooth(STEADY);
        if there.declared.is_none() || variance(&there) > VARIANCE {
            let found = there.noise_of(&there.seen.angles);
            there.set_noise(ShaftNoise {
                acceleration: found.acceleration.max(SLOWLY * before.acceleration),
                ..found
            });
            there.smooth(STEADY);
            widen(&mut there);
        }
        let quieter = there.noise.acceleration < QUIETER * before.acceleration;
        if !decide(&mut there) && !quieter {
            break;
        }
    }
    bench.seen.ties = there.seen.ties;
    bench.noise = there.noise;
    apply(bench);
    if let Some(declared) = bench.declared {
        bench.set_noise(declared);
    } else {
        bench.set_noise(bench.noise_of(&bench.seen.angles));
        bench.level();
    }
    Some(there.noise.stamp_s)
}

/// Mean square of a residual, white.
fn variance(bench: &Bench) -> f64 {
    let squares: f64 = bench.white.iter().map(|white| white * white).sum();
    squares / bench.white.len().max(1) as f64
}

/// Noise is fitted on parts of a recording; where ties that are wrong elsewhere make more, it is more.
fn widen(bench: &mut Bench) {
    for _ in 0..WIDER {
        let variance = variance(bench);
        if variance < FITS {
            break;
        }
        bench.set_noise(ShaftNoise {
            acceleration: bench.noise.acceleration * variance.max(2.0),
            ..bench.noise
        });
    }
}

/// Decides all ties of a recording, whether any came out the other way; the residual is then that of the loop as it pushed.
pub fn decide(bench: &mut Bench) -> bool {
    let mut ties = std::mem::take(&mut bench.seen.ties);
    let mut any = false;
    for _ in 0..PASSES {
        let mut turned = false;
        for at in 0..ties.len() {
            if ties[at].apart_s > FAR * bench.noise.stamp_s {
                continue;
            }
            // Of two that are near each other the wrong one may have been taken for the other.
            let next = ties.get(at + 1).filter(|next| near(ties[at], **next));
            let pair = [ties[at]].into_iter().chain(next.copied());
            let pair: Vec<Tie> = pair.collect();
            for ways in (1..=pair.len()).map(|count| &pair[..count]) {
                if !more_likely(bench, ways) {
                    continue;
                }
                let pushed = pushed(&bench.seen, ways, 0..bench.seen.len());
                for (angle, value) in bench.seen.angles.iter_mut().zip(&pushed) {
                    *angle -= value;
                }
                bench.set_noise(bench.noise);
                for tie in &mut ties[at..at + ways.len()] {
                    *tie = tie.otherwise();
                }
                turned = true;
                break;
            }
        }
        any |= turned;
        if !turned {
            break;
        }
    }
    bench.seen.ties = ties;
    any
}

impl Tie {
    /// The other way.
    fn otherwise(self) -> Self {
        Self {
            push: -self.push,
            after: -self.after,
            apart_s: -self.apart_s,
            turned: !self.turned,
            ..self
        }
    }
}

/// Whether the pushes of two lean on each other.
fn near(one: Tie, other: Tie) -> bool {
    other.at_s - one.at_s < SAMPLES * (one.until_s - one.at_s)
}

/// Whether it is more likely that the loop saw all of these the other way.
fn more_likely(bench: &Bench, ties: &[Tie]) -> bool {
    // Two log likelihoods that the order of the stamps has ahead of the other one.
    let ahead = |tie: &Tie| {
        let apart = tie.apart_s / bench.noise.stamp_s;
        let tail = 0.5 * libm::erfc(apart / std::f64::consts::SQRT_2);
        2.0 * ((1.0 - tail).max(1e-30) / tail.max(1e-30)).ln()
    };
    gain(bench, ties) > ties.iter().map(ahead).sum::<f64>()
}

/// By how much the squares fall if the loop pushed the other way. A steady push, of the load or of what the loop's integral remembers,
/// is none of it.
fn gain(bench: &Bench, ties: &[Tie]) -> f64 {
    let (Some(begin), Some(end)) = (ties.first(), ties.last()) else {
        return 0.0;
    };
    let times = &bench.seen.times_s;
    let first = times.partition_point(|time| *time < begin.at_s);
    let lasts_s = SAMPLES * (end.until_s - end.at_s);
    let last = times.partition_point(|time| *time < end.at_s + lasts_s);
    let last = last.max(first + EDGES_LEAST).min(times.len());
    let from = first.saturating_sub(last - first);
    let mut white = vec![0.0; first - from];
    white.extend(pushed(&bench.seen, ties, first..last));
    bench.whitener().whiten_from(from, &mut white);
    let always = Tie {
        at_s: f64::NEG_INFINITY,
        until_s: f64::INFINITY,
        push: 1.0,
        ..*begin
    };
    let mut steady = pushed(&bench.seen, &[always], from..last);
    bench.whitener().whiten_from(from, &mut steady);
    let left = &bench.white[from..last];
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let own = product(&steady, &steady).max(f64::MIN_POSITIVE);
    let (of_white, of_left) = (product(&steady, &white), product(&steady, left));
    2.0 * (product(&white, left) - of_white * of_left / own)
        - (product(&white, &white) - of_white * of_white / own)
}

/// What the other pushes make of the angles of some edges, rad.
fn pushed(seen: &Seen, ties: &[Tie], edges: std::ops::Range<usize>) -> Vec<f64> {
    let mut angles = vec![0.0; edges.len()];
    for tie in ties {
        let mut state = AT_REST;
        for (angle, at) in angles.iter_mut().zip(edges.clone()) {
            let leap = seen.readings[at].leap;
            let now = seen.times_s[at];
            let mut from_s = now - leap.after_s;
            // Each part of the interval at its own push: an average over it puts the kick elsewhere.
            for (until_s, push) in [
                (tie.at_s, 0.0),
                (tie.until_s, tie.push),
                (f64::INFINITY, tie.after),
            ] {
                let after_s = now.min(until_s) - from_s;
                if after_s > 0.0 {
                    state = Leap { after_s, ..leap }.step(state, [push; 3]);
                    from_s += after_s;
                }
            }
            *angle += state[0];
        }
    }
    angles
}
