//! Frames out of a stream of bytes, one byte at a time.

use cobs::{DecodeResult, DecoderState};

use super::BODY_MAX;
use super::frame::{Frame, FrameError};

/// Finds frames in a stream. Constant work a byte, but for the last one of a frame, whose CRC is checked then.
///
/// Whatever comes in, the first whole frame after a zero byte is found.
#[derive(Debug, Default)]
pub struct Parser {
    state: DecoderState,
    body: heapless::Vec<u8, BODY_MAX>,
    /// Why the frame that is coming in is no good.
    wrong: Option<FrameError>,
}

impl Parser {
    /// Waits for a frame.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next byte; `Some` at the end of every frame, good or bad.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame<'_>, FrameError>> {
        let idle = matches!(self.state, DecoderState::Idle);
        match self.state.feed(byte) {
            Ok(DecodeResult::DataStart) => {
                self.body.clear();
                self.wrong = None;
            }
            Ok(DecodeResult::DataContinue(byte)) if self.body.push(byte).is_err() => {
                self.wrong = Some(FrameError::TooLong);
            }
            // A run of bytes without a zero goes on for ever: nothing is kept of it.
            Ok(DecodeResult::NoData | DecodeResult::DataContinue(_)) => {}
            Ok(DecodeResult::DataComplete) => {
                return Some(match self.wrong.take() {
                    None => Frame::parse(&self.body),
                    Some(wrong) => Err(wrong),
                });
            }
            Err(_) if !idle => {
                return Some(Err(self.wrong.take().unwrap_or(FrameError::Stuffing)));
            }
            Err(_) => {}
        }
        None
    }
}
