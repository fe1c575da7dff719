//! Inputs: honest requests of a host that has the key, the same in a wrong way, and bytes of every kind.

use std::convert::Infallible;

use quadcal::access::KeyHolder;
use quadcal::recalibrate::{Options, SpeedWindow, Stage};
use quadcal::slot;
use quadcal::wire::{Draft, Kind, LogLevel, Piece, Refusal, Reply, Request, Seal};

use super::dice::Dice;
use super::rig::{EDGES, header};
use super::subject::{KEY, Subject};

/// Frames that are kept to be replayed and mutated.
const KEPT: usize = 32;

/// Writes inputs, and listens to what comes of them.
#[derive(Default)]
pub struct Author {
    /// A challenge that was not answered.
    nonce: Option<[u8; 16]>,
    /// Sent to open a session.
    asked: Option<KeyHolder>,
    session: Option<KeyHolder>,
    /// Of the session before.
    former: Option<KeyHolder>,
    frames: Vec<Vec<u8>>,
    /// How much of a table was handed over.
    handed: u32,
}

impl Author {
    /// Hears a reply.
    pub fn hear(&mut self, reply: &Reply) {
        match reply {
            Reply::Challenge { nonce } => self.nonce = Some(*nonce),
            Reply::Opened { .. } => {
                self.former = self.session.take();
                self.session = self.asked.take();
            }
            Reply::Written { next, whole } => self.handed = if *whole { 0 } else { *next },
            Reply::Refused(Refusal::Offset(next)) => self.handed = *next,
            Reply::Refused(Refusal::Table(_)) => self.handed = 0,
            _ => {}
        }
    }

    /// Time before the next input.
    pub fn pause_ms(&self, dice: &mut Dice) -> u64 {
        match dice.below(1000) {
            0 => dice.below(20_000) as u64,
            1..100 => dice.below(200) as u64,
            _ => dice.below(4) as u64,
        }
    }

    /// The next input.
    pub fn next(&mut self, dice: &mut Dice, subject: &Subject) -> Vec<u8> {
        let bytes = match dice.below(20) {
            0 => noise(dice),
            1 => framed(dice),
            2..4 => self.open_request(dice),
            4..6 => self.opening(dice),
            6..13 => self.honest(dice, subject),
            13..15 => self.dishonest(dice, subject),
            15 => self.kept(dice),
            16..19 => self.mutated(dice),
            _ => [self.kept(dice), self.mutated(dice)].concat(),
        };
        if !bytes.is_empty() && self.frames.len() < KEPT {
            self.frames.push(bytes.clone());
        } else if !self.frames.is_empty() && dice.once_in(4) {
            let at = dice.below(self.frames.len());
            self.frames[at].clone_from(&bytes);
        }
        bytes
    }

    fn kept(&self, dice: &mut Dice) -> Vec<u8> {
        let at = dice.below(self.frames.len());
        self.frames.get(at).cloned().unwrap_or_default()
    }

    fn mutated(&self, dice: &mut Dice) -> Vec<u8> {
        let mut bytes = self.kept(dice);
        for _ in 0..=dice.below(3) {
            let at = dice.below(bytes.len());
            match dice.below(5) {
                _ if bytes.is_empty() => {}
                0 => bytes[at] ^= 1 << dice.below(8),
                1 => bytes[at] = dice.byte(),
                2 => bytes.insert(at, dice.byte()),
                3 => drop(bytes.remove(at)),
                _ => bytes.truncate(at),
            }
        }
        bytes
    }

    fn open_request(&mut self, dice: &mut Dice) -> Vec<u8> {
        let request = match dice.below(8) {
            0 => Request::Identify,
            1 => Request::Status,
            2 => Request::Live,
            3 => Request::Result,
            4 => Request::Preview,
            5 => Request::ReadTable {
                offset: 32 * dice.below(8) as u32,
            },
            6 => Request::ReadTable {
                offset: dice.number() as u32,
            },
            _ => change(dice, None, 0),
        };
        frame(dice, Kind::Request, &request, None)
    }

    /// Challenge and answer, mostly the right one.
    fn opening(&mut self, dice: &mut Dice) -> Vec<u8> {
        let Some(nonce) = self.nonce.take() else {
            return frame(dice, Kind::Request, &Request::Challenge, None);
        };
        let mut key = KEY;
        if dice.once_in(3) {
            key[dice.below(32)] ^= 1 << dice.below(8);
        }
        let holder = KeyHolder::new(key, nonce);
        let proof = holder.proof();
        self.asked = Some(holder);
        frame(dice, Kind::Request, &Request::Open { proof }, None)
    }

    /// A sealed request as it should be.
    fn honest(&mut self, dice: &mut Dice, subject: &Subject) -> Vec<u8> {
        let request = change(dice, Some(subject.stage()), self.handed);
        match &mut self.session {
            Some(holder) => frame(
                dice,
                Kind::Sealed,
                &request,
                Some(&mut |signed| holder.seal(signed)),
            ),
            None => self.opening(dice),
        }
    }

    /// A sealed request with something wrong about it.
    fn dishonest(&mut self, dice: &mut Dice, subject: &Subject) -> Vec<u8> {
        let request = change(dice, Some(subject.stage()), self.handed);
        let wrong = dice.below(5);
        let bit = dice.below(128);
        let number = dice.number();
        let Some(holder) = &self.session else {
            return self.open_request(dice);
        };
        let (mut holder, former) = (holder.clone(), self.former.clone());
        let seal = &mut |signed: &[u8]| {
            let mut seal = holder.seal(signed);
            match wrong {
                0 => seal.mac[bit / 8] ^= 1 << (bit % 8),
                1 => seal.counter = number as u32,
                2 => seal.mac = [number as u8; 16],
                // Made over other bytes.
                3 => seal = holder.seal(&signed[..signed.len() - 1]),
                _ => {
                    if let Some(mut former) = former.clone() {
                        seal = former.seal(signed);
                        seal.counter = seal.counter.max(number as u32);
                    } else {
                        seal.mac.rotate_left(1);
                    }
                }
            }
            seal
        };
        frame(dice, Kind::Sealed, &request, Some(seal))
    }
}

type SealMaker<'a> = &'a mut dyn FnMut(&[u8]) -> Seal;

fn frame(dice: &mut Dice, kind: Kind, request: &Request, seal: Option<SealMaker<'_>>) -> Vec<u8> {
    let Some(draft) = Draft::new(kind, dice.bits() as u16, request) else {
        return Vec::new();
    };
    let seal = seal.map(|seal| seal(draft.signed()));
    draft.finish(seal).to_vec()
}

/// A request that changes something; where the stage is known, mostly one that leads on from it.
fn change(dice: &mut Dice, stage: Option<Stage>, handed: u32) -> Request {
    let window = if dice.once_in(8) {
        SpeedWindow {
            from: dice.number() as u32,
            to: dice.number() as u32,
        }
    } else {
        SpeedWindow::ANY
    };
    let start = Request::Start(Options {
        turns: (dice.number() >> 48) as u16,
        goal: dice.number() as u32,
        proof_turns: dice.below(9) as u8,
        torque_base: dice.byte().into(),
        hidden_up_to: dice.byte().into(),
        window,
        date: dice.number(),
    });
    match (dice.below(12), stage) {
        (0..5, Some(Stage::ReadyToCommit)) => Request::Commit,
        (0..3, Some(Stage::Idle | Stage::Done | Stage::Failed(_))) => start,
        (0..8, Some(Stage::Idle | Stage::Done | Stage::Failed(_))) => piece(dice, handed),
        // Let it go on.
        (0..7, Some(_)) => Request::LogLevel(LogLevel::Debug),
        (8, _) => Request::Abort,
        (9, _) => Request::RollBack,
        (10, _) if dice.once_in(4) => Request::Erase,
        (11, _) if dice.once_in(20) => Request::Close,
        (_, Some(_)) if dice.once_in(2) => Request::Commit,
        _ if dice.once_in(3) => piece(dice, handed),
        _ => start,
    }
}

/// The next piece of a table, mostly.
fn piece(dice: &mut Dice, handed: u32) -> Request {
    let mut bytes = table();
    let offset = if dice.once_in(10) {
        dice.number() as u32
    } else {
        handed
    };
    if dice.once_in(30) {
        let at = dice.below(bytes.len());
        bytes[at] ^= 1 << dice.below(8);
    }
    let from = (offset as usize).min(bytes.len());
    let to = (from + 1 + dice.below(128)).min(bytes.len());
    Request::WriteTable {
        offset,
        piece: Piece::from_slice(&bytes[from..to]).unwrap_or_default(),
    }
}

/// A slot of the device's encoder.
fn table() -> Vec<u8> {
    let mut bytes = Vec::new();
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let Ok(()) = slot::write(&header(), &[3_i16; EDGES], sink);
    bytes
}

/// Bytes of any kind, zeros among them.
fn noise(dice: &mut Dice) -> Vec<u8> {
    let length = dice.below(300);
    let zeros = dice.below(40) + 1;
    (0..length)
        .map(|_| if dice.once_in(zeros) { 0 } else { dice.byte() })
        .collect()
}

/// Any body in a whole frame.
fn framed(dice: &mut Dice) -> Vec<u8> {
    let mut body = vec![1, dice.below(4) as u8, dice.byte(), dice.byte()];
    if dice.once_in(10) {
        body[0] = dice.byte();
    }
    body.push(dice.below(18) as u8);
    for _ in 0..dice.below(200) {
        body.push(dice.byte());
    }
    let crc = crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
    body.extend(crc.to_le_bytes());
    let mut wire = vec![0; body.len() + 4];
    let length = cobs::try_encode_including_sentinels(&body, &mut wire).unwrap_or(0);
    wire.truncate(length);
    wire
}
