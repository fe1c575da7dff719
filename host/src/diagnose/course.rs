//! Where the shaft is between and at edges, as the edges themselves have it: the angle that torques are evaluated at.

use std::f64::consts::TAU;

use super::lsq;
use super::plant::Motion;
use super::record::Record;

/// Part of the speed by which it changes from turn to turn at the most where it hardly changes.
const SAME: f64 = 0.02;

/// Angles and speeds along a recording.
#[derive(Clone, Debug)]
pub struct Course {
    /// Time of each edge, s.
    pub time_s: Vec<f64>,
    /// Angle of the shaft there, rad.
    pub angle: Vec<f64>,
    /// Speed there, rad/s, negative in reverse.
    pub speed: Vec<f64>,
    /// Way to either side over which that is, rad.
    pub span: f64,
    /// When it turns round, s.
    pub reversals_s: Vec<f64>,
    /// How late each stamp is, as far as that is known, s.
    pub late_s: Vec<f64>,
    /// RMS error of each stamp beside the others', s.
    pub doubt_s: Vec<f64>,
    /// Speed of the interval that ends at each edge as the edges before it foretell it, rad/s: what torques that go with the speed go by.
    pub steady: Vec<f64>,
}

impl Course {
    /// Of a recording, whose edges are off the grid by known angles, rad.
    pub fn new(record: &Record, off: &[f64]) -> Self {
        Self::bent(record, off, &vec![Motion::default(); record.len()])
    }

    /// The same where torques are known to bend it: what they do to the speed between edges needs no guess.
    pub fn bent(record: &Record, off: &[f64], known: &[Motion]) -> Self {
        let angle: Vec<f64> = (0..record.len())
            .map(|at| record.grid_rad(at) - off[at])
            .collect();
        let rest: Vec<f64> = angle
            .iter()
            .zip(known)
            .map(|(angle, [known, _])| angle - known)
            .collect();
        // An edge that the shaft rocks about says nothing of a speed.
        let each = speeds(record, &rest).into_iter().zip(known);
        let speed = each.map(|(speed, [_, known])| speed.map_or(0.0, |speed| speed + known));
        let speed = speed.collect();
        let mut course = Self {
            time_s: record.time_s.clone(),
            angle,
            speed,
            span: reach(record) as f64 * TAU / record.edges as f64,
            reversals_s: Vec::new(),
            late_s: vec![0.0; record.len()],
            doubt_s: record.doubt_s.clone(),
            steady: Vec::new(),
        };
        course.steady = course.steady_speeds(record, known);
        course.reversals_s = (1..course.len())
            .filter(|&at| record.way[at] != record.way[at - 1])
            .map(|at| course.still_s(at))
            .collect();
        course
    }

    /// Edges.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Angle and speed at a share of the interval that ends at an edge: a cubic through both ends.
    #[inline]
    pub fn within(&self, at: usize, share: f64) -> (f64, f64) {
        let h = self.time_s[at] - self.time_s[at - 1];
        if h <= 0.0 {
            return (self.angle[at], self.speed[at]);
        }
        let way = self.angle[at] - self.angle[at - 1];
        let (v0, v1) = (self.speed[at - 1], self.speed[at]);
        // Hermite's cubic. A shaft that goes the same way at both ends does not stop between them: with slopes up to 3 it would not turn
        // round (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980), with these it goes on with a quarter of its mean speed.
        let most = if v0 * v1 > 0.0 {
            2.5 * way.abs()
        } else {
            f64::INFINITY
        };
        let (b, c) = ((h * v0).clamp(-most, most), (h * v1).clamp(-most, most));
        let s = share;
        let (s2, s3) = (s * s, s * s * s);
        let angle = self.angle[at - 1]
            + way * (3.0 * s2 - 2.0 * s3)
            + b * (s3 - 2.0 * s2 + s)
            + c * (s3 - s2);
        let speed =
            (way * 6.0 * (s - s2) + b * (3.0 * s2 - 4.0 * s + 1.0) + c * (3.0 * s2 - 2.0 * s)) / h;
        (angle, speed)
    }

    /// Speed of the interval that ends at each edge as torques that are known and the edges before it foretell it: straight on from two
    /// stretches of half a turn, or of a turn. A regressor must not hold the noise that it is to be told from, as the speed between the edges themselves does (L. Ljung,
    /// System Identification, 2nd ed., section 13.4).
    fn steady_speeds(&self, record: &Record, known: &[Motion]) -> Vec<f64> {
        /// Edges that a stretch needs.
        const LEAST: usize = 4;
        let turn = record.edges as usize;
        // Over whole turns the disc's errors cancel: where the speed hardly changes they would be most of what is left of it.
        let whole = if self.hardly_changes(turn) {
            turn
        } else {
            turn / 2
        };
        let whole = whole.max(LEAST);
        let mut run = 0;
        let mut steady = self.speed.clone();
        for (at, steady) in steady.iter_mut().enumerate().skip(1) {
            if record.way[at] != record.way[at - 1] {
                run = at;
            }
            let last = at - 1;
            let reach = (last.saturating_sub(run) / 2).min(whole);
            if last < run || reach < LEAST {
                continue;
            }
            let mean = |from: usize, until: usize| {
                let time_s = self.time_s[until] - self.time_s[from];
                let middle_s = 0.5 * (self.time_s[until] + self.time_s[from]);
                let way = self.angle[until] - self.angle[from];
                let known = known[until][0] - known[from][0];
                ((way - known) / time_s.max(f64::MIN_POSITIVE), middle_s)
            };
            let (before, before_s) = mean(last - 2 * reach, last - reach);
            let (after, after_s) = mean(last - reach, last);
            let now_s = 0.5 * (self.time_s[last] + self.time_s[at]);
            let slope = (after - before) / (after_s - before_s).max(f64::MIN_POSITIVE);
            let known = 0.5 * (known[last][1] + known[at][1]);
            let (after, ahead) = (known + after, known + after + slope * (now_s - after_s));
            // It does not turn round before it does.
            *steady = if ahead * after > 0.0 { ahead } else { after };
        }
        steady
    }

    /// Whether the mean speed of a turn is nearly the same throughout.
    fn hardly_changes(&self, turn: usize) -> bool {
        let ends = self.angle.iter().zip(&self.time_s);
        let (first, last) = (ends.clone(), ends.skip(turn));
        let speeds = first
            .zip(last)
            .map(|((from, from_s), (until, until_s))| (until - from) / (until_s - from_s));
        let (least, most) = lsq::ends(speeds);
        most - least < SAME * most.abs().max(least.abs())
    }

    /// When it stands still within the interval that ends at an edge, s.
    fn still_s(&self, at: usize) -> f64 {
        let h = self.time_s[at] - self.time_s[at - 1];
        let way = self.angle[at] - self.angle[at - 1];
        // The speed of the cubic, c + b s + a s^2, has another sign at either end: one root lies between. No digits cancel so.
        let (v0, v1) = (h * self.speed[at - 1], h * self.speed[at]);
        let (a, b, c) = (
            3.0 * (v0 + v1) - 6.0 * way,
            6.0 * way - 4.0 * v0 - 2.0 * v1,
            v0,
        );
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
        let sum = -0.5 * (b + root.copysign(b));
        let within = [c / sum, sum / a]
            .into_iter()
            .find(|share| (0.0..=1.0).contains(share));
        self.time_s[at - 1] + within.unwrap_or(0.0) * h
    }

    /// Greatest speed either way, rad/s.
    pub fn top(&self) -> f64 {
        self.speed
            .iter()
            .fold(0.0, |top, speed| speed.abs().max(top))
    }

    /// Mean of the size of the speed over time, rad/s.
    pub fn mean(&self) -> f64 {
        let way: f64 = self
            .angle
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .sum();
        let time = self.time_s.last().unwrap_or(&0.0) - self.time_s.first().unwrap_or(&0.0);
        way / time.max(f64::MIN_POSITIVE)
    }
}

/// Half the edges of a line.
fn reach(record: &Record) -> usize {
    (record.classes as usize / 2).max(1)
}

/// Speeds from the angles of edges one line apart: half of it to either side, within one direction; none where that is no way.
fn speeds(record: &Record, angle: &[f64]) -> Vec<Option<f64>> {
    let reach = reach(record);
    let last = record.len().saturating_sub(1);
    (0..record.len())
        .map(|at| {
            let way = record.way[at];
            let mut from = at;
            while from > 0 && at - from < reach && record.way[from - 1] == way {
                from -= 1;
            }
            let mut until = at;
            while until < last && until - at < reach && record.way[until + 1] == way {
                until += 1;
            }
            let h = record.time_s[until] - record.time_s[from];
            (h > 0.0).then(|| (angle[until] - angle[from]) / h)
        })
        .collect()
}
