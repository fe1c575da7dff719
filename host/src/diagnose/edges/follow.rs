//! The likeliest way of a shaft through a row of edges.
//!
//! A hypothesis says which sector the shaft is in and how fast it is. Each observation moves it on by one edge, by more where edges
//! were lost, back where the levels tell the direction, or is no edge at all. What a move costs is the likelihood of the interval
//! under a speed that changes smoothly, plus what the event itself costs. A wheel may also be lost sight of: then nothing is
//! expected, until the pattern of a turn is met again. The best hypotheses are kept until only one is left (Viterbi, with a beam).

use std::f64::consts::{LN_2, PI};

use super::grid::{Grid, Sight};

/// Natural log of the chance of an event for each edge: they are rare, but not unheard of.
mod cost {
    /// Edges lost at one place.
    pub const LOST: f64 = 8.0;
    /// Each edge more that is lost there: of one channel, and of several.
    pub const LOST_MORE: [f64; 2] = [1.0, 2.5];
    /// A pulse that is no edge: of one channel, and of several, where the levels allow a shaft that rocks as well.
    pub const EXTRA: [f64; 2] = [8.0, 12.0];
    /// Losing sight of the wheel.
    pub const ASTRAY: f64 = 8.0;
    /// A reversal of a shaft that was slowing down.
    pub const REVERSAL: f64 = 3.0;
    /// A reversal or a stop out of motion that was as steady as can be.
    pub const ABRUPT: f64 = 30.0;
}

/// Change of the log speed an edge of a shaft that will stand still before the next one: braked evenly it is 0.2 two edges before.
const STOPS: f64 = -0.1;
/// Share of intervals that no smooth speed explains.
const OUTLIERS: f64 = 1e-3;
/// Log likelihood of a log interval that nothing predicts.
const BROAD: f64 = -LN_2;
/// How much worse than the best a hypothesis may become, in log likelihood, before it is dropped.
const BEAM: f64 = 25.0;
/// Hypotheses kept beside the ranks of a turn.
const KEPT: usize = 48;
/// Rounds of classes that may be lost in a row before the place counts as unknown.
const MOST_LOST: i64 = 32;
/// Standard deviation of a log interval about its prediction: at least, and at a start and at most, where levels tell the direction or
/// not. What they tell leaves room for a motion that is anything but smooth.
const SPREAD_LEAST: f64 = 0.004;
const SPREAD_ONE: [f64; 2] = [0.3, 0.35];
const SPREAD_CODED: [f64; 2] = [0.7, 1.0];
/// Innovations that are plain whatever the spread: neither a lost edge nor one too many makes smaller ones.
const PLAIN: f64 = 0.2;
/// Gains of the speed and its slope, and of the spread's mean.
const GAINS: [f64; 3] = [0.6, 0.15, 0.08];

/// Share of its price that an event saves in a burst, and what an edge in between leaves of that.
const BURST: f64 = 0.6;
const CALM: f64 = 0.9;
/// Log speeds that count as the same.
const SAME_SPEED: f64 = 0.05;

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
    /// Prediction error of each observation's log interval; not a number where there is none.
    pub innovations: Vec<f32>,
    /// Log likelihood.
    pub score: f64,
    /// How much better it is than the best one that ends at another place of the turn.
    pub lead: f64,
}

/// Where a hypothesis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Known,
    Astray,
}

#[derive(Clone, Copy, Debug)]
struct Hypothesis {
    mode: Mode,
    /// Sector, and the edge crossed last.
    sector: i64,
    edge: i64,
    forward: bool,
    ticks: u64,
    /// Whether that is the time of an edge.
    timed: bool,
    /// Log speed in grid edges a tick, its slope an edge, and the variance of innovations; none before there is an interval.
    speed: Option<[f64; 3]>,
    /// Whether the last observation was no edge.
    skipped: bool,
    /// How near the last edge lost or too many is: 1 just behind it, then less and less.
    trouble: f64,
    score: f64,
    node: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    parent: usize,
    seen: Seen,
    innovation: f32,
}

/// No node.
const ROOT: usize = usize::MAX;

struct Follower<'a> {
    grid: &'a Grid,
    spread: [f64; 2],
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
    let mut follower = Follower {
        grid,
        spread: if grid.reversible {
            SPREAD_CODED
        } else {
            SPREAD_ONE
        },
        live: Vec::new(),
        next: Vec::new(),
        nodes: Vec::new(),
        way: Way::default(),
    };
    let (ticks, class) = start.unwrap_or_default();
    let (mode, sector) = match start {
        Some(_) => (Mode::Known, class.into()),
        None => (Mode::Astray, -1),
    };
    follower.live.push(Hypothesis {
        mode,
        sector,
        edge: sector,
        forward: true,
        ticks,
        timed: false,
        speed: None,
        skipped: false,
        trouble: 0.0,
        score: 0.0,
        node: ROOT,
    });
    for sight in sights {
        if !follower.plain_step(sight) {
            follower.step(sight);
        }
    }
    follower.finish()
}

/// Log likelihood of a log interval that is `r` off its prediction, and how sure it is that it belongs to smooth motion.
fn likelihood(r: f64, variance: f64) -> (f64, f64) {
    const HALF_LOG_TAU: f64 = 0.918_938_533_204_672_7;
    let inner = (-0.5 * r * r / variance).exp() / variance.sqrt() * (-HALF_LOG_TAU).exp();
    let outer = OUTLIERS / (PI * (1.0 + r * r));
    let sum = inner + outer;
    (sum.ln(), inner / sum)
}

/// Log likelihood of a log interval that is about as the last one and `r` off it (Cauchy).
fn broad(r: f64) -> f64 {
    -(PI * (1.0 + r * r)).ln()
}

impl Hypothesis {
    fn seen(&self, fresh: bool) -> Seen {
        Seen::Edge {
            rank: self.edge,
            forward: self.forward,
            fresh,
        }
    }

    fn log_interval(&self, sight: Sight) -> f64 {
        (sight.ticks.saturating_sub(self.ticks) as f64)
            .max(0.5)
            .ln()
    }

    /// Prediction error of the log interval for a way of `distance` edges.
    fn innovation(&self, log_interval: f64, distance: f64, speed: [f64; 3]) -> f64 {
        let ahead = speed[1] * 0.5 * (distance + 1.0).min(4.0);
        speed[0] + ahead + log_interval - distance.ln()
    }

    /// Goes on out of sight of the wheel, where an interval is about as long as the one before; its log likelihood.
    fn wander(&mut self, sight: Sight) -> f64 {
        let log_interval = self.log_interval(sight);
        let last = self.speed.replace([-log_interval, 0.0, 0.0]);
        self.skipped = false;
        self.ticks = sight.ticks;
        last.map_or(2.0 * BROAD, |[log_speed, ..]| {
            broad(log_speed + log_interval)
        })
    }

    /// Books edges lost or too many, of which the first is cheaper soon after others: they come in bursts.
    fn disturb(&mut self, first: f64, more: f64) {
        self.score -= first * (1.0 - BURST * self.trouble) + more;
        self.trouble = 1.0;
    }

    /// Takes an interval into the speed.
    fn learn(
        &mut self,
        [start, most]: [f64; 2],
        log_interval: f64,
        distance: f64,
        off: f64,
        sure: f64,
    ) {
        self.trouble *= CALM;
        let seen = distance.ln() - log_interval;
        let Some([log_speed, slope, variance]) = self.speed else {
            self.speed = Some([seen, 0.0, start * start]);
            return;
        };
        let gain = GAINS[0] * sure + (1.0 - sure);
        let square = (off * off).min(9.0 * variance);
        let spread = variance + GAINS[2] * sure * (square - variance);
        let loose = (off * off).min(start * start) * (1.0 - sure);
        // An innovation is what the interval lacks of speed: too long is too slow.
        self.speed = Some([
            log_speed + slope * 0.5 * (distance + 1.0).min(4.0) - gain * off,
            ((slope - GAINS[1] * off / distance) * sure).clamp(-0.3, 0.3),
            spread
                .max(loose)
                .clamp(SPREAD_LEAST * SPREAD_LEAST, most * most),
        ]);
    }
}

impl Follower<'_> {
    fn price(&self, [one, several]: [f64; 2]) -> f64 {
        if self.grid.reversible { several } else { one }
    }

    /// One edge on in smooth motion, where nothing else is worth a thought; none where it is.
    #[inline]
    fn plain(&self, from: &Hypothesis, sight: Sight) -> Option<(Hypothesis, f64)> {
        let (Mode::Known, Some(speed), false) = (from.mode, from.speed, from.skipped) else {
            return None;
        };
        let mut to = *from;
        let on = if to.forward { 1 } else { -1 };
        if self.grid.ahead(to.sector + on, sight.class?) != 0 {
            return None;
        }
        to.sector += on;
        to.edge += on;
        let distance = self.distance(from, &to);
        let log_interval = from.log_interval(sight);
        let off = from.innovation(log_interval, distance, speed);
        if off.abs() > PLAIN && (off * off > 6.0 * speed[2] || off.abs() > 2.0 * PLAIN) {
            return None;
        }
        let (score, sure) = likelihood(off, speed[2]);
        to.score += score;
        to.learn(self.spread, log_interval, distance, off, sure);
        to.ticks = sight.ticks;
        Some((to, off))
    }

    /// The plain step of a single hypothesis; false where there is none, and nothing was done.
    #[inline]
    fn plain_step(&mut self, sight: Sight) -> bool {
        let [hypothesis] = &self.live[..] else {
            return false;
        };
        let Some((to, off)) = self.plain(hypothesis, sight) else {
            return false;
        };
        self.way.seen.push(to.seen(false));
        self.way.innovations.push(off as f32);
        self.live[0] = to;
        true
    }

    fn step(&mut self, sight: Sight) {
        self.next.clear();
        let live = std::mem::take(&mut self.live);
        let best = live.iter().map(|h| h.score).fold(f64::MIN, f64::max);
        for hypothesis in &live {
            match hypothesis.mode {
                Mode::Known => self.moves(hypothesis, sight),
                Mode::Astray => self.search(hypothesis, sight, hypothesis.score >= best),
            }
        }
        self.live = live;
        self.keep();
    }

    /// All that a shaft whose place is known may have done.
    fn moves(&mut self, from: &Hypothesis, sight: Sight) {
        if let Some((to, off)) = self.plain(from, sight) {
            return self.push(to, to.seen(false), off);
        }
        let Some(class) = sight.class else {
            return self.no_edge(from, -self.price(cost::EXTRA));
        };
        let ahead = self.grid.ahead(from.sector, class);
        if from.skipped && ahead == 0 && self.grid.classes() > 1 {
            // The end of a pulse that was no edge.
            return self.no_edge(from, BROAD);
        }
        self.onward(from, sight, ahead, from.forward);
        if self.grid.reversible {
            self.onward(from, sight, ahead, !from.forward);
        }
        let mut extra = *from;
        extra.disturb(self.price(cost::EXTRA), 0.0);
        self.no_edge(&extra, BROAD);
        if !self.grid.reversible {
            let mut to = *from;
            to.mode = Mode::Astray;
            to.skipped = false;
            to.score += BROAD - cost::ASTRAY;
            to.wander(sight);
            self.push(to, Seen::Astray, f64::NAN);
        }
    }

    /// Moves in one direction to sectors of the class shown, the nearest of which is `ahead` forward steps away.
    fn onward(&mut self, from: &Hypothesis, sight: Sight, ahead: i64, forward: bool) {
        let classes = self.grid.classes();
        let nearest = match if forward { ahead } else { classes - ahead } {
            0 => classes,
            steps => steps,
        };
        if forward != from.forward && 2 * nearest > classes {
            return;
        }
        self.move_by(from, sight, nearest, forward);
        let (Some(speed), true) = (from.speed, forward == from.forward) else {
            return;
        };
        // Further ones only as the interval asks for them.
        let asked = (speed[0] + from.log_interval(sight)).exp();
        let on = if forward { classes } else { -classes };
        let start = from.edge + if forward { nearest } else { -nearest };
        let distance = |rounds: i64| self.grid.distance(from.edge, start + rounds * on);
        if let Some(rounds) = (0..=MOST_LOST).find(|&rounds| distance(rounds) > asked) {
            for rounds in rounds - 1..=rounds + 1 {
                if rounds > 0 {
                    self.move_by(from, sight, nearest + rounds * classes, forward);
                }
            }
        }
    }

    fn move_by(&mut self, from: &Hypothesis, sight: Sight, steps: i64, forward: bool) {
        let mut to = *from;
        to.sector += if forward { steps } else { -steps };
        to.edge = if forward { to.sector } else { to.sector + 1 };
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
            let more = self.price(cost::LOST_MORE) * (lost - 1) as f64;
            to.disturb(cost::LOST, more);
        }
        let log_interval = from.log_interval(sight);
        let mut innovation = f64::NAN;
        match from.speed {
            _ if forward != from.forward => {
                // To turn back, a shaft has to halve its speed first, or to take as long for the way there and back.
                // Once it has turned back or stood still, it goes on either way.
                let stands = from.timed && from.speed.is_none();
                to.score -= if stands { LN_2 } else { cost::REVERSAL };
                to.score += from.speed.map_or(BROAD, |[log_speed, _, variance]| {
                    let longer = log_speed + log_interval;
                    let halved = (LN_2 - longer).clamp(0.0, LN_2).powi(2) / (2.0 * variance);
                    broad(longer) - halved.min(cost::ABRUPT)
                });
                to.speed = None;
            }
            None => {
                to.score += BROAD;
                if from.timed {
                    // It may stand still once more.
                    let mut still = to;
                    still.score -= LN_2;
                    self.push(still, still.seen(lost > 0), f64::NAN);
                    let distance = self.distance(from, &to);
                    to.learn(self.spread, log_interval, distance, 0.0, 1.0);
                }
            }
            Some(speed) => {
                let distance = self.distance(from, &to);
                let off = from.innovation(log_interval, distance, speed);
                if self.grid.reversible && lost == 0 && off > 0.0 {
                    // It may have stood still in between, if it was slowing down.
                    let steady = (speed[1] - STOPS).max(0.0).powi(2) / (2.0 * speed[2]);
                    let mut still = to;
                    still.score += broad(off) - cost::REVERSAL - steady.min(cost::ABRUPT);
                    still.speed = None;
                    self.push(still, still.seen(false), f64::NAN);
                }
                let (score, sure) = likelihood(off, speed[2]);
                to.score += score;
                to.learn(self.spread, log_interval, distance, off, sure);
                innovation = off;
            }
        }
        let fresh = !from.timed || lost > 0 && from.speed.is_none();
        self.push(to, to.seen(fresh), innovation);
    }

    fn distance(&self, from: &Hypothesis, to: &Hypothesis) -> f64 {
        self.grid.distance(from.edge, to.edge)
    }

    fn no_edge(&mut self, from: &Hypothesis, score: f64) {
        let mut to = *from;
        to.skipped = !from.skipped || self.grid.classes() == 1;
        to.score += score;
        self.push(to, Seen::Extra, f64::NAN);
    }

    /// Out of sight: it stays so, or this is an edge of any place.
    fn search(&mut self, from: &Hypothesis, sight: Sight, best: bool) {
        let mut astray = *from;
        astray.score += astray.wander(sight);
        self.push(astray, Seen::Astray, f64::NAN);
        if !best {
            return;
        }
        let starts = self.grid.starts();
        for start in 1..=starts {
            let rank = from.edge + start;
            let to = Hypothesis {
                mode: Mode::Known,
                sector: rank,
                edge: rank,
                ticks: sight.ticks,
                timed: true,
                speed: None,
                score: from.score + 2.0 * BROAD - (starts as f64).ln(),
                ..*from
            };
            self.push(to, to.seen(true), f64::NAN);
        }
    }

    fn push(&mut self, mut to: Hypothesis, seen: Seen, innovation: f64) {
        self.nodes.push(Node {
            parent: to.node,
            seen,
            innovation: innovation as f32,
        });
        to.node = self.nodes.len() - 1;
        self.next.push(to);
    }

    /// Keeps what may still win, one hypothesis for each state.
    fn keep(&mut self) {
        std::mem::swap(&mut self.live, &mut self.next);
        // Nothing that comes will tell sectors apart that look alike, once the speed is the same.
        let alike = self.grid.alike();
        let speed = |h: &Hypothesis| {
            h.speed
                .map(|[log_speed, ..]| (log_speed / SAME_SPEED) as i64)
        };
        let state = |h: &Hypothesis| match h.mode {
            Mode::Known => Some((h.sector.rem_euclid(alike), h.forward, h.ticks, speed(h))),
            Mode::Astray => None,
        };
        self.live
            .sort_by(|a, b| state(a).cmp(&state(b)).then(b.score.total_cmp(&a.score)));
        self.live.dedup_by(|b, a| state(a) == state(b));
        let best = self.live.iter().map(|h| h.score).fold(f64::MIN, f64::max);
        self.live.retain(|h| h.score > best - BEAM);
        let most = KEPT + 2 * self.grid.starts() as usize;
        if self.live.len() > most {
            self.live.sort_by(|a, b| b.score.total_cmp(&a.score));
            self.live.truncate(most);
        }
        if self.live.len() == 1 {
            let node = self.live[0].node;
            self.settle(node);
            self.live[0].node = ROOT;
        }
    }

    /// Writes out what led to a node; nothing before it is open any more.
    fn settle(&mut self, node: usize) {
        let from = self.way.seen.len();
        let mut at = node;
        while let Some(node) = self.nodes.get(at) {
            self.way.seen.push(node.seen);
            self.way.innovations.push(node.innovation);
            at = node.parent;
        }
        self.way.seen[from..].reverse();
        self.way.innovations[from..].reverse();
        self.nodes.clear();
    }

    fn finish(mut self) -> Way {
        let best = self.live.iter().max_by(|a, b| a.score.total_cmp(&b.score));
        let Some(best) = best.copied() else {
            return self.way;
        };
        let ranks = self.grid.ranks();
        let elsewhere = |h: &&Hypothesis| {
            h.mode == Mode::Known && (h.sector - best.sector).rem_euclid(ranks) != 0
        };
        let second = self.live.iter().filter(elsewhere).map(|h| h.score);
        self.way.lead = best.score - second.fold(f64::NEG_INFINITY, f64::max);
        self.way.score = best.score;
        self.settle(best.node);
        self.way
    }
}
