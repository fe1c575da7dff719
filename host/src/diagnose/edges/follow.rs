//! The likeliest way of a shaft through a row of edges.
//!
//! A hypothesis says which sector the shaft is in and how fast it is. Each observation moves it on by one edge, by more where edges
//! were lost, back where the levels tell the direction, or is no edge at all. What a move costs is the likelihood of the interval
//! under a speed that changes smoothly, plus what the event itself costs. A wheel may also be lost sight of: then nothing is
//! expected, until the pattern of a turn is met again. The best hypotheses are kept until only one is left (Viterbi, with a beam).

use std::f64::consts::LN_2;

use super::SURE;
use super::grid::{Grid, Interval, Sight, Speed, broad};

/// Price in log likelihood of what befalls few edges: some are lost, one came too many on one channel, the wheel is lost sight of. It is
/// the log of its odds, one in 3,000 edges.
const RARE: f64 = 8.0;
/// Price in log likelihood of a level that is not seen because its edge was lost.
const LEVEL: f64 = 2.5;
/// Price in log likelihood of a reversal of a shaft that was slowing down.
const REVERSAL: f64 = 3.0;
/// Change of the log speed an edge of a shaft that will stand still before the next one: braked evenly it is 0.2 two edges before.
const STOPS: f64 = -0.1;
/// Log likelihood of a log interval that nothing predicts, and of one way of two.
const BROAD: f64 = -LN_2;
/// Hypotheses kept beside the ranks of a turn.
const KEPT: usize = 48;
/// Rounds of classes that may be lost in a row before the place counts as unknown.
const MOST_LOST: i64 = 32;
/// Innovations of a log interval that are plain whatever the spread: neither a lost edge nor one too many makes smaller ones.
const PLAIN: f64 = 0.2;
/// Share of its price that an event saves in a burst, and what an edge in between leaves of that.
const BURST: f64 = 0.6;
const CALM: f64 = 0.9;

/// What depends on whether levels tell the direction; where they do, there is room for a motion that is anything but smooth.
struct Sort {
    /// Price in log likelihood of each edge more that is lost at one place.
    lost_more: f64,
    /// That of a pulse that is no edge; levels of several channels allow a shaft that rocks as well.
    extra: f64,
    /// Standard deviation of a log interval about its prediction, at a start and at the most.
    spread: [f64; 2],
}

impl Sort {
    const fn of(grid: &Grid) -> Self {
        let (lost_more, extra, spread) = if grid.reversible {
            (2.5, 12.0, [0.7, 1.0])
        } else {
            (1.0, RARE, [0.3, 0.35])
        };
        Self {
            lost_more,
            extra,
            spread,
        }
    }
}

/// What became of an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seen {
    /// An edge: its rank, and whether the rank goes on from the edge before.
    Edge {
        rank: i64,
        forward: bool,
        fresh: bool,
    },
    /// A pulse that is no edge.
    Extra,
    /// Unknown: the wheel was out of sight.
    Astray,
}

/// The way found.
#[derive(Clone, Debug, Default)]
pub(super) struct Way {
    /// One entry an observation.
    pub seen: Vec<Seen>,
    /// Log likelihood.
    pub score: f64,
    /// How much better it is than the best one that ends at another place of the turn.
    pub lead: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Hypothesis {
    /// Whether the wheel is out of sight.
    astray: bool,
    sector: i64,
    forward: bool,
    ticks: u64,
    /// Whether that is the time of an edge.
    timed: bool,
    /// None before there is an interval.
    speed: Option<Speed>,
    /// Whether the last observation was no edge.
    skipped: bool,
    /// How near the last edge lost or too many is: 1 just behind it, then less and less.
    trouble: f64,
    score: f64,
    /// The last of its observations that are still open.
    node: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    parent: Option<usize>,
    seen: Seen,
}

struct Follower<'a> {
    grid: &'a Grid,
    sort: Sort,
    live: Vec<Hypothesis>,
    next: Vec<Hypothesis>,
    nodes: Vec<Node>,
    way: Way,
}

/// Finds the likeliest way. `start` is the class of the sector before the first observation; with none the first
/// observation is the first edge.
pub(super) fn follow(
    grid: &Grid,
    start: Option<(u64, u8)>,
    sights: impl Iterator<Item = Sight>,
) -> Way {
    let (ticks, class) = start.unwrap_or_default();
    let first = Hypothesis {
        astray: start.is_none(),
        sector: start.map_or(-1, |_| class.into()),
        forward: true,
        ticks,
        ..Hypothesis::default()
    };
    let mut follower = Follower {
        grid,
        sort: Sort::of(grid),
        live: vec![first],
        next: Vec::new(),
        nodes: Vec::new(),
        way: Way::default(),
    };
    for sight in sights {
        follower.step(sight);
    }
    follower.finish()
}

/// What a reversal or a stop costs more where the motion before falls short of one by so much: ten times as much at the most.
fn abrupt(by: f64, variance: f64) -> f64 {
    (by.powi(2) / (2.0 * variance)).min(10.0 * REVERSAL)
}

impl Hypothesis {
    /// The edge crossed last.
    fn edge(&self) -> i64 {
        self.sector + i64::from(!self.forward)
    }

    fn seen(&self, fresh: bool) -> Seen {
        Seen::Edge {
            rank: self.edge(),
            forward: self.forward,
            fresh,
        }
    }

    fn log_interval(&self, sight: Sight) -> f64 {
        let ticks = sight.ticks.saturating_sub(self.ticks) as f64;
        ticks.max(0.5).ln()
    }

    /// Goes on out of sight of the wheel, where an interval is about as long as the one before; its log likelihood.
    fn wander(&mut self, sight: Sight) -> f64 {
        let log_interval = self.log_interval(sight);
        let last = self.speed.replace(Speed::alone(-log_interval));
        self.skipped = false;
        self.ticks = sight.ticks;
        last.map_or(2.0 * BROAD, |last| broad(last.log + log_interval))
    }

    /// Books edges lost or too many, of which the first is cheaper soon after others: they come in bursts.
    fn disturb(&mut self, first: f64, more: f64) {
        self.score -= first * (1.0 - BURST * self.trouble) + more;
        self.trouble = 1.0;
    }

    /// Goes on in smooth motion over an interval that is so much off what a speed foretold.
    fn glide(&mut self, speed: &Speed, spread: [f64; 2], interval: Interval, off: f64) {
        let (score, sure) = speed.likelihood(off);
        self.score += score;
        self.speed = Some(speed.after(spread, interval, off, sure));
        self.trouble *= CALM;
    }
}

impl Follower<'_> {
    fn interval(&self, from: &Hypothesis, to: &Hypothesis, sight: Sight) -> Interval {
        Interval {
            log: from.log_interval(sight),
            distance: self.grid.distance(from.edge(), to.edge()),
        }
    }

    /// One edge on in smooth motion, where nothing else is worth a thought; none where it is.
    #[inline]
    fn plain(&self, from: &Hypothesis, sight: Sight) -> Option<Hypothesis> {
        let speed = from.speed.filter(|_| !from.astray && !from.skipped)?;
        let mut to = *from;
        let on = if to.forward { 1 } else { -1 };
        if self.grid.ahead(to.sector + on, sight.class?) != 0 {
            return None;
        }
        to.sector += on;
        let interval = self.interval(from, &to, sight);
        let off = speed.off(interval);
        if off.abs() > PLAIN && (off * off > 6.0 * speed.variance || off.abs() > 2.0 * PLAIN) {
            return None;
        }
        to.glide(&speed, self.sort.spread, interval, off);
        to.ticks = sight.ticks;
        Some(to)
    }

    fn step(&mut self, sight: Sight) {
        self.next.clear();
        let live = std::mem::take(&mut self.live);
        let best = live.iter().map(|h| h.score).fold(f64::MIN, f64::max);
        for hypothesis in &live {
            if hypothesis.astray {
                self.search(hypothesis, sight, hypothesis.score >= best);
            } else {
                self.moves(hypothesis, sight);
            }
        }
        self.live = live;
        self.keep();
    }

    /// All that a shaft whose place is known may have done.
    fn moves(&mut self, from: &Hypothesis, sight: Sight) {
        if let Some(to) = self.plain(from, sight) {
            return self.push(to, to.seen(false));
        }
        let Some(class) = sight.class else {
            return self.no_edge(from, -self.sort.extra);
        };
        let ahead = self.grid.ahead(from.sector, class);
        if from.skipped && ahead == 0 && self.grid.classes() > 1 {
            // The end of a pulse that was no edge.
            return self.no_edge(from, BROAD);
        }
        self.onward(from, sight, ahead, from.forward);
        if self.grid.reversible {
            self.onward(from, sight, ahead, !from.forward);
            self.miss_pulse(from, sight, ahead);
        }
        let mut extra = *from;
        extra.disturb(self.sort.extra, 0.0);
        self.no_edge(&extra, BROAD);
        if !self.grid.reversible {
            let mut to = *from;
            to.astray = true;
            to.score += BROAD - RARE;
            to.wander(sight);
            self.push(to, Seen::Astray);
        }
    }

    /// Moves in one direction to sectors of the class shown, the nearest of which is `ahead` forward steps away.
    fn onward(&mut self, from: &Hypothesis, sight: Sight, ahead: i64, forward: bool) {
        let classes = self.grid.classes();
        let nearest = if forward { ahead } else { classes - ahead };
        let nearest = if nearest == 0 { classes } else { nearest };
        if forward != from.forward && 2 * nearest > classes {
            return;
        }
        self.move_by(from, sight, nearest, forward);
        let (Some(speed), true) = (from.speed, forward == from.forward) else {
            return;
        };
        // Further ones only as the interval asks for them.
        let asked = (speed.log + from.log_interval(sight)).exp();
        let on = if forward { classes } else { -classes };
        let start = from.edge() + if forward { nearest } else { -nearest };
        let distance = |rounds: i64| self.grid.distance(from.edge(), start + rounds * on);
        if let Some(rounds) = (0..=MOST_LOST).find(|&rounds| distance(rounds) > asked) {
            for rounds in rounds - 1..=rounds + 1 {
                if rounds > 0 {
                    self.move_by(from, sight, nearest + rounds * classes, forward);
                }
            }
        }
    }

    /// Where a whole pulse of one channel is missing the other one goes on alone, which looks like a step back and one forward: two edges
    /// on, if the interval is that long, whatever the missing channel's level.
    fn miss_pulse(&mut self, from: &Hypothesis, sight: Sight, ahead: i64) {
        let back = if from.forward {
            self.grid.classes() - 1
        } else {
            1
        };
        let (Some(speed), true) = (from.speed, ahead == back && self.grid.classes() == 4) else {
            return;
        };
        let asked = (speed.log + from.log_interval(sight)).exp();
        if (1.5..2.5).contains(&asked) {
            let mut from = *from;
            from.score -= LEVEL;
            self.move_by(&from, sight, 2, from.forward);
        }
    }

    fn move_by(&mut self, from: &Hypothesis, sight: Sight, steps: i64, forward: bool) {
        let mut to = *from;
        to.sector += if forward { steps } else { -steps };
        to.forward = forward;
        to.ticks = sight.ticks;
        to.timed = true;
        to.skipped = false;
        let lost = steps - 1;
        if lost > 0 {
            if from.skipped && self.grid.reversible {
                // One too many and then one lost may be one edge with a stamp that is far off: that they come together saves nothing.
                to.trouble = 0.0;
            }
            to.disturb(RARE, self.sort.lost_more * (lost - 1) as f64);
        }
        let interval = self.interval(from, &to, sight);
        match from.speed {
            _ if forward != from.forward => {
                // To turn back, a shaft has to halve its speed first, or to take as long for the way there and back.
                // Once it has turned back or stood still, it goes on either way.
                let stands = from.timed && from.speed.is_none();
                to.score += if stands { BROAD } else { -REVERSAL };
                // No turn is abrupt that asks for no more than the shaft did elsewhere.
                to.score += from.speed.map_or(BROAD, |speed| {
                    let longer = speed.log + interval.log;
                    let asked = LN_2 + speed.log - interval.log - self.grid.reached.ln();
                    let short = (LN_2 - longer).min(asked);
                    broad(longer) - abrupt(short.clamp(0.0, LN_2), speed.variance)
                });
                to.speed = None;
            }
            Some(speed) => {
                let off = speed.off(interval);
                if self.grid.reversible && lost == 0 && off > 0.0 {
                    // It may have stood still in between, if it was slowing down.
                    let steady = (speed.slope - STOPS).max(0.0);
                    let mut still = to;
                    still.score += broad(off) - REVERSAL - abrupt(steady, speed.variance);
                    still.speed = None;
                    self.push(still, still.seen(false));
                }
                to.glide(&speed, self.sort.spread, interval, off);
            }
            None => {
                to.score += BROAD;
                if from.timed {
                    // It may stand still once more.
                    let mut still = to;
                    still.score += BROAD;
                    self.push(still, still.seen(lost > 0));
                    to.speed = Some(Speed::first(self.sort.spread, interval));
                    to.trouble *= CALM;
                }
            }
        }
        let fresh = !from.timed || lost > 0 && from.speed.is_none();
        self.push(to, to.seen(fresh));
    }

    fn no_edge(&mut self, from: &Hypothesis, score: f64) {
        let mut to = *from;
        to.skipped = !from.skipped || self.grid.classes() == 1;
        to.score += score;
        self.push(to, Seen::Extra);
    }

    /// Out of sight: it stays so, or this is an edge of any place.
    fn search(&mut self, from: &Hypothesis, sight: Sight, best: bool) {
        let mut astray = *from;
        astray.score += astray.wander(sight);
        self.push(astray, Seen::Astray);
        if !best {
            return;
        }
        let starts = self.grid.starts();
        for start in 1..=starts {
            let rank = from.edge() + start;
            let to = Hypothesis {
                astray: false,
                sector: rank,
                ticks: sight.ticks,
                timed: true,
                speed: None,
                score: from.score + 2.0 * BROAD - (starts as f64).ln(),
                ..*from
            };
            self.push(to, to.seen(true));
        }
    }

    fn push(&mut self, mut to: Hypothesis, seen: Seen) {
        self.nodes.push(Node {
            parent: to.node,
            seen,
        });
        to.node = Some(self.nodes.len() - 1);
        self.next.push(to);
    }

    /// Keeps what may still win, one hypothesis for each state.
    fn keep(&mut self) {
        std::mem::swap(&mut self.live, &mut self.next);
        // Nothing that comes will tell sectors apart that look alike, once the speed is the same, within what is plain.
        let alike = self.grid.alike();
        let speed = |h: &Hypothesis| h.speed.map(|speed| (speed.log / (PLAIN / 4.0)) as i64);
        let state = |h: &Hypothesis| {
            (!h.astray).then(|| (h.sector.rem_euclid(alike), h.forward, h.ticks, speed(h)))
        };
        self.live
            .sort_by(|a, b| state(a).cmp(&state(b)).then(b.score.total_cmp(&a.score)));
        self.live.dedup_by(|b, a| state(a) == state(b));
        let best = self.live.iter().map(|h| h.score).fold(f64::MIN, f64::max);
        self.live.retain(|h| h.score > best - SURE);
        let most = KEPT + 2 * self.grid.starts() as usize;
        if self.live.len() > most {
            self.live.sort_by(|a, b| b.score.total_cmp(&a.score));
            self.live.truncate(most);
        }
        if let [only] = &mut self.live[..] {
            let node = only.node.take();
            self.settle(node);
        }
    }

    /// Writes out what led to a node; nothing before it is open any more.
    fn settle(&mut self, mut node: Option<usize>) {
        let from = self.way.seen.len();
        while let Some(open) = node.map(|node| self.nodes[node]) {
            self.way.seen.push(open.seen);
            node = open.parent;
        }
        self.way.seen[from..].reverse();
        self.nodes.clear();
    }

    fn finish(mut self) -> Way {
        let best = self.live.iter().max_by(|a, b| a.score.total_cmp(&b.score));
        let Some(best) = best.copied() else {
            return self.way;
        };
        let ranks = self.grid.ranks();
        let elsewhere =
            |h: &&Hypothesis| !h.astray && (h.sector - best.sector).rem_euclid(ranks) != 0;
        let second = self.live.iter().filter(elsewhere).map(|h| h.score);
        self.way.lead = best.score - second.fold(f64::NEG_INFINITY, f64::max);
        self.way.score = best.score;
        self.settle(best.node);
        self.way
    }
}
