//! Samples of a speed loop that fall on an edge: whether the loop saw the edge is not said by the stamps, and pushes otherwise.
//!
//! Either way it pushed, the edges after it tell: the push that makes them more likely, with how near the stamp is, is the one.

use super::bench::Bench;
use super::seen::Seen;

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

/// Samples in which the push and its echo show.
const SAMPLES: f64 = 6.0;
/// Edges in which they show at the least: the filter takes a while to know.
const EDGES_LEAST: usize = 300;
/// Times that all of them are gone through: neighbours lean on each other.
const PASSES: usize = 3;

/// Decides all ties of a recording, whether any came out the other way; the residual is then that of the loop as it pushed.
pub fn decide(bench: &mut Bench) -> bool {
    let mut ties = std::mem::take(&mut bench.seen.ties);
    let mut any = false;
    for _ in 0..PASSES {
        let mut turned = false;
        for tie in &mut ties {
            let gain = gain(bench, *tie);
            // Two log likelihoods that the order of the stamps has ahead of the other one.
            let apart = tie.apart_s / bench.noise.stamp_s;
            let tail = 0.5 * libm::erfc(apart / std::f64::consts::SQRT_2);
            if gain > 2.0 * ((1.0 - tail) / tail.max(1e-30)).ln() {
                let pushed = pushed(&bench.seen, *tie, 0..bench.seen.len());
                for (angle, value) in bench.seen.angles.iter_mut().zip(&pushed) {
                    *angle -= value;
                }
                bench.set_noise(bench.noise);
                (tie.push, tie.after, tie.apart_s) = (-tie.push, -tie.after, -tie.apart_s);
                tie.turned = !tie.turned;
                turned = true;
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

/// By how much the squares fall if the loop pushed the other way. A steady push, of the load or of what the loop's integral remembers,
/// is none of it.
fn gain(bench: &Bench, tie: Tie) -> f64 {
    let times = &bench.seen.times_s;
    let first = times.partition_point(|time| *time < tie.at_s);
    let lasts_s = SAMPLES * (tie.until_s - tie.at_s);
    let last = times.partition_point(|time| *time < tie.at_s + lasts_s);
    let last = last.max(first + EDGES_LEAST).min(times.len());
    let from = first.saturating_sub(last - first);
    let mut white = vec![0.0; first - from];
    white.extend(pushed(&bench.seen, tie, first..last));
    bench.whitener().whiten_from(from, &mut white);
    let always = Tie {
        at_s: f64::NEG_INFINITY,
        until_s: f64::INFINITY,
        push: 1.0,
        ..tie
    };
    let mut steady = pushed(&bench.seen, always, from..last);
    bench.whitener().whiten_from(from, &mut steady);
    let left = &bench.white[from..last];
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let own = product(&steady, &steady).max(f64::MIN_POSITIVE);
    let (of_white, of_left) = (product(&steady, &white), product(&steady, left));
    2.0 * (product(&white, left) - of_white * of_left / own)
        - (product(&white, &white) - of_white * of_white / own)
}

/// What the other push makes of the angles of some edges, rad.
fn pushed(seen: &Seen, tie: Tie, edges: std::ops::Range<usize>) -> Vec<f64> {
    let mut state = [0.0; 2];
    edges
        .map(|at| {
            let now = seen.times_s[at];
            let leap = seen.readings[at].leap;
            let before = now - leap.after_s;
            let during = (now.min(tie.until_s) - before.max(tie.at_s)).max(0.0);
            let since = (now - before.max(tie.until_s)).max(0.0);
            if leap.after_s > 0.0 {
                let push = (during * tie.push + since * tie.after) / leap.after_s;
                state = leap.step(state, [push; 3]);
            }
            state[0]
        })
        .collect()
}
