//! The device and the model side by side: both see every byte, and what the device does has to be what the model allows.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::rc::Rc;

use quadcal::access::{AccessConfig, Key};
use quadcal::device::{Device, DeviceConfig};
use quadcal::recalibrate::{Limits, Stage, WearConfig};
use quadcal::store::{Layout, Store};
use quadcal::wire::{LogLevel, Parser, Refusal, Reply, Request};

use super::dice::Dice;
use super::flash::CountingFlash;
use super::model::{Model, Verdict};
use super::rig::{AnyBench, DiceNonces, Switch, shape};

/// The key of device and model.
pub const KEY: Key = *b"thirty-two bytes that nobody has";

const ACCESS: AccessConfig = AccessConfig {
    idle_ms: 5000,
    challenge_ms: 1000,
    free_failures: 3,
    wait_ms: 10,
    wait_max_ms: 100,
};

/// Short, so that every one of them runs out now and then.
const LIMITS: Limits = Limits {
    motion_ms: 2000,
    speed_ms: 2000,
    steady_ms: 5,
    turn_ms: 2000,
    solve_ms: 2000,
    proof_ms: 2000,
    commit_ms: 4000,
    whole_ms: 8000,
    window: quadcal::recalibrate::SpeedWindow::ANY,
};

/// What was seen, by name.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Counts.
    pub counts: BTreeMap<String, u64>,
}

impl Tally {
    fn add(&mut self, name: &str) {
        if let Some(count) = self.counts.get_mut(name) {
            *count += 1;
        } else {
            self.counts.insert(name.to_owned(), 1);
        }
    }

    /// Adds another's counts.
    pub fn merge(&mut self, other: &Self) {
        for (name, count) in &other.counts {
            *self.counts.entry(name.clone()).or_default() += count;
        }
    }
}

/// Everything that only an admitted request may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Changeable {
    flash: u64,
    bench: u64,
    stage: Stage,
    log_level: LogLevel,
}

/// A device and its model.
pub struct Subject {
    device: Device<CountingFlash, DiceNonces, Switch>,
    bench: AnyBench,
    model: Model,
    flash_changes: Rc<Cell<u64>>,
    closed: Rc<Cell<bool>>,
    dice: Dice,
    now_ms: u64,
    /// Whether a commit was admitted that was not yet written.
    commit_due: bool,
    stage: Stage,
}

impl Subject {
    /// A device that has just started.
    ///
    /// # Panics
    /// Where the flash of the test is wrong.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let flash = CountingFlash::default();
        let flash_changes = flash.changes.clone();
        let layout = Layout::new(&flash, [0..1024, 1024..2048], u32::MAX).expect("two places");
        let config = DeviceConfig {
            firmware: [0, 0, 1],
            shape: shape(),
            clock_hz: 1_000_000,
            serial: 0,
            limits: LIMITS,
            access: ACCESS,
            wear: WearConfig {
                burst: 4,
                refill_ms: 50,
            },
        };
        let switch = Switch::default();
        let closed = switch.closed.clone();
        let nonces = DiceNonces(Dice::new(!seed));
        let store = Store::new(flash, layout);
        let mut device = Device::new(config, KEY, store, nonces, switch, 0);
        let mut bench = AnyBench::new(seed ^ 0x5555);
        device.begin(&mut bench).expect("flash can be read");
        Self {
            device,
            bench,
            model: Model::new(ACCESS, &KEY),
            flash_changes,
            closed,
            dice: Dice::new(seed ^ 0xAAAA),
            now_ms: 0,
            commit_due: false,
            stage: Stage::Idle,
        }
    }

    /// Where the device's calibration stands.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.device.stage()
    }

    /// Time passes, and what the interlock allows may change.
    pub fn pass_time(&mut self, ms: u64) {
        self.now_ms += ms;
        self.closed.set(self.dice.once_in(60));
    }

    fn changeable(&self) -> Changeable {
        Changeable {
            flash: self.flash_changes.get(),
            bench: self.bench.changes,
            stage: self.device.stage(),
            log_level: self.device.log_level(),
        }
    }

    /// Feeds bytes; the replies.
    ///
    /// # Panics
    /// Where the device does what the model does not allow.
    pub fn feed(&mut self, bytes: &[u8], tally: &mut Tally) -> Vec<Reply> {
        let mut replies = Vec::new();
        for byte in bytes {
            let before = (*byte == 0).then(|| self.changeable());
            let verdict = self.model.push(*byte, self.now_ms);
            let sent = self.device.receive(*byte, self.now_ms, &mut self.bench);
            let reply = sent.as_ref().map(|sent| parsed(sent));
            let Some(before) = before else {
                assert_eq!(reply, None);
                continue;
            };
            let verdict = verdict.unwrap_or(Verdict::Silence);
            self.compare(&verdict, reply.as_ref(), before);
            tally.add(name_of(&verdict));
            if let Some(reply) = reply {
                tally.add(&name_of_reply(&reply));
                replies.push(reply);
            }
        }
        self.note_stage(tally);
        replies
    }

    fn compare(&mut self, verdict: &Verdict, reply: Option<&Reply>, before: Changeable) {
        if let Verdict::Admitted(request) = verdict {
            let refused = matches!(
                reply,
                None | Some(Reply::Refused(
                    Refusal::NoSession
                        | Refusal::WrongProof
                        | Refusal::Replayed
                        | Refusal::Wait(_)
                        | Refusal::Unknown
                        | Refusal::Version(_)
                ))
            );
            assert!(!refused, "{request:?} was admitted, {reply:?}");
            self.commit_due |= *request == Request::Commit && reply == Some(&Reply::Done);
            return;
        }
        let fits = match (verdict, reply) {
            (Verdict::Silence, reply) => reply.is_none(),
            (Verdict::Refused(refusal), Some(Reply::Refused(given))) => refusal == given,
            (Verdict::Challenge, Some(Reply::Challenge { nonce })) => {
                self.model.gave(*nonce, self.now_ms);
                true
            }
            (Verdict::Challenge, reply) => reply == Some(&Reply::Refused(Refusal::NoNonce)),
            (Verdict::Opened, reply) => matches!(reply, Some(Reply::Opened { .. })),
            (Verdict::Read, Some(reply)) => !matches!(reply, Reply::Done | Reply::Written { .. }),
            _ => false,
        };
        assert!(fits, "{verdict:?}, but {reply:?}");
        let after = self.changeable();
        assert_eq!(before, after, "changed without leave: {verdict:?}");
    }

    /// The main loop comes by.
    ///
    /// # Panics
    /// Where flash is written without leave.
    pub fn poll(&mut self, tally: &mut Tally) {
        let before = self.flash_changes.get();
        self.device.poll(self.now_ms, &mut self.bench);
        if self.flash_changes.get() != before {
            assert!(self.commit_due, "flash was written without leave");
            assert!(
                !self.closed.get(),
                "flash was written against the interlock"
            );
            tally.add("written");
        }
        if self.commit_due && self.device.stage() == Stage::ReadyToCommit {
            tally.add("held back");
        }
        self.commit_due &= self.device.stage() == Stage::Committing;
        self.note_stage(tally);
    }

    fn note_stage(&mut self, tally: &mut Tally) {
        let stage = self.device.stage();
        if stage != self.stage {
            self.stage = stage;
            let text = format!("{stage:?}");
            let name = text.split('(').take(2).collect::<Vec<_>>().join(" ");
            tally.add(&format!("stage {}", name.trim_end_matches(')')));
        }
    }
}

fn parsed(sent: &[u8]) -> Reply {
    let mut parser = Parser::new();
    let mut reply = None;
    for byte in sent {
        if let Some(frame) = parser.push(*byte) {
            reply = frame.expect("a whole frame").read();
        }
    }
    reply.expect("a reply")
}

const fn name_of(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Silence => "input without a frame",
        Verdict::Refused(_) => "refused",
        Verdict::Challenge => "challenge asked for",
        Verdict::Opened => "session opened",
        Verdict::Read => "read",
        Verdict::Admitted(_) => "admitted",
    }
}

fn name_of_reply(reply: &Reply) -> String {
    let text = format!("{reply:?}");
    let word = |text: &str| {
        let end = text.find(|c: char| !c.is_alphanumeric());
        text[..end.unwrap_or(text.len())].to_owned()
    };
    match reply {
        Reply::Refused(refusal) => format!("reply Refused {}", word(&format!("{refusal:?}"))),
        Reply::Written { whole: true, .. } => "reply Written, whole".to_owned(),
        _ => format!("reply {}", word(&text)),
    }
}
