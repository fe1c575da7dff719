//! What a sampled speed loop pushes, from the very intervals that it saw.
//!
//! A loop that samples the speed of the last interval at times n/f pushes the shaft by kp (w* - seen) + ki / f sum (w* - seen), held
//! to the next sample. What it saw is in the recording, the errors of the disc and the stamps with it, so the push is known but for the
//! gains and f, and its response is linear in the gains: the direct method of closed-loop identification (L. Ljung, System Identification,
//! 2nd ed., section 13.4), which needs no noise-free copy of the loop.

use std::f64::consts::TAU;

use super::spans::{Held, Spans};
use crate::diagnose::kalman::{Reading, ShaftNoise, Whitener};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::{Leap, ShaftLaw};

/// A recording as a speed loop sees it.
#[derive(Clone, Debug)]
pub struct Sampled {
    times_s: Vec<f64>,
    /// What the speed of the interval before each edge lacks, rad/s along the motion.
    misses: Vec<f64>,
    /// Angle ahead of the twin's shaft without its drive, along the motion.
    pub angles: Vec<f64>,
    speeds: Vec<f64>,
    fresh: Vec<bool>,
    /// Damping without the drive's, 1/s.
    damping: f64,
    /// Edges a second.
    pub rate_hz: f64,
}

impl Sampled {
    /// A recording with its residual; `law` is that of the shaft without its drive.
    #[must_use]
    pub fn new(seen: &Seen, law: &ShaftLaw) -> Self {
        let step_rad = TAU / seen.edges as f64;
        let way = seen.speeds.first().map_or(1.0, |speed| speed.signum());
        let asked = seen.mean_speed();
        let mut misses = vec![0.0];
        for (times, places) in seen.times_s.windows(2).zip(seen.places.windows(2)) {
            let speed = (places[1] - places[0]).abs() as f64 * step_rad / (times[1] - times[0]);
            misses.push(asked - speed);
        }
        let damping = law.damping(0.0, asked);
        let angles: Vec<f64> = seen.angles.iter().map(|angle| angle * way).collect();
        Self {
            rate_hz: (seen.len() as f64 - 1.0) / seen.seconds(),
            times_s: seen.times_s.clone(),
            misses,
            angles,
            speeds: seen.readings.iter().map(|reading| reading.speed).collect(),
            fresh: seen.readings.iter().map(|reading| reading.fresh).collect(),
            damping,
        }
    }

    /// Edges.
    #[must_use]
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// Edges that would have come by the last one since time 0.
    #[must_use]
    pub fn edges_since_zero(&self) -> f64 {
        self.times_s.last().map_or(1.0, |last| last * self.rate_hz)
    }

    /// Every n-th edge, n = `each`, from where a loop's last sample before is known.
    #[must_use]
    pub fn edges_for(&self, f_hz: f64, each: usize) -> Vec<usize> {
        let known = self.edge_at(self.times_s[1] + 1.0 / f_hz, 1) + 1;
        (known..self.len()).step_by(each.max(1)).collect()
    }

    /// The edge that came at a time.
    #[must_use]
    pub fn edge_of(&self, time_s: f64) -> Option<usize> {
        let edge = self.times_s.partition_point(|time| *time < time_s);
        (self.times_s.get(edge) == Some(&time_s)).then_some(edge)
    }

    /// Time of an edge, s.
    #[must_use]
    pub fn time_s(&self, edge: usize) -> f64 {
        self.times_s[edge]
    }

    /// What the noise model needs of some edges.
    #[must_use]
    pub fn readings(&self, edges: &[usize]) -> Vec<Reading> {
        let mut before = edges.first().copied().unwrap_or(0);
        let each = edges.iter().map(|&edge| {
            let fresh = (before + 1..=edge).any(|i| self.fresh[i]);
            let reading = Reading {
                leap: Leap {
                    after_s: self.times_s[edge] - self.times_s[before],
                    damping: self.damping,
                    spring: None,
                },
                speed: self.speeds[edge],
                at_s: self.times_s[edge],
                fresh,
                anew: false,
                jolt: 0.0,
                doubt_s: 0.0,
            };
            before = edge;
            reading
        });
        each.collect()
    }

    /// A filter for some edges.
    #[must_use]
    pub fn whitener(&self, edges: &[usize], noise: ShaftNoise) -> Whitener {
        Whitener::new(&self.readings(edges), noise)
    }

    /// Angles of some edges.
    #[must_use]
    pub fn angles_at(&self, edges: &[usize]) -> Vec<f64> {
        edges.iter().map(|&edge| self.angles[edge]).collect()
    }

    /// Last edge at a time, looked for from one near it.
    fn edge_at(&self, time_s: f64, near: usize) -> usize {
        let last = self.len() - 1;
        let guess = near as f64 + (time_s - self.times_s[near]) * self.rate_hz;
        let mut at = (guess.max(0.0) as usize).min(last);
        while at < last && self.times_s[at + 1] <= time_s {
            at += 1;
        }
        while at > 0 && self.times_s[at] > time_s {
            at -= 1;
        }
        at
    }

    /// Takes the speed asked for to be the mean of what a loop saw, as its integrator makes it.
    pub fn centre(&mut self, f_hz: f64) {
        let (first, last) = (self.times_s[1] * f_hz, self.times_s[self.len() - 1] * f_hz);
        let (mut near, mut sum, mut count) = (1, 0.0, 0.0);
        for sample in first.ceil() as i64..=last.floor() as i64 {
            near = self.edge_at(sample as f64 / f_hz, near);
            sum += self.misses[near];
            count += 1.0;
        }
        if count > 0.0 {
            self.misses.iter_mut().for_each(|miss| *miss -= sum / count);
        }
    }

    /// Some edges with what a constant push does between them, whatever the rate.
    #[must_use]
    pub fn spans(&self, edges: Vec<usize>) -> Spans {
        let mut before = edges.first().copied().unwrap_or(0);
        let each = edges.iter().map(|&edge| {
            let last = std::mem::replace(&mut before, edge);
            Held::over(self.times_s[edge] - self.times_s[last], self.damping)
        });
        Spans {
            held: each.collect(),
            edges,
        }
    }

    /// Responses at some edges to both gains, sampled at `f_hz`.
    #[must_use]
    pub fn gains(&self, spans: &Spans, f_hz: f64) -> [Vec<f64>; 2] {
        let mut near = spans.edges[0];
        self.responses(spans, f_hz, |sample| {
            near = self.edge_at(sample / f_hz, near);
            self.misses[near]
        })
    }

    /// The first of them alone.
    #[must_use]
    pub fn gain(&self, spans: &Spans, f_hz: f64) -> Vec<f64> {
        let mut near = spans.edges[0];
        let [proportional] = self.responses(spans, f_hz, |sample| {
            near = self.edge_at(sample / f_hz, near);
            self.misses[near]
        });
        proportional
    }

    /// What a loop sampled at `f_hz` missed at each sample, from sample 0 on.
    #[must_use]
    pub fn missed(&self, f_hz: f64) -> Vec<f64> {
        let last = (self.times_s[self.len() - 1] * f_hz).floor();
        let mut near = 1;
        (0..=last as usize)
            .map(|sample| {
                near = self.edge_at(sample as f64 / f_hz, near);
                self.misses[near]
            })
            .collect()
    }

    /// Responses at some edges to the gains of a loop, the proportional one first, that misses at each sample what it says.
    #[must_use]
    pub fn responses<const N: usize>(
        &self,
        spans: &Spans,
        f_hz: f64,
        mut missed: impl FnMut(f64) -> f64,
    ) -> [Vec<f64>; N] {
        let edges = &spans.edges;
        let mut out = std::array::from_fn(|_| Vec::with_capacity(edges.len()));
        let (mut states, mut pushes) = ([[0.0; 2]; N], [0.0; 2]);
        let mut now = self.times_s[edges[0]];
        let mut sample = (now * f_hz).floor() - 1.0;
        for (&edge, whole) in edges.iter().zip(&spans.held) {
            let (start, end) = (now, self.times_s[edge]);
            loop {
                let next = (sample + 1.0) / f_hz;
                if next > end {
                    break;
                }
                if next > now {
                    let held = Held::over(next - now, self.damping);
                    for (state, push) in states.iter_mut().zip(pushes) {
                        *state = held.pushed(*state, push);
                    }
                    now = next;
                }
                pushes[1] += pushes[0] / f_hz;
                sample += 1.0;
                pushes[0] = missed(sample);
            }
            let held = if now == start {
                *whole
            } else {
                Held::over(end - now, self.damping)
            };
            for (state, push) in states.iter_mut().zip(pushes) {
                *state = held.pushed(*state, push);
            }
            now = end;
            for (out, state) in out.iter_mut().zip(states) {
                out.push(state[0]);
            }
        }
        out
    }

    /// Responses at some edges to a constant push and to one that grows by the second.
    #[must_use]
    pub fn steady(&self, spans: &Spans) -> [Vec<f64>; 2] {
        let edges = &spans.edges;
        let (mut level, mut slope) = ([0.0; 2], [0.0; 2]);
        let start = self.times_s[edges[0]];
        let mut now = start;
        let mut out = [
            Vec::with_capacity(edges.len()),
            Vec::with_capacity(edges.len()),
        ];
        for (&edge, held) in edges.iter().zip(&spans.held) {
            let end = self.times_s[edge];
            level = held.pushed(level, 1.0);
            slope = held.pushed(slope, 0.5 * (now + end) - start);
            now = end;
            out[0].push(level[0]);
            out[1].push(slope[0]);
        }
        out
    }
}
