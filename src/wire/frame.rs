//! The bytes of a frame before they are stuffed, and the check that they are whole.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use serde::{Deserialize, Serialize};

use super::request::{MAC_BYTES, MacBytes};
use super::{BODY_MAX, FRAME_MAX, MESSAGE_MAX, VERSION};

/// Bytes before the message.
pub(super) const HEAD_BYTES: usize = 4;

/// Bytes of the seal.
pub(super) const SEAL_BYTES: usize = 4 + MAC_BYTES;

/// Bytes of the CRC at the end.
pub(super) const CRC_BYTES: usize = 4;

const CRC32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// What a frame holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// A request.
    Request,
    /// A request with a seal.
    Sealed,
    /// A reply.
    Reply,
}

impl Kind {
    const fn of(byte: u8) -> Option<Self> {
        match byte {
            0 => Some(Self::Request),
            1 => Some(Self::Sealed),
            2 => Some(Self::Reply),
            _ => None,
        }
    }
}

/// Proof that a request comes from the session's owner, and is not an old one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seal {
    /// Above that of every sealed request of the session before.
    pub counter: u32,
    /// See [`crate::access`].
    pub mac: MacBytes,
}

/// Why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// More bytes than a frame can have.
    TooLong,
    /// Fewer bytes than its kind needs.
    TooShort,
    /// The stuffing is wrong: bytes are missing.
    Stuffing,
    /// The CRC differs.
    Crc,
    /// Whole, but of another protocol version.
    Version {
        /// That version.
        version: u8,
        /// The number, which is where it is in every version.
        number: u16,
    },
    /// Whole, but of a kind that is not known.
    Kind(u8),
}

/// A whole frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What it holds.
    pub kind: Kind,
    /// The requester's number; the reply has the same.
    pub number: u16,
    /// The message.
    pub message: &'a [u8],
    /// What the seal is made over: everything before it.
    pub signed: &'a [u8],
    /// The seal of a sealed request.
    pub seal: Option<Seal>,
}

impl<'a> Frame<'a> {
    /// Checks the bytes of a frame without stuffing.
    ///
    /// # Errors
    /// [`FrameError`].
    pub fn parse(body: &'a [u8]) -> Result<Self, FrameError> {
        let (rest, crc) = body
            .split_last_chunk::<CRC_BYTES>()
            .ok_or(FrameError::TooShort)?;
        let (&[version, kind, low, high], _) = rest
            .split_first_chunk::<HEAD_BYTES>()
            .ok_or(FrameError::TooShort)?;
        if CRC32.checksum(rest) != u32::from_le_bytes(*crc) {
            return Err(FrameError::Crc);
        }
        let number = u16::from_le_bytes([low, high]);
        if version != VERSION {
            return Err(FrameError::Version { version, number });
        }
        let kind = Kind::of(kind).ok_or(FrameError::Kind(kind))?;
        let (signed, seal) = if kind == Kind::Sealed {
            let (signed, mac) = rest
                .split_last_chunk::<MAC_BYTES>()
                .ok_or(FrameError::TooShort)?;
            let (signed, counter) = signed.split_last_chunk::<4>().ok_or(FrameError::TooShort)?;
            let seal = Seal {
                counter: u32::from_le_bytes(*counter),
                mac: *mac,
            };
            (signed, Some(seal))
        } else {
            (rest, None)
        };
        Ok(Self {
            kind,
            number,
            message: signed.get(HEAD_BYTES..).ok_or(FrameError::TooShort)?,
            signed,
            seal,
        })
    }

    /// The message read as `M`; none where it is not one, or bytes are left over.
    #[must_use]
    pub fn read<M: Deserialize<'a>>(&self) -> Option<M> {
        match postcard::take_from_bytes(self.message) {
            Ok((message, [])) => Some(message),
            _ => None,
        }
    }
}

/// A frame being put together: head and message, then a seal, then what goes over the wire.
#[derive(Clone, Debug)]
pub struct Draft {
    body: heapless::Vec<u8, BODY_MAX>,
}

impl Draft {
    /// Head and message. None where the message has more than [`MESSAGE_MAX`] bytes, which none of this crate's has.
    #[must_use]
    pub fn new<M: Serialize>(kind: Kind, number: u16, message: &M) -> Option<Self> {
        let [low, high] = number.to_le_bytes();
        let mut buffer = [0; MESSAGE_MAX];
        let message = postcard::to_slice(message, &mut buffer).ok()?;
        let mut body = heapless::Vec::new();
        body.extend_from_slice(&[VERSION, kind as u8, low, high])
            .ok()?;
        body.extend_from_slice(message).ok()?;
        Some(Self { body })
    }

    /// What a seal is to be made over.
    #[must_use]
    pub fn signed(&self) -> &[u8] {
        &self.body
    }

    /// The bytes for the wire: a zero, the stuffed frame, a zero. `seal` belongs to [`Kind::Sealed`] and nothing else.
    #[must_use]
    pub fn finish(mut self, seal: Option<Seal>) -> WireBytes {
        let (mut wire, mut stuffed) = (WireBytes::new(), [0; FRAME_MAX]);
        let mut put = |bytes: &[u8]| self.body.extend_from_slice(bytes);
        let sealed = seal.map_or(Ok(()), |seal| {
            put(&seal.counter.to_le_bytes()).and_then(|()| put(&seal.mac))
        });
        let crc = CRC32.checksum(&self.body);
        // Both have room for the longest message with a seal.
        if sealed.is_ok()
            && self.body.extend_from_slice(&crc.to_le_bytes()).is_ok()
            && let Ok(length) = cobs::try_encode(&self.body, &mut stuffed[1..])
            // The zeros at both ends are there.
            && let Some(stuffed) = stuffed.get(..length + 2)
        {
            let _ = wire.extend_from_slice(stuffed);
        }
        wire
    }
}

/// A frame as it goes over the wire.
pub type WireBytes = heapless::Vec<u8, FRAME_MAX>;

/// A reply, ready for the wire.
#[must_use]
pub fn reply_frame(number: u16, reply: &super::Reply) -> WireBytes {
    Draft::new(Kind::Reply, number, reply).map_or_else(WireBytes::new, |draft| draft.finish(None))
}

/// A request without a seal, ready for the wire.
#[must_use]
pub fn request_frame(number: u16, request: &super::Request) -> WireBytes {
    Draft::new(Kind::Request, number, request)
        .map_or_else(WireBytes::new, |draft| draft.finish(None))
}
