//! A drive calibrated, committed, rolled back and loaded over its port.

mod drive;

use super::*;
use crate::recalibrate::{Failure, Figures, Obstacle, Options, SpeedWindow, Waiting, WriteFailure};
use crate::wire::tests::Wires;
use crate::wire::{Piece, Request, Status, TableFault, request_frame};
use drive::{Drive, EDGES, disc};
use std::vec::Vec;

/// A table that holds no errors.
fn blank() -> Vec<i16> {
    std::vec![0; EDGES as usize]
}

/// A drive whose learned table was committed.
fn calibrated() -> Drive {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), disc(1));
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert_eq!(drive.device.stage(), Stage::Done);
    drive
}

#[test]
fn by_command_it_learns_proves_commits_and_corrects_after_a_restart() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), disc(1));
    let raw = drive.turn(2);
    assert!(raw > 3_000_000);
    assert_eq!(drive.ask(&Request::Preview), Reply::Preview(None));
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    // Not before it is committed.
    assert_eq!(drive.turn(1), raw);
    let Reply::Preview(Some(figures)) = drive.ask(&Request::Preview) else {
        panic!("no preview")
    };
    assert!(figures.better && figures.turns == 8);
    // Ticks of a microsecond are 43,000 of 2^-32 turn.
    assert!(figures.new.interval < 30_000 && figures.old.interval > 2_000_000);
    assert!(figures.new.angle < 30_000 && figures.old.angle > 1_000_000);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    assert_eq!(drive.device.stage(), Stage::Committing);
    drive.turn(1);
    assert_eq!(drive.device.stage(), Stage::Done);
    assert!(drive.turn(1) < 100);
    let flash = drive.flash.clone();
    let mut restarted = Drive::new(&flash, &disc(1), blank());
    let table = restarted.status().table.unwrap();
    assert_eq!((table.sequence, table.serial), (0, 77));
    assert_eq!(table.learned_at, 1_800_000_000);
    assert!(restarted.turn(2) < 100);
}

#[test]
fn while_it_learns_and_proves_the_table_in_use_corrects() {
    let mut drive = calibrated();
    let start = Request::Start(Options::default());
    assert_eq!(drive.demand(&start), Reply::Done);
    let mut stages = Vec::new();
    for _ in 0..60 {
        assert!(drive.turn(1) < 100);
        stages.push(drive.device.stage());
    }
    assert!(stages.contains(&Stage::Learning) && stages.contains(&Stage::Proving));
    // It learned the same again, which is no better.
    assert_eq!(drive.device.stage(), Stage::Failed(Failure::NotBetter));
}

#[test]
fn a_table_that_is_not_better_is_refused_with_its_figures_and_flash_is_not_touched() {
    let mut drive = calibrated();
    let before = drive.flash.0.borrow().bytes.clone();
    drive.bench = {
        let flash = drive.flash.clone();
        let mut other = Drive::new(&flash, &disc(1), disc(2));
        let _ = other.status();
        other.bench
    };
    assert_eq!(drive.calibrate(), Stage::Failed(Failure::NotBetter));
    let Reply::Preview(Some(figures)) = drive.ask(&Request::Preview) else {
        panic!("no preview")
    };
    assert!(!figures.better && figures.new.interval > 10 * figures.old.interval);
    let stage = Reply::Refused(Refusal::Stage(Stage::Failed(Failure::NotBetter)));
    assert_eq!(drive.demand(&Request::Commit), stage);
    assert_eq!(drive.flash.0.borrow().bytes, before);
    assert!(drive.turn(1) < 100);
}

#[test]
fn without_a_session_everything_can_be_read_and_nothing_changed() {
    let mut drive = calibrated();
    let mut stranger = Drive::new(&drive.flash, &disc(1), disc(1));
    let before = stranger.flash.0.borrow().bytes.clone();
    for request in [
        Request::Identify,
        Request::Status,
        Request::Live,
        Request::Result,
        Request::Preview,
        Request::ReadTable { offset: 0 },
        Request::Challenge,
    ] {
        assert!(!matches!(stranger.ask(&request), Reply::Refused(_)));
    }
    for request in [
        Request::Start(Options::default()),
        Request::Abort,
        Request::Commit,
        Request::RollBack,
        Request::WriteTable {
            offset: 0,
            piece: Piece::from_slice(b"QCTB").unwrap(),
        },
        Request::Erase,
        Request::LogLevel(LogLevel::Off),
        Request::Close,
    ] {
        assert_eq!(stranger.ask(&request), Reply::Refused(Refusal::NoSession));
        // Nor in someone else's session, without a seal.
        assert_eq!(drive.ask(&request), Reply::Refused(Refusal::WrongProof));
    }
    assert_eq!(stranger.flash.0.borrow().bytes, before);
    assert_eq!(stranger.device.stage(), Stage::Idle);
    assert_eq!(stranger.device.log_level(), LogLevel::Info);
}

/// All bytes of the slot in use, as a host reads them.
fn dump(drive: &mut Drive) -> Vec<u8> {
    let mut bytes = Vec::new();
    loop {
        let offset = bytes.len() as u32;
        let Reply::Table { whole, piece, .. } = drive.ask(&Request::ReadTable { offset }) else {
            panic!("no table")
        };
        bytes.extend(piece);
        if bytes.len() == whole as usize {
            return bytes;
        }
    }
}

/// Hands a slot over; the last reply.
fn load(drive: &mut Drive, bytes: &[u8]) -> Reply {
    let mut last = Reply::Done;
    for (piece, at) in bytes.chunks(100).zip(0..) {
        let offset = 100 * at;
        let piece = Piece::from_slice(piece).unwrap();
        last = drive.demand(&Request::WriteTable { offset, piece });
    }
    last
}

#[test]
fn a_table_read_from_one_drive_works_in_another_with_the_same_disc() {
    let bytes = dump(&mut calibrated());
    assert_eq!(bytes.len(), 160 + 480 + 4);
    let mut other = Drive::new(&Drive::flash(), &disc(1), blank());
    let whole = Reply::Written {
        next: 644,
        whole: true,
    };
    assert_eq!(load(&mut other, &bytes), whole);
    assert_eq!(other.device.stage(), Stage::ReadyToCommit);
    assert_eq!(other.demand(&Request::Commit), Reply::Done);
    other.turn(1);
    assert!(other.turn(1) < 100);
    assert_eq!(dump(&mut other).len(), bytes.len());
}

/// What the preview says.
fn preview(drive: &mut Drive) -> Option<Figures> {
    match drive.ask(&Request::Preview) {
        Reply::Preview(figures) => figures,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_table_handed_over_is_held_against_the_one_in_use_on_fresh_turns_and_may_be_committed_anyway() {
    let own = dump(&mut calibrated());
    let mut stranger = Drive::new(&Drive::flash(), &disc(2), disc(2));
    assert_eq!(stranger.calibrate(), Stage::ReadyToCommit);
    assert_eq!(stranger.demand(&Request::Commit), Reply::Done);
    stranger.turn(1);
    let others = dump(&mut stranger);

    let mut drive = Drive::new(&Drive::flash(), &disc(1), blank());
    load(&mut drive, &own);
    assert_eq!(preview(&mut drive), None);
    let raw = drive.turn(8);
    assert!(raw > 3_000_000);
    let figures = preview(&mut drive).unwrap();
    assert!(figures.better && !figures.is_worse() && figures.turns >= 5);
    assert!(figures.new.interval < 30_000 && figures.old.interval > 2_000_000);
    assert_eq!(drive.device.stage(), Stage::ReadyToCommit);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert!(drive.turn(1) < 100);

    // The figures of the table before are not taken for the next one's.
    drive.rest(3_600_000);
    drive.leave();
    load(&mut drive, &others);
    assert_eq!(preview(&mut drive), None);
    assert!(drive.turn(8) < 100);
    let figures = preview(&mut drive).unwrap();
    assert!(!figures.better && figures.is_worse() && figures.turns >= 5);
    assert_eq!(drive.device.stage(), Stage::ReadyToCommit);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert_eq!(drive.device.stage(), Stage::Done);
    assert!(drive.turn(1) > 3_000_000);
}

#[test]
fn what_is_handed_over_wrongly_is_refused_by_name() {
    let bytes = dump(&mut calibrated());
    let mut drive = Drive::new(&Drive::flash(), &disc(1), blank());
    let mut wrong = bytes.clone();
    wrong[300] ^= 1;
    let crc = Reply::Refused(Refusal::Table(TableFault::Crc));
    assert_eq!(load(&mut drive, &wrong), crc);
    let piece = Piece::from_slice(&bytes[..100]).unwrap();
    let at = |offset| Request::WriteTable {
        offset,
        piece: piece.clone(),
    };
    assert_eq!(drive.demand(&at(5)), Reply::Refused(Refusal::Offset(0)));
    let next = Reply::Written {
        next: 100,
        whole: false,
    };
    assert_eq!(drive.demand(&at(0)), next);
    assert_eq!(drive.demand(&at(0)), next);
    assert_eq!(drive.demand(&at(50)), Reply::Refused(Refusal::Offset(100)));
    let mut stranger = bytes;
    stranger[100] = 78;
    let end = stranger.len() - 4;
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&stranger[..end]);
    stranger[end..].copy_from_slice(&crc.to_le_bytes());
    let other = Reply::Refused(Refusal::Table(TableFault::Encoder));
    assert_eq!(load(&mut drive, &stranger), other);
    assert_eq!(drive.flash.0.borrow().operations, 0);
}

#[test]
fn rolling_back_and_erasing_take_effect_at_once() {
    let mut drive = calibrated();
    let nothing = Reply::Refused(Refusal::NothingOlder);
    assert_eq!(drive.demand(&Request::RollBack), nothing);
    let sequence = |drive: &mut Drive| drive.status().table.map(|table| table.sequence);
    let hour = |drive: &mut Drive| {
        drive.rest(3_600_000);
        drive.leave();
    };
    hour(&mut drive);
    let bytes = dump(&mut drive);
    load(&mut drive, &bytes);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert_eq!(sequence(&mut drive), Some(1));
    assert_eq!(drive.demand(&Request::RollBack), Reply::Done);
    assert_eq!(sequence(&mut drive), Some(0));
    assert!(drive.turn(1) < 100);
    hour(&mut drive);
    assert_eq!(drive.demand(&Request::Erase), Reply::Done);
    assert_eq!(sequence(&mut drive), None);
    assert!(drive.turn(1) > 3_000_000);
    let flash = drive.flash.clone();
    assert_eq!(Drive::new(&flash, &disc(1), blank()).status().table, None);
}

#[test]
fn rolling_back_and_erasing_forget_what_the_calibration_before_came_to() {
    let mut drive = calibrated();
    assert!(preview(&mut drive).is_some());
    // Refused, so nothing has changed.
    let nothing = Reply::Refused(Refusal::NothingOlder);
    assert_eq!(drive.demand(&Request::RollBack), nothing);
    assert_eq!(drive.device.stage(), Stage::Done);
    assert!(preview(&mut drive).is_some());
    let hour = |drive: &mut Drive| {
        drive.rest(3_600_000);
        drive.leave();
    };
    hour(&mut drive);
    let bytes = dump(&mut drive);
    load(&mut drive, &bytes);
    drive.turn(8);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert!(preview(&mut drive).is_some());
    assert_eq!(drive.demand(&Request::RollBack), Reply::Done);
    assert_eq!(drive.device.stage(), Stage::Idle);
    assert_eq!(preview(&mut drive), None);
    hour(&mut drive);
    // It learns the same as is in use.
    assert_eq!(drive.calibrate(), Stage::Failed(Failure::NotBetter));
    assert!(preview(&mut drive).is_some());
    assert_eq!(drive.demand(&Request::Erase), Reply::Done);
    assert_eq!(drive.device.stage(), Stage::Idle);
    assert_eq!(preview(&mut drive), None);
}

#[test]
fn the_preview_goes_with_the_table_that_it_is_of() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), disc(1));
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    assert!(preview(&mut drive).is_some());
    assert_eq!(drive.demand(&Request::Abort), Reply::Done);
    assert_eq!(preview(&mut drive), None);
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    drive.rest(900_001);
    let late = Stage::Failed(Failure::TimedOut(Waiting::Commit));
    assert_eq!(drive.device.stage(), late);
    assert_eq!(preview(&mut drive), None);
}

#[test]
fn a_place_that_counts_after_all_is_adopted_before_the_other_one_is_written() {
    let mut drive = calibrated();
    let bytes = dump(&mut drive);
    let operations = |drive: &Drive| drive.flash.0.borrow().operations;
    let commit = |drive: &mut Drive| {
        drive.rest(3_600_000);
        drive.leave();
        load(drive, &bytes);
        assert_eq!(drive.demand(&Request::Commit), Reply::Done);
        drive.turn(1);
    };
    let before = operations(&drive);
    commit(&mut drive);
    let whole = operations(&drive) - before;
    let sequence = |drive: &mut Drive| drive.status().table.map(|table| table.sequence);
    assert_eq!(sequence(&mut drive), Some(1));
    // The last operation, which makes the table count, is done but reported to have failed.
    let all_bits = 1;
    drive.flash.0.borrow_mut().cut_at(whole - 1, all_bits);
    commit(&mut drive);
    let failed = Stage::Failed(Failure::NotWritten(WriteFailure::Flash));
    assert_eq!(drive.device.stage(), failed);
    assert_eq!(sequence(&mut drive), Some(1));
    drive.flash.0.borrow_mut().restore();
    // The next commit does not come as far as to erase, but its place is no longer the one in use.
    drive.flash.0.borrow_mut().cut_at(0, 0);
    commit(&mut drive);
    assert_eq!(drive.device.stage(), failed);
    assert_eq!(sequence(&mut drive), Some(2));
}

#[test]
fn a_table_that_waits_too_long_is_given_up() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), disc(1));
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    drive.rest(900_001);
    let late = Stage::Failed(Failure::TimedOut(Waiting::Commit));
    assert_eq!(drive.device.stage(), late);
    drive.leave();
    let refused = Reply::Refused(Refusal::Stage(late));
    assert_eq!(drive.demand(&Request::Commit), refused);
    assert_eq!(drive.flash.0.borrow().operations, 0);
}

#[test]
fn an_interlock_that_says_no_after_the_command_holds_the_table_back_with_flash_untouched() {
    let mut drive = calibrated();
    drive.rest(3_600_000);
    drive.leave();
    let bytes = dump(&mut drive);
    load(&mut drive, &bytes);
    let before = drive.flash.0.borrow().bytes.clone();
    let operations = drive.flash.0.borrow().operations;
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    assert_eq!(drive.device.stage(), Stage::Committing);
    drive.switches.commit.set(Some(Obstacle::Moving));
    assert!(drive.turn(1) < 100);
    assert_eq!(drive.device.stage(), Stage::ReadyToCommit);
    assert_eq!(drive.flash.0.borrow().operations, operations);
    assert_eq!(drive.flash.0.borrow().bytes, before);
    let refused = |obstacle| Reply::Refused(Refusal::Interlock(obstacle));
    assert_eq!(drive.demand(&Request::Commit), refused(Obstacle::Moving));
    assert_eq!(drive.device.stage(), Stage::ReadyToCommit);
    // No erasure was spent, and the table is still there to be committed.
    drive.switches.commit.set(None);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    assert_eq!(drive.device.stage(), Stage::Done);
    assert_eq!(drive.status().table.unwrap().sequence, 1);
    // What is done at once is asked for at once.
    let before = drive.flash.0.borrow().bytes.clone();
    drive.switches.commit.set(Some(Obstacle::Supply));
    for request in [Request::RollBack, Request::Erase] {
        assert_eq!(drive.demand(&request), refused(Obstacle::Supply));
    }
    assert_eq!(drive.flash.0.borrow().bytes, before);
}

#[test]
fn the_interlock_and_worn_flash_hold_commits_back() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), disc(1));
    drive.switches.calibrate.set(Some(Obstacle::Working));
    let refused = |obstacle| Reply::Refused(Refusal::Interlock(obstacle));
    let start = Request::Start(Options::default());
    assert_eq!(drive.demand(&start), refused(Obstacle::Working));
    drive.switches.calibrate.set(None);
    let none = Request::Start(Options {
        window: SpeedWindow { from: 9, to: 3 },
        ..Options::default()
    });
    assert_eq!(drive.demand(&none), Reply::Refused(Refusal::Window));
    assert_eq!(drive.calibrate(), Stage::ReadyToCommit);
    drive.switches.commit.set(Some(Obstacle::Moving));
    assert_eq!(drive.demand(&Request::Commit), refused(Obstacle::Moving));
    assert_eq!(drive.device.stage(), Stage::ReadyToCommit);
    drive.switches.commit.set(None);
    assert_eq!(drive.demand(&Request::Commit), Reply::Done);
    drive.turn(1);
    // One erasure after a start, and the next in an hour.
    let Reply::Refused(Refusal::Wear(seconds)) = drive.demand(&Request::Erase) else {
        panic!("erased")
    };
    assert!((3580..=3600).contains(&seconds));
    assert_eq!(drive.status().wear, [1, 0]);
    // Stopped in the midst of learning.
    assert_eq!(drive.demand(&start), Reply::Done);
    drive.turn(10);
    assert_eq!(drive.device.stage(), Stage::Learning);
    drive.switches.calibrate.set(Some(Obstacle::Fault));
    drive.turn(1);
    assert_eq!(
        drive.device.stage(),
        Stage::Failed(Failure::Interlock(Obstacle::Fault))
    );
}

#[test]
fn live_speed_is_rough_before_correction_and_even_after_and_zero_at_rest() {
    let mut drive = calibrated();
    let (mut rough, mut even) = (0.0_f64, 0.0_f64);
    for _ in 0..EDGES {
        drive.edge();
        let Reply::Live(live) = drive.ask(&Request::Live) else {
            panic!("not live")
        };
        // 10 turns a second at 1 MHz.
        let expected = 1e-5 * (1_u64 << 60) as f64;
        rough = rough.max((live.speed_raw as f64 / expected - 1.0).abs());
        even = even.max((live.speed as f64 / expected - 1.0).abs());
        assert!(live.referenced);
    }
    assert!(rough > 0.2 && even < 0.01, "{rough} {even}");
    drive.rest(600);
    let Reply::Live(live) = drive.ask(&Request::Live) else {
        panic!("not live")
    };
    assert_eq!((live.speed_raw, live.speed), (0, 0));
}

#[test]
fn frames_of_other_versions_are_answered_and_broken_ones_counted() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), blank());
    let mut body = Vec::from([9, 0, 5, 1, 0]);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
    body.extend(crc.to_le_bytes());
    let mut wire = [0; 32];
    let length = cobs::try_encode_including_sentinels(&body, &mut wire).unwrap();
    let version = Reply::Refused(Refusal::Version(VERSION));
    assert_eq!(drive.bytes(&wire[..length]), Some(version));
    wire[4] ^= 1;
    assert_eq!(drive.bytes(&wire[..length]), None);
    assert_eq!(drive.status().bad_frames, 2);
}

#[test]
fn a_port_is_served_in_bounded_pieces_without_waiting() {
    let mut drive = Drive::new(&Drive::flash(), &disc(1), blank());
    let mut given = std::vec![0x55; 2 * SERVED_BYTES];
    given.extend(request_frame(5, &Request::Identify));
    let mut port = Wires {
        given,
        at: 0,
        written: Vec::new(),
    };
    for served in 1..=3 {
        let Ok(()) = drive.device.serve(&mut port, 0, &mut drive.bench);
        assert_eq!(port.at, port.given.len().min(served * SERVED_BYTES));
    }
    let Reply::Identity(identity) = drive.ask(&Request::Identify) else {
        panic!("no identity")
    };
    assert_eq!((identity.edges, identity.serial), (EDGES, 77));
    assert_eq!(
        port.written,
        reply_frame(5, &Reply::Identity(identity)).as_slice()
    );
}
