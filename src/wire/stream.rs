//! Frames over any stream of `embedded-io`.

use embedded_io::{Read, Write};

use super::frame::{Draft, Frame, FrameError, Kind};
use super::parser::Parser;
use super::request::Request;
use super::{Reply, Seal};

/// Why no reply came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LinkError<E> {
    /// The stream failed.
    Stream(E),
    /// The stream ended.
    Ended,
    /// The message does not fit a frame.
    TooLong,
    /// A frame came that can't be read.
    Frame(FrameError),
    /// A reply came that is not known: the device's firmware is newer.
    Unknown,
}

/// One end of a stream that frames go over: the host's, or that of a device which reads its port in the main loop.
#[derive(Debug)]
pub struct Link<S> {
    stream: S,
    parser: Parser,
    number: u16,
}

impl<S: Read + Write> Link<S> {
    /// Frames over a stream.
    pub fn new(stream: S) -> Self {
        Self {
            stream,
            parser: Parser::new(),
            number: 0,
        }
    }

    /// Gives the stream back.
    pub fn into_stream(self) -> S {
        self.stream
    }

    /// The stream.
    pub fn stream(&mut self) -> &mut S {
        &mut self.stream
    }

    /// Sends a request that is open to all and returns its number.
    ///
    /// # Errors
    /// [`LinkError::Stream`], [`LinkError::TooLong`].
    pub fn send(&mut self, request: &Request) -> Result<u16, LinkError<S::Error>> {
        let draft = self.draft(Kind::Request, request)?;
        self.write(&draft.finish(None))?;
        Ok(self.number)
    }

    /// Sends a request with the seal that `seal` makes over what it is given, and returns its number.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn send_sealed(
        &mut self,
        request: &Request,
        seal: impl FnOnce(&[u8]) -> Seal,
    ) -> Result<u16, LinkError<S::Error>> {
        let draft = self.draft(Kind::Sealed, request)?;
        let seal = seal(draft.signed());
        self.write(&draft.finish(Some(seal)))?;
        Ok(self.number)
    }

    fn draft(&mut self, kind: Kind, request: &Request) -> Result<Draft, LinkError<S::Error>> {
        self.number = self.number.wrapping_add(1);
        Draft::new(kind, self.number, request).ok_or(LinkError::TooLong)
    }

    /// Writes bytes of a frame.
    ///
    /// # Errors
    /// [`LinkError::Stream`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError<S::Error>> {
        self.stream.write_all(bytes).map_err(LinkError::Stream)?;
        self.stream.flush().map_err(LinkError::Stream)
    }

    /// Waits for the next whole frame and hands it to `take`. Noise between frames is passed over; the stream's own time-out
    /// ends the wait.
    ///
    /// # Errors
    /// [`LinkError::Stream`], [`LinkError::Ended`], or [`LinkError::Frame`] for one of another version or kind.
    pub fn receive<T>(
        &mut self,
        take: impl FnOnce(Frame<'_>) -> T,
    ) -> Result<T, LinkError<S::Error>> {
        let mut byte = [0];
        loop {
            if self.stream.read(&mut byte).map_err(LinkError::Stream)? == 0 {
                return Err(LinkError::Ended);
            }
            match self.parser.push(byte[0]) {
                Some(Ok(frame)) => return Ok(take(frame)),
                Some(Err(error @ (FrameError::Version { .. } | FrameError::Kind(_)))) => {
                    return Err(LinkError::Frame(error));
                }
                Some(Err(_)) | None => {}
            }
        }
    }

    /// Waits for the reply to a request; replies to others are passed over.
    ///
    /// # Errors
    /// As [`Self::receive`], and [`LinkError::Unknown`].
    pub fn reply_to(&mut self, number: u16) -> Result<Reply, LinkError<S::Error>> {
        loop {
            let reply = self.receive(|frame| {
                (frame.kind == Kind::Reply && frame.number == number).then(|| frame.read())
            })?;
            if let Some(reply) = reply {
                return reply.ok_or(LinkError::Unknown);
            }
        }
    }
}
