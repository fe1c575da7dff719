//! Counts and times the turns of a recording as it is learned from, from edge 0 to edge 0.

use quadcal::estimate::Rejection;
use quadcal::step::{Flags, Outcome, Step};

use super::rejected::{RejectedTurn, RejectedTurns};

/// A turn by its number and start.
#[derive(Clone, Copy)]
struct Began {
    number: u64,
    ticks: u64,
}

/// The turns of one recording.
pub(super) struct TurnClock {
    edges: u64,
    /// Whether turns count from an index on, not from the first edge.
    indexed: bool,
    /// Edges since the last pass of edge 0.
    passed: u64,
    now: Option<Began>,
    /// The turn that the last pass of edge 0 ended, and how long it took.
    over: Option<(Began, u64)>,
    shortest: Option<u64>,
    longest: u64,
    rejected: RejectedTurns,
}

impl TurnClock {
    /// For a sensor of `edges` a turn.
    pub(super) fn new(edges: u32, indexed: bool) -> Self {
        Self {
            edges: edges.into(),
            indexed,
            passed: 0,
            now: None,
            over: None,
            shortest: None,
            longest: 0,
            rejected: RejectedTurns::default(),
        }
    }

    /// Takes what the decoder made of a row; before the estimator's verdict on it.
    pub(super) fn push(&mut self, outcome: &Outcome) {
        let Some(step) = outcome.step() else {
            return;
        };
        self.passed += u64::from(step.advance);
        if step.edge == 0 && (!self.indexed || step.flags.contains(Flags::REFERENCED)) {
            self.pass(&step);
        }
    }

    fn pass(&mut self, step: &Step) {
        let ticks = step.ticks;
        // Edge 0 comes again at once where a shaft turns back on it, or the index corrects the count: no new turn.
        let whole = 2 * self.passed > self.edges;
        let number = self.now.map_or(1, |began| began.number + u64::from(whole));
        self.over = self
            .now
            .replace(Began { number, ticks })
            .map(|began| (began, ticks.wrapping_sub(began.ticks)));
        self.passed = 0;
        if let (Some((began, duration)), Some(last)) = (self.over, self.rejected.last_mut())
            && last.duration.is_none()
            && last.number == began.number
        {
            last.duration = Some(duration);
        }
    }

    /// The turn that the last pass of edge 0 ended was taken.
    pub(super) fn take(&mut self) {
        let Some((_, duration)) = self.over else {
            return;
        };
        let shortest = self
            .shortest
            .map_or(duration, |shortest| shortest.min(duration));
        self.shortest = Some(shortest);
        self.longest = self.longest.max(duration);
    }

    /// A turn was not taken: the one that edge 0 ended if `outcome` is at edge 0, else the one under way.
    pub(super) fn reject(&mut self, reason: Rejection, outcome: &Outcome) {
        let ended = outcome.step().is_some_and(|step| step.edge == 0);
        let turn = match (ended, self.over, self.now) {
            (true, Some((began, duration)), _) => Some((began, Some(duration))),
            (_, _, now) => now.map(|began| (began, None)),
        };
        if let Some((began, duration)) = turn {
            self.rejected.push(RejectedTurn {
                number: began.number,
                start: began.ticks,
                duration,
                reason,
            });
        }
    }

    /// Durations of the shortest and the longest turn taken, ticks; zero where there was none.
    pub(super) fn range(&self) -> [u64; 2] {
        [self.shortest.unwrap_or(0), self.longest]
    }

    /// The turns not taken.
    pub(super) fn into_rejected(self) -> RejectedTurns {
        self.rejected
    }
}

#[cfg(test)]
mod tests {
    use quadcal::edge::Direction;

    use super::*;

    const EDGES: u32 = 8;

    fn step(ticks: u64, edge: u32, flags: Flags) -> Outcome {
        Outcome::Step(Step {
            ticks,
            edge,
            position: edge,
            interval: 10,
            resync: 0,
            advance: 1,
            flags,
            direction: Direction::Forward,
        })
    }

    /// A clock after so many edges, ten ticks each, the first being edge 4; the index is known from edge 0 on.
    fn after(edges: u64) -> (TurnClock, Outcome) {
        let mut clock = TurnClock::new(EDGES, true);
        let mut last = Outcome::Idle;
        for n in 0..edges {
            let flags = if n < 4 {
                Flags::NONE
            } else {
                Flags::REFERENCED
            };
            last = step(10 * n, ((n + 4) % u64::from(EDGES)) as u32, flags);
            clock.push(&last);
        }
        (clock, last)
    }

    #[test]
    fn a_turn_rejected_where_it_ends_is_the_one_that_ended() {
        let (mut clock, last) = after(4 + 8 + 8 + 1);
        clock.reject(Rejection::Disagrees, &last);
        let expected = RejectedTurn {
            number: 2,
            start: 120,
            duration: Some(80),
            reason: Rejection::Disagrees,
        };
        assert_eq!(clock.into_rejected().listed(), [expected]);
    }

    #[test]
    fn a_turn_rejected_in_its_midst_gets_its_duration_when_it_ends() {
        let (mut clock, last) = after(4 + 8 + 3);
        clock.reject(Rejection::Broken, &last);
        let listed = |clock: &TurnClock| clock.rejected.listed()[0];
        assert_eq!((listed(&clock).number, listed(&clock).start), (2, 120));
        assert_eq!(listed(&clock).duration, None);
        for n in 15..=20_u64 {
            clock.push(&step(10 * n, ((n + 4) % 8) as u32, Flags::REFERENCED));
        }
        assert_eq!(listed(&clock).duration, Some(80));
        assert_eq!(clock.now.map(|now| now.number), Some(3));
    }

    #[test]
    fn edge_0_passed_again_at_once_is_no_new_turn() {
        let (mut clock, _) = after(4 + 8 + 1);
        for n in 13..16 {
            clock.push(&step(10 * n, 0, Flags::REFERENCED));
        }
        assert_eq!(clock.now.map(|now| now.number), Some(2));
    }

    #[test]
    fn of_very_many_rejected_turns_the_first_thousand_are_listed() {
        let (mut clock, last) = after(4 + 8 + 3);
        for _ in 0..1234 {
            clock.reject(Rejection::Irregular, &last);
        }
        let rejected = clock.into_rejected();
        assert_eq!((rejected.listed().len(), rejected.more()), (1000, 234));
    }
}
