//! Rows in the middle of steady motion, read again: with a pulse taken out, with edges put in, or as they are.

use super::mender::{Mender, WINDOW};

/// Edges to either side that say how steady the motion is.
const AROUND: usize = 6;
/// What a fault must bring, in squared logarithms of intervals over what they should be: noise of a fifth makes none.
const FAULT: f64 = 0.2;
/// Most that an interval may be off, as a logarithm, once all is mended.
const OFF_MOST: f64 = 0.7;
/// The same where nothing but the interval's length says that edges are missing.
const OFF_MOST_TIMED: f64 = 0.3;
/// Longest pace over shortest in motion so steady that a length alone tells something.
const SPREAD_MOST: f64 = 1.6;
/// How much slower, as a logarithm, edges beside a gap may be on the mean.
const BESIDE_MOST: f64 = 0.15;
/// The same for the paces next to the interval, over the usual one.
const NEXT_TO_MOST: f64 = 1.25;
/// Longest pulse that no edge made, in edges.
const PULSE_MOST: f64 = 0.6;
/// Most edges lost at once that are counted on.
const LOST_MOST: i64 = 16;
/// So near a pulse, in edges, an edge may be part of it.
const NEAR: f64 = 0.25;

/// An edge as it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kept {
    /// Its number among the rows' edges.
    pub edge: Option<usize>,
    pub ticks: u64,
    pub state: i64,
    /// 1 forward, -1 in reverse, 0 of the first.
    pub way: i64,
    /// Ticks an edge before it.
    pub pace: f64,
}

impl Kept {
    pub const fn first(edge: usize, ticks: u64, state: i64) -> Self {
        Self {
            edge: Some(edge),
            ticks,
            state,
            way: 0,
            pace: 0.0,
        }
    }
}

/// Another reading of some rows.
#[derive(Clone, Debug)]
pub(super) struct Repair {
    /// Edges kept before it.
    pub from_kept: usize,
    /// Start and end of the pulse taken out.
    pub pulse: Option<[usize; 2]>,
    /// Edges too near the pulse for their times to be trusted.
    pub untimed: Vec<usize>,
    /// What is kept of it, and the edges each step stands for.
    pub kept: Vec<(Kept, i64)>,
    /// The next edge to be taken.
    pub next: usize,
}

/// The motion around some rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings {
    from_kept: usize,
    way: i64,
    pace: f64,
    slowest: f64,
    fastest: f64,
    /// Slower pace of those just before and after.
    next_to: f64,
}

impl Surroundings {
    /// Of rows from edge `first` on, after some edges that are kept; none where the shaft may turn round there.
    pub fn of(mender: &Mender, from_kept: usize, first: usize) -> Option<Self> {
        let kept = &mender.kept[..from_kept];
        let before = &kept[kept.len().saturating_sub(AROUND)..];
        let way = before.last()?.way;
        let mut paces: Vec<f64> = Vec::with_capacity(2 * AROUND);
        paces.extend(
            before
                .iter()
                .rev()
                .take_while(|k| k.way == way && way != 0)
                .map(|k| k.pace),
        );
        if paces.len() < 3 {
            return None;
        }
        let after = first + WINDOW;
        let (mut along, mut against) = (0, 0);
        for pair in mender.edges.get(after..)?.windows(2).take(AROUND) {
            let states = [
                mender.code.state(pair[0].levels),
                mender.code.state(pair[1].levels),
            ];
            let [Some(from), Some(to)] = states else {
                against += 1;
                continue;
            };
            // One channel does not tell its direction.
            let same = mender
                .way(from, to)
                .is_some_and(|step| step == way || mender.code.states() == 2);
            if same {
                along += 1;
                let from = Kept::first(0, pair[0].ticks, from);
                paces.push(mender.pace(&from, pair[1].ticks, way, 1));
            } else {
                against += 1;
            }
        }
        if along < 2 || against > 1 {
            return None;
        }
        let next_to = [paces[0], paces[paces.len() - along]];
        paces.sort_by(f64::total_cmp);
        // Another pulse close by cuts two intervals short.
        paces.drain(..2 * against);
        let pace = paces[paces.len() / 2];
        (paces[0] > 0.0).then_some(Self {
            from_kept,
            way,
            pace,
            fastest: paces[0],
            slowest: paces[paces.len() - 1],
            next_to: next_to[0].max(next_to[1]),
        })
    }

    fn spread(&self) -> f64 {
        self.slowest / self.fastest
    }

    /// Whether motion is so steady that a length alone tells something: a shaft that stops is slow just before, or just after.
    fn is_steady(&self) -> bool {
        self.spread() < SPREAD_MOST && self.next_to < NEXT_TO_MOST * self.pace
    }

    /// The reading that fits the motion best; none where it is as it stands or none fits.
    pub fn best(&self, mender: &Mender, first: usize) -> Option<Repair> {
        let mut best: Option<(f64, Repair)> = None;
        let mut pulses = vec![None];
        for from in first..=first + 1 {
            for to in from + 1..=from + 2 {
                pulses.push(Some([from, to]));
            }
        }
        for pulse in pulses {
            if let Some((cost, repair)) = self.read(mender, first, pulse)
                && best.as_ref().is_none_or(|(least, _)| cost < *least)
            {
                best = Some((cost, repair));
            }
        }
        let (_, repair) = best?;
        let plain = repair.pulse.is_none() && repair.kept.iter().all(|(_, edges)| *edges == 1);
        (!plain).then_some(repair)
    }

    /// Whether an edge came with a row that another channel made, after its own row was lost: late, as the edge after it shows.
    pub fn late(&self, mender: &Mender, at: usize) -> bool {
        const LATE_LEAST: f64 = 1.2;
        let Some((last, next)) = mender.kept[..self.from_kept]
            .last()
            .zip(mender.edges.get(at + 1))
        else {
            return false;
        };
        let whole = mender.pace(last, next.ticks, self.way, 2) / self.pace;
        let own = mender.pace(last, mender.edges[at].ticks, self.way, 1) / self.pace;
        self.is_steady() && own > LATE_LEAST && whole.ln().abs() < 0.5 * OFF_MOST_TIMED
    }

    /// A reading and how badly it fits.
    fn read(
        &self,
        mender: &Mender,
        first: usize,
        pulse: Option<[usize; 2]>,
    ) -> Option<(f64, Repair)> {
        let edges = &mender.edges;
        let states = mender.code.states();
        let mut cost = 0.0;
        let mut flip = 0;
        if let Some([from, to]) = pulse {
            flip = self.pulse_bit(mender, from, to)?;
            cost += FAULT;
        }
        let mut last = *mender.kept.get(self.from_kept.checked_sub(1)?)?;
        let mut off_before = (last.pace / self.pace).max(1e-3).ln();
        let mut kept = Vec::with_capacity(WINDOW);
        let mut untimed = Vec::new();
        let (mut only_timed, mut worst) = (false, 0.0_f64);
        // How slow the edges to both sides of a gap are.
        let (mut beside, mut before_gap, mut after_gap) = (0.0_f64, 0.0, false);
        let next = (first + WINDOW).min(edges.len());
        for (at, edge) in edges.iter().enumerate().take(next).skip(first) {
            let mut levels = edge.levels;
            if let Some([from, to]) = pulse {
                if at == from || at == to {
                    continue;
                }
                if at > from && at < to {
                    levels ^= flip;
                }
                let off = |end: usize| edges[end].ticks.abs_diff(edge.ticks) as f64;
                if off(from).min(off(to)) < NEAR * self.pace {
                    untimed.push(at);
                }
            }
            let state = mender.code.state(levels)?;
            let ahead = (self.way * (state - last.state)).rem_euclid(states);
            let least = if ahead == 0 { states } else { ahead };
            let ratio = mender
                .pace(&last, edge.ticks, self.way, 1)
                .max(1e-3 * self.pace)
                / self.pace;
            let rounds = ((ratio - least as f64) / states as f64).round().max(0.0) as i64;
            let weigh = |steps: i64| {
                let pace = mender.pace(&last, edge.ticks, self.way, steps);
                let off = (pace.max(1e-3 * self.pace) / self.pace).ln();
                (steps, off, off * off + if steps > 1 { FAULT } else { 0.0 })
            };
            let (few, many) = (weigh(least), weigh(least + rounds * states));
            let (steps, off, own) = if many.2 < few.2 { many } else { few };
            // Levels that jump say it themselves; a step on or back may be the shaft's own, and only its time tells.
            let timed = steps > 1 && (least == 1 || least + 1 >= states);
            let limit = if timed { OFF_MOST_TIMED } else { OFF_MOST };
            let doubtful = timed && !self.is_steady() || steps > LOST_MOST;
            if (steps > 1 || pulse.is_some()) && off.abs() > limit || doubtful {
                return None;
            }
            only_timed |= timed;
            worst = worst.max(off.abs());
            if after_gap {
                beside = beside.max(0.5 * (before_gap + off));
            }
            if timed {
                before_gap = off_before;
            }
            (after_gap, off_before) = (timed, off);
            cost += own;
            last = Kept {
                edge: Some(at),
                ticks: edge.ticks,
                state,
                way: self.way,
                pace: mender.pace(&last, edge.ticks, self.way, steps),
            };
            kept.push((last, steps));
        }
        // Edges beside the gap must keep the pace: a shaft that stops does not.
        if only_timed && (worst > OFF_MOST_TIMED || beside > BESIDE_MOST) {
            return None;
        }
        let repair = Repair {
            from_kept: self.from_kept,
            pulse,
            untimed,
            kept,
            next,
        };
        Some((cost, repair))
    }

    /// The channel's bit, where two edges are the ends of a pulse short enough to be no motion.
    fn pulse_bit(&self, mender: &Mender, from: usize, to: usize) -> Option<u8> {
        let edges = &mender.edges;
        let (start, end) = (edges.get(from)?, edges.get(to)?);
        let toggled = |at: usize| Some(edges[at].levels ^ edges.get(at.checked_sub(1)?)?.levels);
        let bit = toggled(from)?;
        let short = (end.ticks - start.ticks) as f64 <= PULSE_MOST * self.pace;
        let alike = bit.count_ones() == 1 && toggled(to)? == bit;
        (alike && short && self.spread() < 2.5).then_some(bit)
    }
}
