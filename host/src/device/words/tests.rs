//! Every text has its advice.

use super::*;

const OBSTACLES: [Obstacle; 7] = [
    Obstacle::Moving,
    Obstacle::Disabled,
    Obstacle::Fault,
    Obstacle::Supply,
    Obstacle::Temperature,
    Obstacle::Working,
    Obstacle::Other(3),
];

#[test]
fn whatever_a_device_refuses_is_said_with_what_to_do() {
    let stages = [
        Stage::Idle,
        Stage::Learning,
        Stage::ReadyToCommit,
        Stage::Committing,
    ];
    let failures = [
        WriteFailure::Flash,
        WriteFailure::TooLong,
        WriteFailure::WornOut,
        WriteFailure::Verify,
        WriteFailure::Missing,
    ];
    let faults = [
        TableFault::Header,
        TableFault::Shape,
        TableFault::Encoder,
        TableFault::Clock,
        TableFault::Crc,
    ];
    let mut refusals = vec![
        Refusal::Version(2),
        Refusal::Unknown,
        Refusal::NoSession,
        Refusal::WrongProof,
        Refusal::Replayed,
        Refusal::Wait(1500),
        Refusal::NoNonce,
        Refusal::Wear(9000),
        Refusal::Flash,
        Refusal::NothingOlder,
        Refusal::NoTable,
        Refusal::Offset(128),
        Refusal::Window,
    ];
    refusals.extend(stages.map(Refusal::Stage));
    refusals.extend(OBSTACLES.map(Refusal::Interlock));
    refusals.extend(failures.map(Refusal::NotWritten));
    refusals.extend(faults.map(Refusal::Table));
    let mut texts: Vec<String> = refusals.iter().map(refusal_text).collect();
    assert!(
        texts.contains(&"too many wrong keys were tried; wait 2 s, then give the right one".into())
    );
    assert!(texts.contains(&"the flash was written too often lately; wait 3 h".into()));
    let waits = [
        Waiting::Motion,
        Waiting::Speed,
        Waiting::Turn,
        Waiting::Solver,
        Waiting::Proof,
        Waiting::Commit,
        Waiting::Table,
    ];
    let mut ends: Vec<Failure> = waits.map(Failure::TimedOut).into();
    ends.extend(OBSTACLES.map(Failure::Interlock));
    ends.extend(failures.map(Failure::NotWritten));
    ends.extend([Failure::TooFewTurns(2), Failure::NotBetter]);
    texts.extend(ends.iter().map(failure_text));
    for text in &texts {
        let (what, advice) = text.split_once("; ").unwrap_or_else(|| panic!("{text}"));
        assert!(
            !what.is_empty() && !advice.is_empty() && !text.contains('\n'),
            "{text}"
        );
    }
}

#[test]
fn times_are_in_units_that_can_be_grasped_and_never_too_short() {
    let told = [1, 119, 120, 121, 7199, 7201].map(duration);
    assert_eq!(told, ["1 s", "119 s", "2 min", "3 min", "120 min", "3 h"]);
}
