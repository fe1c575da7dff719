//! The client against devices that answer whatever they like: it ends, with a result or an error, and never panics.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::time::Duration;

use proptest::collection::vec;
use proptest::prelude::*;
use quadcal::recalibrate::Options;
use quadcal::slot::Slot;
use quadcal::wire::{Draft, Identity, Kind, Parser, Reply, reply_frame};
use quadcal_host::device::{Client, Port, Timing, Watching};
use serde::ser::{Serialize, SerializeTuple, Serializer};

/// A message of any bytes.
struct Raw<'a>(&'a [u8]);

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// What comes after a request.
#[derive(Clone, Debug)]
enum Answer {
    /// A whole frame with any message.
    Frame(Vec<u8>),
    /// Bytes of no frame.
    Bytes(Vec<u8>),
    /// The truth.
    Reply(Reply),
}

/// Gives the answers one after the other, over and over.
struct Liar {
    answers: Vec<Answer>,
    next: usize,
    asked: Parser,
    coming: VecDeque<u8>,
}

impl Read for Liar {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.coming.is_empty() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.coming.read(bytes)
    }
}

impl Write for Liar {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for byte in bytes {
            let Some(Ok(frame)) = self.asked.push(*byte) else {
                continue;
            };
            match &self.answers[self.next % self.answers.len()] {
                Answer::Frame(message) => {
                    let draft = Draft::new(Kind::Reply, frame.number, &Raw(message)).unwrap();
                    self.coming.extend(draft.finish(None));
                }
                Answer::Bytes(bytes) => self.coming.extend(bytes),
                Answer::Reply(reply) => self.coming.extend(reply_frame(frame.number, reply)),
            }
            self.next += 1;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Port for Liar {
    fn set_wait(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// Replies that make sense by themselves, with numbers that need not.
fn frame() -> impl Strategy<Value = Vec<u8>> {
    let table = (0..3_u8, 1..4_u8, vec(any::<u8>(), 0..40)).prop_map(|(at, whole, piece)| {
        let mut message = vec![7, at << 5, 0x80 | whole << 5, 1, piece.len() as u8];
        message.extend(piece);
        message
    });
    let written =
        (any::<u8>(), any::<bool>()).prop_map(|(next, whole)| vec![10, next & 0x7F, whole.into()]);
    let any_message = (0..12_u8, vec(any::<u8>(), 0..60)).prop_map(|(variant, mut rest)| {
        rest.insert(0, variant);
        rest
    });
    let challenge = Just([&[8][..], &[1; 16]].concat());
    let opened = Just(vec![9, 5]);
    let done = Just(vec![0]);
    let offset = (0..100_u8).prop_map(|next| vec![1, 14, next]);
    prop_oneof![table, written, any_message, challenge, opened, done, offset]
}

fn answers() -> impl Strategy<Value = Vec<Answer>> {
    let answer = prop_oneof![
        9 => frame().prop_map(Answer::Frame),
        1 => vec(any::<u8>(), 0..100).prop_map(Answer::Bytes),
    ];
    vec(answer, 1..12)
}

/// A table, and what a device that it fits answers until the first piece.
fn fitting() -> (&'static [u8], [Answer; 3]) {
    let bytes = include_bytes!("../../src/slot/data/version-3.qct");
    let header = Slot::parse(bytes).unwrap().header;
    let identity = Identity {
        firmware: [1, 2, 3],
        slot_version: 3,
        edges: header.shape.edges(),
        classes: header.shape.classes() as u8,
        clock_hz: 84_000_000,
        serial: 0,
    };
    let opening = [
        Reply::Identity(identity),
        Reply::Challenge { nonce: [1; 16] },
        Reply::Opened { idle_ms: 5 },
    ];
    (bytes, opening.map(Answer::Reply))
}

proptest! {
    #[test]
    fn whatever_a_device_answers_the_client_comes_to_an_end(mut answers in answers(), which in 0..4_u8) {
        let (slot, opening) = fitting();
        if which == 1 {
            answers.splice(0..0, opening);
        }
        let liar = Liar { answers, next: 0, asked: Parser::new(), coming: VecDeque::new() };
        let timing = Timing {
            read: Duration::from_micros(300),
            tries: 2,
            flash: Duration::from_micros(300),
        };
        let mut client = Client::new(liar, "liar", timing, Some([0; 32]));
        let mut looks = 0;
        match which {
            0 => drop(client.dump(|_, _| {})),
            1 => drop(client.load(slot, |_, _| {})),
            2 => drop(client.calibrate(&Options::default(), |_| {
                looks += 1;
                if looks < 2 { Watching::GoOn } else { Watching::Stop }
            })),
            _ => {
                drop(client.status());
                drop(client.live());
                client.close();
            }
        }
    }
}
