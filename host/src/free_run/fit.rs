//! The loop's gains, measured on the recording itself.
//!
//! The encoder's errors repeat from turn to turn, and what else moves the shaft knows nothing of the torque that the loop will ask
//! for. So, with each edge's mean over the turns taken out, what is left of the angle has nothing in common with the displacement
//! that the loop made, if that was worked out with the right gains. The displacement is linear in the gains: they follow by least
//! squares. As the loop answers to what the shaft did before, residuals are made white first: then they are what just
//! happened, which no torque before it can know.

use std::f64::consts::TAU;

use super::course::Course;
use super::crossing::Crossing;
use super::model::LoopModel;
use super::motion::Response;
use super::push::Push;
use super::whiten::{self, Fitted, Interval, UNKNOWNS};
use crate::twin::Gains;

/// Rounds of filter and gains.
const ROUNDS: usize = 4;

/// Edges to fit to.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// The edges, by time.
    pub crossings: &'a [Crossing],
    /// Ticks a second.
    pub clock_hz: u64,
    /// Edges of the grid in a turn.
    pub edges: u32,
}

/// Gains found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The gains, over inertia.
    pub gains: Gains,
    /// Their standard errors.
    pub standard_error: Gains,
    /// Correlation of the two errors.
    pub correlation: f64,
    /// Variance of what is left of an interval, made white, rad^2.
    pub left: f64,
}

impl Fit {
    /// Whether the gains lie within three of the standard deviations that they are known by. Where the shaft's own noise moves the loop more
    /// than anything else does, a fit goes towards no loop at all and must not be used.
    #[must_use]
    pub fn is_plausible(&self, given: Gains, known_within: f64) -> bool {
        let near = |found: f64, given: f64| (found - given).abs() <= 3.0 * known_within * given;
        near(self.gains.kp, given.kp) && near(self.gains.ki, given.ki)
    }
}

/// Fits the gains of `push`, known within a relative standard deviation of `known_within`. None with less than three turns.
#[must_use]
pub fn fit(data: Data<'_>, push: &Push, known_within: f64) -> Option<Fit> {
    let prior = push.gains();
    let mut push = push.clone();
    let mut found = None;
    // Only where a limit is reached is the displacement not linear in the gains.
    let limited = matches!(&push, Push::Loop(model) if model.limit.is_finite());
    for _ in 0..if limited { 3 } else { 1 } {
        let intervals = intervals(data, &push)?;
        let mut filter = vec![1.0];
        for _ in 0..ROUNDS {
            let fitted = whiten::fit(&intervals, data.edges, &filter, prior, known_within)?;
            filter = whiten::filter(&intervals, data.edges, &fitted);
            found = Some(fitted);
        }
        if let (Push::Loop(model), Some(found)) = (&mut push, &found) {
            *model = LoopModel {
                gains: found.gains(),
                ..*model
            };
        }
    }
    found.map(|fitted: Fitted| Fit {
        gains: fitted.gains(),
        standard_error: fitted.standard_error(),
        correlation: fitted.correlation(),
        left: fitted.left,
    })
}

/// Variance of what `push` leaves of the intervals, the speed of `reach` edges to either side taken out, with the gains that fit best,
/// rad^2. None with less than three turns.
#[must_use]
pub fn scatter(data: Data<'_>, push: &Push, known_within: f64, reach: usize) -> Option<f64> {
    let intervals = local_intervals(data, push, reach);
    let fitted = whiten::fit(&intervals, data.edges, &[1.0], push.gains(), known_within)?;
    Some(fitted.left)
}

/// Intervals against the speed around them, measured and made: what a torque did long ago is not in them.
#[allow(clippy::cast_precision_loss)]
fn local_intervals(data: Data<'_>, push: &Push, reach: usize) -> Vec<Interval> {
    let crossings = data.crossings;
    let step = TAU / f64::from(data.edges);
    let made = Course::of(data, push, step).made;
    let seconds = |from: usize, to: usize| {
        (crossings[to].ticks - crossings[from].ticks) as f64 / data.clock_hz as f64
    };
    let mut list = Vec::with_capacity(crossings.len());
    let mut sure = 0;
    for (at, crossing) in crossings.iter().enumerate() {
        let plain = crossing.sure && crossing.steps == 1;
        sure = if plain { sure + 1 } else { 0 };
        // A window of sure edges, and the interval in its middle.
        if sure <= 2 * reach + 1 {
            continue;
        }
        let (from, before, now) = (at - 2 * reach - 1, at - reach - 1, at - reach);
        let part = seconds(before, now) / seconds(from, at);
        let local =
            |n: usize| (made[now][n] - made[before][n]) - part * (made[at][n] - made[from][n]);
        let way = f64::from(crossing.direction.sign()) * step;
        list.push(Interval {
            edge: crossings[now].edge,
            follows: false,
            angle: way * (1.0 - part * (2 * reach + 1) as f64) - local(2),
            shares: [local(0), local(1), 0.0, 0.0],
        });
    }
    list
}

#[allow(clippy::cast_precision_loss)]
fn intervals(data: Data<'_>, push: &Push) -> Option<Vec<Interval>> {
    let crossings = data.crossings;
    let (first, last) = (crossings.first()?, crossings.last()?);
    let step = TAU / f64::from(data.edges);
    let way = |crossing: &Crossing| crossing.way() as f64 * step;
    let seconds = |ticks: u64| (ticks - first.ticks) as f64 / data.clock_hz as f64;
    let speed = crossings[1..].iter().map(way).sum::<f64>() / seconds(last.ticks);
    if !speed.is_normal() {
        return None;
    }
    let Course { made, free: steady } = Course::of(data, push, step);
    let mut list: Vec<Interval> = Vec::with_capacity(crossings.len());
    let mut follows = false;
    let mut travelled = 0.0;
    let mut before = Response::after(0.0, push.viscous());
    for (at, pair) in crossings.windows(2).enumerate() {
        let crossing = &pair[1];
        travelled += way(crossing).abs();
        // By the way gone: the edge's own time would bring its error in.
        let free = Response::after(travelled / speed.abs(), push.viscous());
        if crossing.sure {
            let share = |n: usize| made[at + 1][n] - made[at][n];
            let shares: [f64; UNKNOWNS] = [
                share(0),
                share(1),
                free.to_speed - before.to_speed,
                free.to_push - before.to_push,
            ];
            list.push(Interval {
                edge: crossing.edge,
                follows,
                angle: way(crossing) - (steady[at + 1] - steady[at]) - share(2),
                shares,
            });
        }
        follows = crossing.sure;
        before = free;
    }
    (list.len() >= 3 * data.edges as usize - 1).then_some(list)
}
