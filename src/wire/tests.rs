//! The documented bytes, frames through noise, and messages at their longest.

use std::format;
use std::string::String;
use std::vec::Vec;

use super::*;
use crate::recalibrate::{
    Failure, Figures, Obstacle, Options, Scatter, SpeedWindow, Stage, Waiting,
};
use proptest::prelude::*;

fn requests() -> Vec<(&'static str, Request)> {
    let options = Options {
        turns: 32,
        goal: 2000,
        proof_turns: 8,
        torque_base: 5,
        hidden_up_to: 0,
        window: SpeedWindow {
            from: 10_000,
            to: 3_000_000,
        },
        date: 1_800_000_000,
    };
    std::vec![
        ("identify", Request::Identify),
        ("status", Request::Status),
        ("live", Request::Live),
        ("result", Request::Result),
        ("preview", Request::Preview),
        ("read table", Request::ReadTable { offset: 384 }),
        ("challenge", Request::Challenge),
        ("open", Request::Open { proof: proof() }),
        ("start", Request::Start(options)),
        ("abort", Request::Abort),
        ("commit", Request::Commit),
        ("roll back", Request::RollBack),
        (
            "write table",
            Request::WriteTable {
                offset: 128,
                piece: Piece::from_slice(b"QCTB").unwrap()
            }
        ),
        ("erase", Request::Erase),
        ("log level", Request::LogLevel(LogLevel::Debug)),
        ("close", Request::Close),
    ]
}

fn proof() -> MacBytes {
    core::array::from_fn(|i| i as u8)
}

fn table(value: u32) -> TableInfo {
    TableInfo {
        place: 1,
        sequence: value,
        turns: value,
        standard_error: value,
        table_rms: value,
        serial: value.into(),
        learned_at: value.into(),
        temperature_q4: Some(-16),
    }
}

fn replies() -> Vec<(&'static str, Reply)> {
    let status = Status {
        stage: Stage::Failed(Failure::TimedOut(Waiting::Turn)),
        turns: 11,
        turns_wanted: 32,
        rejected: 2,
        solved_percent: 40,
        session: true,
        table: Some(table(300)),
        wear: [4, 3],
        log_level: LogLevel::Info,
        bad_frames: 1,
        uptime_ms: 65_536,
    };
    let live = Live {
        ticks: 84_000_000,
        angle: 1 << 31,
        referenced: true,
        speed_raw: -64,
        speed: 64,
        faults: [0, 1, 2, 3, 4, 5, 6],
    };
    let learned = Learned {
        turns: 11,
        rejected: 2,
        standard_error: 2000,
        class_standard_error: 20,
        table_rms: 60_000,
        class_offsets: [-1, 1, -2, 2, 0, 0],
        class_delays: [0; 6],
    };
    let figures = Figures {
        turns: 8,
        rejected: 1,
        old: Scatter {
            interval: 90_000,
            angle: 60_000,
        },
        new: Scatter {
            interval: 300,
            angle: 2000,
        },
        better: true,
    };
    std::vec![
        ("done", Reply::Done),
        (
            "refused",
            Reply::Refused(Refusal::Interlock(Obstacle::Moving))
        ),
        (
            "identity",
            Reply::Identity(Identity {
                firmware: [1, 2, 3],
                slot_version: 3,
                edges: 10_000,
                classes: 4,
                clock_hz: 84_000_000,
                serial: 77,
            })
        ),
        ("status", Reply::Status(status)),
        ("live", Reply::Live(live)),
        ("result", Reply::Result(Some(learned))),
        ("preview", Reply::Preview(Some(figures))),
        (
            "table",
            Reply::Table {
                offset: 0,
                whole: 20_164,
                piece: Piece::from_slice(b"QCTB").unwrap()
            }
        ),
        ("challenge", Reply::Challenge { nonce: proof() }),
        ("opened", Reply::Opened { idle_ms: 300_000 }),
        (
            "written",
            Reply::Written {
                next: 132,
                whole: false
            }
        ),
    ]
}

fn hex(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.join(" ")
}

/// All frames as the module's head shows them, with what they are on the wire.
fn documented() -> (String, Vec<WireBytes>) {
    let mut text = String::new();
    let mut wires = Vec::new();
    let mut show = |name: &str, kind: Kind, draft: Draft, seal: Option<Seal>| {
        let wire = draft.clone().finish(seal);
        let mut stuffed = wire.clone();
        let frame = stuffed.len() - 1;
        let length = cobs::decode_in_place(&mut stuffed[1..frame]).unwrap();
        let body = &stuffed[1..=length];
        let (head, rest) = body.split_at(4);
        let (message, end) = rest.split_at(draft.signed().len() - 4);
        let (seal, crc) = end.split_at(end.len() - 4);
        let seal = if kind == Kind::Sealed {
            format!(" | {} | {}", hex(&seal[..4]), hex(&seal[4..]))
        } else {
            String::new()
        };
        text += &format!(
            "{name:<12} {} | {}{seal} | {}\n",
            hex(head),
            hex(message),
            hex(crc)
        );
        wires.push(wire);
    };
    for (name, request) in requests() {
        let open = request.is_open_to_all();
        let kind = if open { Kind::Request } else { Kind::Sealed };
        let seal = (!open).then(|| Seal {
            counter: 7,
            mac: proof(),
        });
        show(name, kind, Draft::new(kind, 1, &request).unwrap(), seal);
    }
    for (name, reply) in replies() {
        show(
            name,
            Kind::Reply,
            Draft::new(Kind::Reply, 1, &reply).unwrap(),
            None,
        );
    }
    (text, wires)
}

#[test]
fn every_message_has_the_documented_bytes() {
    let (text, _) = documented();
    assert!(text == include_str!("frames.txt"), "frames.txt:\n{text}");
    assert_eq!(
        hex(&request_frame(1, &Request::Identify)),
        "00 02 01 02 01 01 05 9a b4 80 fa 00"
    );
}

#[test]
fn every_message_comes_back_as_it_was_sent() {
    let (_, wires) = documented();
    let requests = requests();
    let replies = replies();
    let mut parser = Parser::new();
    for (at, wire) in wires.iter().enumerate() {
        assert!(wire[1..wire.len() - 1].iter().all(|byte| *byte != 0));
        let mut found = 0;
        for byte in wire {
            let Some(frame) = parser.push(*byte) else {
                continue;
            };
            let frame = frame.unwrap();
            found += 1;
            assert_eq!(frame.number, 1);
            if let Some((_, request)) = requests.get(at) {
                assert_eq!(frame.read::<Request>().as_ref(), Some(request));
                assert_eq!(frame.seal.is_some(), !request.is_open_to_all());
                assert!(frame.seal.is_none_or(|seal| seal.mac == proof()));
            } else {
                let reply = &replies[at - requests.len()].1;
                assert_eq!(frame.read::<Reply>().as_ref(), Some(reply));
            }
        }
        assert_eq!(found, 1);
    }
}

#[test]
fn the_longest_messages_fit_a_frame() {
    let full = Piece::from_slice(&[0xA5; PIECE_BYTES]).unwrap();
    let longest = Request::WriteTable {
        offset: u32::MAX,
        piece: full.clone(),
    };
    let draft = Draft::new(Kind::Sealed, u16::MAX, &longest).unwrap();
    let seal = Seal {
        counter: u32::MAX,
        mac: [0xFF; MAC_BYTES],
    };
    let wire = draft.finish(Some(seal));
    assert!(wire.len() > 160 && wire.len() <= FRAME_MAX);
    let most = u32::MAX;
    let replies = [
        Reply::Table {
            offset: most,
            whole: most,
            piece: full,
        },
        Reply::Status(Status {
            stage: Stage::Failed(Failure::TooFewTurns(most)),
            turns: most,
            turns_wanted: most,
            rejected: most,
            solved_percent: 255,
            session: true,
            table: Some(TableInfo {
                serial: u64::MAX,
                learned_at: u64::MAX,
                temperature_q4: Some(i16::MIN),
                ..table(most)
            }),
            wear: [most; 2],
            log_level: LogLevel::Debug,
            bad_frames: most,
            uptime_ms: u64::MAX,
        }),
        Reply::Live(Live {
            ticks: u64::MAX,
            angle: most,
            referenced: true,
            speed_raw: i64::MIN,
            speed: i64::MIN,
            faults: [most; 7],
        }),
        Reply::Result(Some(Learned {
            turns: most,
            rejected: most,
            standard_error: most,
            class_standard_error: most,
            table_rms: most,
            class_offsets: [i32::MIN; 6],
            class_delays: [i32::MIN; 6],
        })),
    ];
    for reply in replies {
        let wire = reply_frame(u16::MAX, &reply);
        assert!(wire.len() > 60 && wire.len() <= FRAME_MAX);
    }
    assert_eq!((MESSAGE_MAX, BODY_MAX, FRAME_MAX), (160, 188, 191));
}

#[test]
fn a_frame_of_another_version_says_so_and_a_message_with_bytes_left_over_is_none() {
    let mut body = Vec::from([9, 0, 5, 1, 0]);
    let crc = |body: &[u8]| crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(body);
    body.extend(crc(&body).to_le_bytes());
    let version = FrameError::Version {
        version: 9,
        number: 0x105,
    };
    assert_eq!(Frame::parse(&body), Err(version));
    let mut body = Vec::from([VERSION, 0, 5, 1, 0, 0]);
    body.extend(crc(&body).to_le_bytes());
    let frame = Frame::parse(&body).unwrap();
    assert_eq!(frame.read::<Request>(), None);
    body[1] = 3;
    let body = [&body[..6], &crc(&body[..6]).to_le_bytes()].concat();
    assert_eq!(Frame::parse(&body), Err(FrameError::Kind(3)));
}

#[test]
fn any_single_bit_flipped_costs_the_frame() {
    let wire = request_frame(1, &Request::ReadTable { offset: 384 });
    for bit in 0..8 * wire.len() {
        let mut flipped = wire.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let mut parser = Parser::new();
        let whole = |byte: &u8| parser.push(*byte).is_some_and(|frame| frame.is_ok());
        assert!(!flipped.iter().any(whole), "bit {bit}");
    }
}

/// A stream that gives the bytes it was made of and keeps what is written.
pub(crate) struct Wires {
    pub given: Vec<u8>,
    pub at: usize,
    pub written: Vec<u8>,
}

impl embedded_io::ReadReady for Wires {
    fn read_ready(&mut self) -> Result<bool, Self::Error> {
        Ok(self.at < self.given.len())
    }
}

impl embedded_io::ErrorType for Wires {
    type Error = core::convert::Infallible;
}

impl embedded_io::Read for Wires {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error> {
        let count = bytes.len().min(self.given.len() - self.at);
        bytes[..count].copy_from_slice(&self.given[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}

impl embedded_io::Write for Wires {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.written.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

#[test]
fn a_link_passes_over_noise_and_replies_to_others() {
    let mut given = Vec::from([0x55, 0xFF, 0x03]);
    given.extend(reply_frame(9, &Reply::Done));
    given.extend(reply_frame(1, &Reply::Opened { idle_ms: 5 }));
    let mut link = Link::new(Wires {
        given,
        at: 0,
        written: Vec::new(),
    });
    let number = link.send(&Request::Identify).unwrap();
    assert_eq!(link.reply_to(number), Ok(Reply::Opened { idle_ms: 5 }));
    assert_eq!(link.reply_to(number), Err(LinkError::Ended));
    assert_eq!(
        link.into_stream().written,
        request_frame(1, &Request::Identify).as_slice()
    );
}

proptest! {
    #[test]
    fn after_any_garbage_the_next_frame_is_found(
        garbage in prop::collection::vec(any::<u8>(), 0..600),
        offset: u32,
    ) {
        let mut parser = Parser::new();
        for byte in garbage {
            parser.push(byte);
        }
        let request = Request::ReadTable { offset };
        let wire = request_frame(3, &request);
        let (last, before) = wire.split_last().unwrap();
        for byte in before {
            prop_assert!(parser.push(*byte).is_none_or(|frame| frame.is_err()));
        }
        let frame = parser.push(*last).unwrap().unwrap();
        prop_assert_eq!(frame.read::<Request>(), Some(request));
    }
}
