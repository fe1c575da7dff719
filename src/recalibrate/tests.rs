//! The machine against its drawing: a table of arrows, kept here apart from the code.

use super::*;
use crate::estimate::Advice;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::collections::BTreeSet;

/// Limits short enough for any of them to run out in a few events.
const LIMITS: Limits = Limits {
    motion_ms: 50,
    speed_ms: 60,
    steady_ms: 10,
    turn_ms: 40,
    solve_ms: 30,
    proof_ms: 45,
    commit_ms: 70,
    whole_ms: 200,
    window: SpeedWindow { from: 10, to: 100 },
};

/// States of the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    Idle,
    Waiting,
    Checking,
    Learning,
    Solving,
    Proving,
    Ready,
    Committing,
    Done,
    Failed,
}
use Node::{Checking, Committing, Done, Failed, Idle, Learning, Proving, Ready};

/// What stands at an arrow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cause {
    Start,
    Abort,
    Commit,
    HandedOver,
    Turns,
    Still,
    Steady,
    Leaves,
    Enough,
    Solved,
    TooFew,
    Better,
    NotBetter,
    Written,
    NotWritten,
    HeldBack,
    TimeIsOver,
    SaysNo,
}

/// What is done on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Act {
    Nothing,
    Prepare,
    Learn,
    Hold,
    Solve,
    Prove,
    Compare,
    Keep,
    Write,
    Release,
}

type Arrow = (&'static [Node], Cause, Node, Act);

const AT_REST: &[Node] = &[Idle, Done, Failed];
const AT_WORK: &[Node] = &[Node::Waiting, Checking, Learning, Node::Solving, Proving];
const ENDS: &[Node] = &[
    Node::Waiting,
    Checking,
    Learning,
    Node::Solving,
    Proving,
    Ready,
];
const ABORTED: &[Node] = &[
    Idle,
    Node::Waiting,
    Checking,
    Learning,
    Node::Solving,
    Proving,
    Ready,
    Done,
    Failed,
];

const DRAWING: &[Arrow] = &[
    (AT_REST, Cause::Start, Node::Waiting, Act::Prepare),
    (AT_REST, Cause::HandedOver, Ready, Act::Compare),
    (&[Node::Waiting], Cause::Turns, Checking, Act::Nothing),
    (&[Checking], Cause::Still, Node::Waiting, Act::Nothing),
    (&[Checking], Cause::Steady, Learning, Act::Learn),
    (&[Learning], Cause::Still, Node::Waiting, Act::Hold),
    (&[Learning], Cause::Leaves, Checking, Act::Hold),
    (&[Learning], Cause::Enough, Node::Solving, Act::Solve),
    (&[Node::Solving], Cause::Solved, Proving, Act::Prove),
    (&[Node::Solving], Cause::TooFew, Failed, Act::Release),
    (&[Proving], Cause::Better, Ready, Act::Keep),
    (&[Proving], Cause::NotBetter, Failed, Act::Release),
    (&[Ready], Cause::Commit, Committing, Act::Write),
    (&[Committing], Cause::HeldBack, Ready, Act::Keep),
    (&[Committing], Cause::Written, Done, Act::Nothing),
    (&[Committing], Cause::NotWritten, Failed, Act::Release),
    (ENDS, Cause::TimeIsOver, Failed, Act::Release),
    (AT_WORK, Cause::SaysNo, Failed, Act::Release),
    (ABORTED, Cause::Abort, Idle, Act::Release),
];

fn arrow(from: Node, cause: Cause) -> Option<(Node, Act)> {
    let fits = |arrow: &&Arrow| arrow.0.contains(&from) && arrow.1 == cause;
    let mut arrows = DRAWING.iter().filter(fits);
    let first = arrows.next().map(|arrow| (arrow.2, arrow.3));
    assert!(arrows.next().is_none());
    first
}

fn node(stage: Stage) -> Node {
    match stage {
        Stage::Idle => Idle,
        Stage::WaitingForMotion => Node::Waiting,
        Stage::CheckingSpeed => Checking,
        Stage::Learning => Learning,
        Stage::Solving => Node::Solving,
        Stage::Proving => Proving,
        Stage::ReadyToCommit => Ready,
        Stage::Committing => Committing,
        Stage::Done => Done,
        Stage::Failed(_) => Failed,
    }
}

fn act(action: Option<Action>) -> Act {
    match action {
        None => Act::Nothing,
        Some(Action::Prepare(_)) => Act::Prepare,
        Some(Action::Learn) => Act::Learn,
        Some(Action::Hold) => Act::Hold,
        Some(Action::Solve) => Act::Solve,
        Some(Action::Prove) => Act::Prove,
        Some(Action::Compare) => Act::Compare,
        Some(Action::Keep) => Act::Keep,
        Some(Action::Write(_)) => Act::Write,
        Some(Action::Release) => Act::Release,
    }
}

/// What the failure has to be.
fn says(failure: Failure) -> Cause {
    match failure {
        Failure::TimedOut(_) => Cause::TimeIsOver,
        Failure::Interlock(_) => Cause::SaysNo,
        Failure::TooFewTurns(_) => Cause::TooFew,
        Failure::NotBetter => Cause::NotBetter,
        Failure::NotWritten(_) => Cause::NotWritten,
    }
}

#[derive(Clone, Copy, Debug)]
struct Allows {
    calibrate: bool,
    commit: bool,
}

impl Interlock for Allows {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        self.calibrate.then_some(()).ok_or(Obstacle::Fault)
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        self.commit.then_some(()).ok_or(Obstacle::Moving)
    }
}

/// Follows the drawing with a pencil: which state, since when, and what was asked for.
#[derive(Clone, Copy, Debug)]
struct Pencil {
    at: Node,
    since: u64,
    began: u64,
    in_window_since: Option<u64>,
    options: Options,
}

impl Pencil {
    fn new() -> Self {
        Self {
            at: Idle,
            since: 0,
            began: 0,
            in_window_since: None,
            options: Options::default(),
        }
    }

    fn go(&mut self, cause: Cause, now: u64) -> Option<Act> {
        let (to, act) = arrow(self.at, cause)?;
        self.at = to;
        self.since = now;
        self.in_window_since = None;
        Some(act)
    }

    /// What ends a state before its event is looked at.
    fn ends(&self, now: u64, allows: Allows) -> Option<Cause> {
        let limit = match self.at {
            Node::Waiting => LIMITS.motion_ms,
            Checking => LIMITS.speed_ms,
            Learning => LIMITS.turn_ms,
            Node::Solving => LIMITS.solve_ms,
            Proving => LIMITS.proof_ms,
            Ready => LIMITS.commit_ms,
            _ => return None,
        };
        let unsolved = [Node::Waiting, Checking, Learning, Node::Solving].contains(&self.at);
        let late = now - self.since > u64::from(limit)
            || unsolved && now - self.began > u64::from(LIMITS.whole_ms);
        if !allows.calibrate && self.at != Ready {
            Some(Cause::SaysNo)
        } else {
            late.then_some(Cause::TimeIsOver)
        }
    }

    /// What an event stands for here; the second value: whether a command has to be refused.
    fn cause(&mut self, event: &Event, now: u64, allows: Allows) -> (Option<Cause>, bool) {
        let from = LIMITS.window.from.max(self.options.window.from);
        let to = LIMITS.window.to.min(self.options.window.to);
        let cause = match *event {
            Event::Start(options) => {
                let window = options.window;
                let any = window.from.max(10) <= window.to.min(100);
                let fits = AT_REST.contains(&self.at) && any && allows.calibrate;
                return (fits.then_some(Cause::Start), !fits);
            }
            Event::Abort => return (Some(Cause::Abort), self.at == Committing),
            Event::Commit => {
                let fits = self.at == Ready && allows.commit;
                return (fits.then_some(Cause::Commit), !fits);
            }
            Event::Loaded => return (Some(Cause::HandedOver), !AT_REST.contains(&self.at)),
            Event::Tick => None,
            Event::Motion(0) => Some(Cause::Still),
            Event::Motion(speed) => {
                let within = (from..=to).contains(&speed);
                match self.at {
                    Node::Waiting => Some(Cause::Turns),
                    Checking if within => {
                        let since = *self.in_window_since.get_or_insert(now);
                        (now - since >= u64::from(LIMITS.steady_ms)).then_some(Cause::Steady)
                    }
                    Checking => {
                        self.in_window_since = None;
                        None
                    }
                    _ => (!within).then_some(Cause::Leaves),
                }
            }
            Event::Turn(taken) => {
                if self.at == Learning {
                    self.since = now;
                }
                let most = u32::from(self.options.turns).max(6);
                let satisfied =
                    matches!(taken.advice, Some(Advice::GoalMet | Advice::NoFurtherGain));
                (taken.turns >= if satisfied { 6 } else { most }).then_some(Cause::Enough)
            }
            Event::Slice(Solving::Working(_)) => None,
            Event::Slice(Solving::Solved) => Some(Cause::Solved),
            Event::Slice(Solving::TooFewTurns(_)) => Some(Cause::TooFew),
            Event::Proof(figures) => {
                if self.at == Proving {
                    self.since = now;
                }
                let whole = figures.turns >= u32::from(self.options.proof_turns).max(4);
                whole.then_some(if figures.better {
                    Cause::Better
                } else {
                    Cause::NotBetter
                })
            }
            Event::HeldBack => Some(Cause::HeldBack),
            Event::Written(Ok(())) => Some(Cause::Written),
            Event::Written(Err(_)) => Some(Cause::NotWritten),
        };
        (cause, false)
    }

    /// Follows an event. What is to be done, whether a command is refused, and the arrows taken.
    fn follow(
        &mut self,
        event: &Event,
        now: u64,
        allows: Allows,
    ) -> (Act, bool, [Option<(Node, Cause)>; 2]) {
        let mut arrows = [None; 2];
        let mut done = Act::Nothing;
        if let Some(cause) = self.ends(now, allows) {
            arrows[0] = Some((self.at, cause));
            done = self.go(cause, now).unwrap();
        }
        let from = self.at;
        let (cause, refused) = self.cause(event, now, allows);
        if let Some(cause) = cause
            && let Some(act) = self.go(cause, now)
        {
            arrows[1] = Some((from, cause));
            if act != Act::Nothing {
                done = act;
            }
            if let Event::Start(options) = event {
                self.options = *options;
                self.began = now;
            }
            if let Event::Motion(speed) = event {
                let window = LIMITS.window.within(self.options.window);
                self.in_window_since =
                    (from == Node::Waiting && window.contains(*speed)).then_some(now);
            }
        }
        (done, refused, arrows)
    }
}

/// Lets both take an event and compares them.
fn both(
    machine: &mut Machine,
    pencil: &mut Pencil,
    event: Event,
    now: u64,
    allows: Allows,
    seen: &mut BTreeSet<(Node, Cause)>,
) {
    let (done, refused, arrows) = pencil.follow(&event, now, allows);
    let (action, result) = machine.take(event, now, &allows);
    assert_eq!(node(machine.stage()), pencil.at, "{event:?} at {now}");
    assert_eq!(act(action), done, "{event:?} at {now}");
    assert_eq!(result.is_err(), refused, "{event:?} at {now}");
    if let Stage::Failed(failure) = machine.stage()
        && let Some((_, cause)) = arrows.into_iter().flatten().last()
    {
        assert_eq!(says(failure), cause);
    }
    seen.extend(arrows.into_iter().flatten());
}

fn options() -> impl Strategy<Value = Options> {
    (0_u16..12, 0_u8..8, 0_u32..120, 5_u32..200).prop_map(|(turns, proof_turns, from, to)| {
        Options {
            turns,
            proof_turns,
            window: SpeedWindow { from, to },
            ..Options::default()
        }
    })
}

fn event() -> impl Strategy<Value = Event> {
    let advice = prop_oneof![
        Just(None),
        Just(Some(Advice::GoOn)),
        Just(Some(Advice::GoalMet)),
        Just(Some(Advice::NoFurtherGain)),
    ];
    prop_oneof![
        3 => options().prop_map(Event::Start),
        1 => Just(Event::Abort),
        3 => Just(Event::Commit),
        1 => Just(Event::Loaded),
        4 => Just(Event::Tick),
        12 => prop_oneof![1 => Just(0), 12 => 10_u32..100, 1 => any::<u32>()].prop_map(Event::Motion),
        4 => (0_u32..20, advice).prop_map(|(turns, advice)| Event::Turn(Taken { turns, advice })),
        4 => prop_oneof![Just(Solving::Working(5)), Just(Solving::Solved), Just(Solving::TooFewTurns(1))].prop_map(Event::Slice),
        4 => (0_u32..12, any::<bool>()).prop_map(|(turns, better)| Event::Proof(Figures { turns, better, ..Figures::default() })),
        4 => prop_oneof![
            Just(Event::HeldBack),
            Just(Event::Written(Ok(()))),
            Just(Event::Written(Err(WriteFailure::Verify))),
        ],
    ]
}

fn allows() -> impl Strategy<Value = Allows> {
    (prop::bool::weighted(0.98), prop::bool::weighted(0.7))
        .prop_map(|(calibrate, commit)| Allows { calibrate, commit })
}

/// Events with the time that has passed before each.
fn course() -> impl Strategy<Value = std::vec::Vec<(Event, u64, Allows)>> {
    let passed = prop_oneof![20 => 0_u64..8, 1 => 0_u64..300];
    prop::collection::vec((event(), passed, allows()), 1..400)
}

fn walk(course: std::vec::Vec<(Event, u64, Allows)>, seen: &mut BTreeSet<(Node, Cause)>) {
    let (mut machine, mut pencil, mut now) = (Machine::new(LIMITS), Pencil::new(), 0);
    for (event, passed, allows) in course {
        now += passed;
        both(&mut machine, &mut pencil, event, now, allows, seen);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn in_any_order_the_machine_does_what_is_drawn(course in course()) {
        walk(course, &mut BTreeSet::new());
    }
}

#[test]
fn every_arrow_of_the_drawing_is_walked() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut seen = BTreeSet::new();
    for _ in 0..3000 {
        let tree = course().new_tree(&mut runner).unwrap();
        walk(tree.current(), &mut seen);
    }
    let all = DRAWING
        .iter()
        .flat_map(|&(from, cause, _, _)| from.iter().map(move |from| (*from, cause)));
    let missing: std::vec::Vec<_> = all.filter(|arrow| !seen.contains(arrow)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
