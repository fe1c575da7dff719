//! The client against the core's device without a socket between: sessions that end or are taken over, and pieces that are lost.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use quadcal::access::Key;
use quadcal::recalibrate::{Obstacle, Options, Stage};
use quadcal::wire::{LogLevel, Parser, Refusal, Reply, Request};
use quadcal_host::device::{Calibrated, Client, Fault, Port, Timing, Watching};
use quadcal_host::pretend::{Pretend, Running};

const KEY: Key = [9; 32];

/// A device that hosts share, each by a line of its own.
#[derive(Clone)]
struct Shared(Arc<Mutex<Running>>);

impl Shared {
    fn start(pretend: &Pretend) -> Self {
        Self(Arc::new(Mutex::new(pretend.start().unwrap())))
    }

    fn host(&self) -> Client<Line> {
        self.host_losing(|_| false)
    }

    /// A host that does not get those replies, counted from 1, for which `lost` says so.
    fn host_losing(&self, lost: impl Fn(u32) -> bool + Send + 'static) -> Client<Line> {
        let line = Line {
            device: self.clone(),
            coming: VecDeque::new(),
            lost: Box::new(lost),
            replies: 0,
        };
        let timing = Timing {
            read: Duration::from_millis(20),
            ..Timing::default()
        };
        Client::new(line, "here", timing, Some(KEY))
    }
}

struct Line {
    device: Shared,
    coming: VecDeque<u8>,
    lost: Box<dyn Fn(u32) -> bool + Send>,
    replies: u32,
}

impl Read for Line {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let mut device = self.device.0.lock().unwrap();
        device.step().unwrap();
        if self.coming.is_empty() {
            drop(device);
            thread::sleep(Duration::from_millis(5));
            return Err(io::ErrorKind::TimedOut.into());
        }
        // Pieces of any length, as lines give them.
        let bytes = &mut bytes[..7];
        self.coming.read(bytes)
    }
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut device = self.device.0.lock().unwrap();
        let sent = device.receive(bytes);
        drop(device);
        let mut parser = Parser::new();
        for byte in &sent {
            self.replies += u32::from(parser.push(*byte).is_some());
        }
        if !(self.lost)(self.replies) {
            self.coming.extend(sent);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Port for Line {
    fn set_wait(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}

fn small() -> Pretend {
    Pretend {
        lines: 64,
        r_min: 3000.0,
        key: KEY,
        ..Pretend::default()
    }
}

/// A device with a table in use, and that table.
fn calibrated() -> (Shared, Vec<u8>) {
    let device = Shared::start(&small());
    let mut host = device.host();
    let options = Options {
        turns: 12,
        ..Options::default()
    };
    let mut stages = Vec::new();
    let calibration = host.calibrate(&options, |status| {
        stages.push(status.stage);
        Watching::GoOn
    });
    assert_eq!(calibration.unwrap().end, Calibrated::Waiting);
    assert!(stages.contains(&Stage::Learning) && stages.contains(&Stage::Proving));
    assert_eq!(host.commit().unwrap().unwrap().sequence, 0);
    let slot = host.dump(|_, _| {}).unwrap();
    (device, slot)
}

#[test]
fn a_session_that_has_ended_is_opened_anew_and_one_taken_over_is_not() {
    let device = Shared::start(&small());
    let level = Request::LogLevel(LogLevel::Warn);
    let mut host = device.host();
    assert_eq!(host.change("log-level", &level).unwrap(), Reply::Done);
    // The device is restarted: it knows of no session.
    *device.0.lock().unwrap() = small().start().unwrap();
    assert_eq!(host.change("log-level", &level).unwrap(), Reply::Done);
    let mut other = device.host();
    assert_eq!(other.change("log-level", &level).unwrap(), Reply::Done);
    let taken = host.change("log-level", &level).unwrap_err();
    assert!(matches!(taken.fault, Fault::SessionTaken), "{taken}");
    assert!(host.change("log-level", &level).is_ok());
    host.close();
    assert!(!host.status().unwrap().session);
    // A client that is gone takes its session along, refused or not.
    host.change("commit", &Request::Commit).unwrap_err();
    assert!(host.status().unwrap().session);
    drop(host);
    assert!(!device.host().status().unwrap().session);
}

#[test]
fn a_lost_reply_is_asked_for_again_only_where_nothing_changes() {
    let device = Shared::start(&small());
    // The first two replies to whatever is asked.
    let mut host = device.host_losing(|reply| reply <= 2);
    assert_eq!(host.identify().unwrap().edges, 256);
    let mut host = device.host_losing(|reply| reply <= 3);
    let silent = host.identify().unwrap_err();
    assert!(
        matches!(
            silent.fault,
            Fault::Silent {
                tries: 3,
                bytes: 0,
                ..
            }
        ),
        "{silent}"
    );
    // Challenge, proof, and then the command's.
    let mut host = device.host_losing(|reply| reply == 3);
    let level = Request::LogLevel(LogLevel::Off);
    let unanswered = host.change("log-level", &level).unwrap_err();
    assert!(
        matches!(unanswered.fault, Fault::Unanswered { .. }),
        "{unanswered}"
    );
    assert_eq!(host.status().unwrap().log_level, LogLevel::Off);
    // That of the proof: the session is opened a second time.
    let mut host = device.host_losing(|reply| reply == 2);
    assert_eq!(host.change("log-level", &level).unwrap(), Reply::Done);
}

#[test]
fn a_table_gets_over_whichever_reply_is_lost() {
    let (device, slot) = calibrated();
    let pieces = slot.len().div_ceil(128) as u32;
    // After those for identity, challenge and proof.
    for lost in 4..=3 + pieces {
        let mut host = device.host_losing(move |reply| reply == lost);
        let mut reached = Vec::new();
        host.load(&slot, |done, whole| reached.push((done, whole)))
            .unwrap();
        assert_eq!(host.status().unwrap().stage, Stage::ReadyToCommit, "{lost}");
        assert!(reached.is_sorted(), "{reached:?}");
        host.change("abort", &Request::Abort).unwrap();
    }
    // But not over a line that is cut.
    let mut host = device.host_losing(|reply| reply > 6);
    let cut = host.load(&slot, |_, _| {}).unwrap_err();
    assert!(matches!(cut.fault, Fault::Silent { .. }), "{cut}");
    let mut host = device.host_losing(|reply| reply.is_multiple_of(3));
    assert!(host.dump(|_, _| {}).unwrap() == slot);
}

#[test]
fn a_calibration_that_is_stopped_or_aborted_by_another_leaves_the_device_idle() {
    let mut still = small();
    still.r_min = 0.0;
    let device = Shared::start(&still);
    let mut host = device.host();
    let stopped = host
        .calibrate(&Options::default(), |_| Watching::Stop)
        .unwrap();
    assert_eq!(stopped.end, Calibrated::Stopped);
    assert_eq!(host.status().unwrap().stage, Stage::Idle);
    let mut other = device.host();
    let mut looks = 0;
    let gone = host.calibrate(&Options::default(), |status| {
        looks += 1;
        if looks == 2 {
            assert_eq!(status.stage, Stage::WaitingForMotion);
            other.change("abort", &Request::Abort).unwrap();
        }
        Watching::GoOn
    });
    let gone = gone.unwrap_err();
    assert!(matches!(gone.fault, Fault::Gone), "{gone}");
}

#[test]
fn a_table_held_back_after_the_command_says_why_and_still_waits() {
    let device = Shared::start(&small());
    let mut host = device.host();
    let calibration = host.calibrate(&Options::default(), |_| Watching::GoOn);
    assert_eq!(calibration.unwrap().end, Calibrated::Waiting);
    // The shaft moves once the command, after status, challenge and proof, is answered, and before the main loop comes by.
    let shared = device.clone();
    let mut host = device.host_losing(move |reply| {
        if reply == 4 {
            let mut running = shared.0.lock().unwrap();
            running.hold_commits_back(Some(Obstacle::Moving));
        }
        false
    });
    let held = host.commit().unwrap_err();
    let moving = Refusal::Interlock(Obstacle::Moving);
    assert!(
        matches!(held.fault, Fault::Refused { refusal, .. } if refusal == moving),
        "{held}"
    );
    assert_eq!(host.status().unwrap().stage, Stage::ReadyToCommit);
    device.0.lock().unwrap().hold_commits_back(None);
    assert_eq!(host.commit().unwrap().unwrap().sequence, 0);
}

#[test]
fn a_device_may_be_silent_while_it_writes_flash() {
    let device = Shared::start(&small());
    let mut host = device.host();
    let options = Options::default();
    let calibration = host.calibrate(&options, |_| Watching::GoOn).unwrap();
    assert_eq!(calibration.end, Calibrated::Waiting);
    // After status, challenge, proof and the command itself; more replies than one request has tries.
    let mut host = device.host_losing(|reply| (5..15).contains(&reply));
    assert_eq!(host.commit().unwrap().unwrap().sequence, 0);
}

#[test]
fn a_lost_reply_to_the_commit_is_settled_by_the_status() {
    let (device, slot) = calibrated();
    let sequence = device.host().status().unwrap().table.unwrap().sequence;
    device.host().load(&slot, |_, _| {}).unwrap();
    // Status, challenge, proof, and then the command's.
    let mut host = device.host_losing(|reply| reply == 4);
    assert_eq!(host.commit().unwrap().unwrap().sequence, sequence + 1);
    // Where nothing waited, the table of before must not be taken for the new one.
    let lost = device.host_losing(|reply| reply == 4).commit().unwrap_err();
    assert!(matches!(lost.fault, Fault::Unanswered { .. }), "{lost}");
}

#[test]
fn a_key_is_needed_and_the_right_one() {
    let device = Shared::start(&Pretend {
        key: [1; 32],
        ..small()
    });
    let wrong = device
        .host()
        .change("commit", &Request::Commit)
        .unwrap_err();
    assert!(matches!(wrong.fault, Fault::WrongKey), "{wrong}");
    let refused = device.host().dump(|_, _| {}).unwrap_err();
    let none = matches!(
        refused.fault,
        Fault::Refused {
            refusal: Refusal::NoTable,
            ..
        }
    );
    assert!(none, "{refused}");
}
