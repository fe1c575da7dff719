//! Requests and replies between a host and a device, over a serial line or whatever else carries bytes.
//!
//! # A frame
//! ```text
//! offset  size  field
//!      0     1  protocol version, 1
//!      1     1  kind: 0 request, 1 sealed request, 2 reply
//!      2     2  number, least significant byte first: the requester's, and the same in the reply
//!      4     n  message, at most 160 bytes
//!    4+n   4+16 in a sealed request only: counter, least significant byte first, and MAC; see [`crate::access`]
//!    end     4  CRC-32 (ISO-HDLC) over every byte before it, least significant byte first
//! ```
//! These bytes are stuffed (COBS), so that none is zero, and stand between two zero bytes. Noise ends at the first of them, so
//! it costs no frame but those that it hits.
//!
//! A frame that is not whole is not answered: whoever asked asks again. A whole one of another version is answered by
//! [`Refusal::Version`] in a frame of the version spoken; version and number stay where they are in every version. The version goes up
//! when bytes change their meaning. New messages go to the end of their enum, and one that is not known is answered by
//! [`Refusal::Unknown`].
//!
//! # A message
//! Messages are [`Request`] and [`Reply`] as postcard writes them: the variant's number, then its fields in their order. Unsigned
//! numbers above a byte take 7 bits a byte, least significant first, with the top bit set in all but the last (varint); signed ones are
//! 2 n, or -2 n - 1 below zero, and then the same. A byte, and each of a fixed row of bytes, stands as it is. A `bool` is 0 or 1; an
//! option is 0, or 1 and its value; a piece of a table is its length and its bytes.
//!
//! One frame of every message, byte by byte before it is stuffed: version, kind and number 1, message, counter and MAC where it has a
//! seal, CRC; first the requests, then the replies. A test holds them. On the wire the first one is
//! `00 02 01 02 01 01 05 9a b4 80 fa 00`.
//!
//! ```text
#![doc = include_str!("frames.txt")]
//! ```

mod frame;
mod parser;
mod reply;
mod request;
mod stream;

#[cfg(test)]
pub(crate) mod tests;

pub use frame::{Draft, Frame, FrameError, Kind, Seal, WireBytes, reply_frame, request_frame};
pub use parser::Parser;
pub use reply::{Identity, Learned, Live, Refusal, Reply, Status, TableFault, TableInfo};
pub use request::{LogLevel, MAC_BYTES, MacBytes, NONCE_BYTES, Nonce, Piece, Request};
pub use stream::{Link, LinkError};

/// Protocol version spoken by this code.
pub const VERSION: u8 = 1;

/// Bytes of a table in one message.
pub const PIECE_BYTES: usize = 128;

/// Pieces are read from multiples of this.
pub const PIECE_STEP: u32 = 32;

/// Bytes of a message at the most.
pub const MESSAGE_MAX: usize = 160;

/// Bytes of a frame at the most, before they are stuffed.
pub const BODY_MAX: usize = frame::HEAD_BYTES + MESSAGE_MAX + frame::SEAL_BYTES + frame::CRC_BYTES;

/// Bytes of a frame on the wire at the most: one more a 254 bytes for the stuffing, and a zero at both ends.
pub const FRAME_MAX: usize = BODY_MAX + BODY_MAX.div_ceil(254) + 2;
