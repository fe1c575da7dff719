//! Asks a device and waits for its replies; opens a session when one is needed.

use std::io;
use std::time::{Duration, Instant, SystemTime};

use quadcal::access::{Key, KeyHolder};
use quadcal::wire::{Draft, FrameError, Kind, Parser, Refusal, Reply, Request};

use super::error::{DeviceError, Fault};
use super::port::Port;

/// How long replies are waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// For the reply to a request that reads.
    pub read: Duration,
    /// How often such a request is sent at the most.
    pub tries: u32,
    /// For the reply to one that erases or writes flash first, which may take seconds. Others that change something are waited for as
    /// long as all tries of a request that reads.
    pub flash: Duration,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            read: Duration::from_secs(1),
            tries: 3,
            flash: Duration::from_secs(15),
        }
    }
}

/// Longest wait for the reply to a session's end where nothing else is done any more.
const PARTING: Duration = Duration::from_millis(200);

/// The host's end of a port. Dropped, it ends its session.
pub struct Client<P: Port> {
    port: P,
    name: String,
    timing: Timing,
    key: Option<Key>,
    session: Option<KeyHolder>,
    parser: Parser,
    /// Of the request sent last.
    number: u16,
    buffer: [u8; 512],
    /// Bytes of the buffer that were not looked at.
    left: std::ops::Range<usize>,
    /// Bytes that came.
    bytes: u64,
}

impl<P: Port> Client<P> {
    /// At a port, which messages call `name`. Without a key nothing can be changed.
    pub fn new(port: P, name: impl Into<String>, timing: Timing, key: Option<Key>) -> Self {
        // A late reply to whoever used the port before must not be taken for one to this client.
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        #[allow(clippy::cast_possible_truncation)]
        let number = now.map_or(0, |now| now.subsec_micros() as u16);
        Self {
            port,
            name: name.into(),
            timing,
            key,
            session: None,
            parser: Parser::new(),
            number,
            buffer: [0; 512],
            left: 0..0,
            bytes: 0,
        }
    }

    /// What messages call the port.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Asks what needs no session and may be asked again: up to [`Timing::tries`] times, until a reply comes.
    ///
    /// # Errors
    /// [`DeviceError`]; a refusal is one too.
    pub fn read(&mut self, what: &'static str, request: &Request) -> Result<Reply, DeviceError> {
        let (first, before) = (self.number.wrapping_add(1), self.bytes);
        for _ in 0..self.timing.tries {
            self.number = self.number.wrapping_add(1);
            let draft = self.draft(what, Kind::Request, request)?;
            self.write(&draft.finish(None))?;
            // A late reply to the same question is as good.
            if let Some(reply) = self.reply(what, first, self.timing.read)? {
                return self.granted(what, reply);
            }
        }
        let fault = Fault::Silent {
            tries: self.timing.tries,
            wait: self.timing.read,
            bytes: self.bytes - before,
        };
        Err(self.fault(fault))
    }

    /// Commands what only a session may, in the one that is open or else in a new one. Sent once.
    ///
    /// # Errors
    /// [`DeviceError`]; a refusal is one too. Without a key it is [`Fault::WrongKey`].
    pub fn change(&mut self, what: &'static str, request: &Request) -> Result<Reply, DeviceError> {
        let fresh = self.session.is_none();
        let reply = self.sealed(what, request)?;
        let reply = match reply {
            // It ended while nothing was asked for long, or the device was restarted. Nothing was done.
            Reply::Refused(Refusal::NoSession) if !fresh => {
                self.session = None;
                self.sealed(what, request)?
            }
            reply => reply,
        };
        match reply {
            Reply::Refused(Refusal::WrongProof | Refusal::Replayed) => {
                self.session = None;
                Err(self.fault(Fault::SessionTaken))
            }
            reply => self.granted(what, reply),
        }
    }

    /// Ends the session, if one is open. That it is not answered does not matter: it ends by itself.
    pub fn close(&mut self) {
        if self.session.is_some() {
            let _ = self.sealed("close", &Request::Close);
            self.session = None;
        }
    }

    fn sealed(&mut self, what: &'static str, request: &Request) -> Result<Reply, DeviceError> {
        if self.session.is_none() {
            self.session = Some(self.open()?);
        }
        self.number = self.number.wrapping_add(1);
        let draft = self.draft(what, Kind::Sealed, request)?;
        let seal = self
            .session
            .as_mut()
            .map(|holder| holder.seal(draft.signed()));
        self.write(&draft.finish(seal))?;
        let wait = match request {
            Request::RollBack | Request::Erase => self.timing.flash,
            _ => self.timing.read * self.timing.tries,
        };
        let reply = self.reply(what, self.number, wait)?;
        reply.ok_or_else(|| self.fault(Fault::Unanswered { what, wait }))
    }

    /// Opens a session. Where the proof's reply is lost, it begins anew: nothing else changes by it.
    fn open(&mut self) -> Result<KeyHolder, DeviceError> {
        const WHAT: &str = "open a session";
        let key = self.key.ok_or_else(|| self.fault(Fault::WrongKey))?;
        for _ in 0..self.timing.tries {
            let Reply::Challenge { nonce } = self.read(WHAT, &Request::Challenge)? else {
                return Err(self.unknown(WHAT));
            };
            let holder = KeyHolder::new(key, nonce);
            let proof = holder.proof();
            self.number = self.number.wrapping_add(1);
            let draft = self.draft(WHAT, Kind::Request, &Request::Open { proof })?;
            self.write(&draft.finish(None))?;
            match self.reply(WHAT, self.number, self.timing.read)? {
                Some(Reply::Opened { .. }) => return Ok(holder),
                Some(Reply::Refused(Refusal::WrongProof)) => {
                    return Err(self.fault(Fault::WrongKey));
                }
                // Too slow, or someone else asked for a challenge in between.
                Some(Reply::Refused(Refusal::NoSession)) | None => {}
                Some(reply) => {
                    self.granted(WHAT, reply)?;
                    return Err(self.unknown(WHAT));
                }
            }
        }
        let wait = self.timing.read;
        Err(self.fault(Fault::Unanswered { what: WHAT, wait }))
    }

    fn draft(
        &self,
        what: &'static str,
        kind: Kind,
        request: &Request,
    ) -> Result<Draft, DeviceError> {
        // Every request of the protocol fits a frame.
        Draft::new(kind, self.number, request).ok_or_else(|| self.unknown(what))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), DeviceError> {
        let written = self.port.set_wait(super::port::WRITE_WAIT).and_then(|()| {
            self.port.write_all(bytes)?;
            self.port.flush()
        });
        written.map_err(|error| self.fault(Fault::Lost(error)))
    }

    /// Waits for the reply to one of the requests from `first` to the last one.
    fn reply(
        &mut self,
        what: &'static str,
        first: u16,
        wait: Duration,
    ) -> Result<Option<Reply>, DeviceError> {
        let deadline = Instant::now() + wait;
        let span = self.number.wrapping_sub(first);
        let ours = |number: u16| number.wrapping_sub(first) <= span;
        loop {
            for at in self.left.by_ref() {
                match self.parser.push(self.buffer[at]) {
                    Some(Ok(frame)) if frame.kind == Kind::Reply && ours(frame.number) => {
                        let reply = frame.read::<Reply>();
                        return reply.map(Some).ok_or_else(|| self.unknown(what));
                    }
                    Some(Err(FrameError::Version { version, number })) if ours(number) => {
                        return Err(self.fault(Fault::Version { device: version }));
                    }
                    _ => {}
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.fill(left)?;
        }
    }

    /// Waits for bytes.
    fn fill(&mut self, wait: Duration) -> Result<(), DeviceError> {
        let read = self
            .port
            .set_wait(wait)
            .and_then(|()| self.port.read(&mut self.buffer));
        match read {
            Ok(0) => {
                let closed = io::Error::new(io::ErrorKind::UnexpectedEof, "the other end closed");
                Err(self.fault(Fault::Lost(closed)))
            }
            Ok(count) => {
                self.left = 0..count;
                self.bytes += count as u64;
                Ok(())
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::WouldBlock
                | io::ErrorKind::Interrupted => Ok(()),
                _ => Err(self.fault(Fault::Lost(error))),
            },
        }
    }

    fn granted(&self, what: &'static str, reply: Reply) -> Result<Reply, DeviceError> {
        match reply {
            Reply::Refused(Refusal::Version(device)) => Err(self.fault(Fault::Version { device })),
            Reply::Refused(refusal) => Err(self.fault(Fault::Refused { what, refusal })),
            reply => Ok(reply),
        }
    }

    pub(super) fn unknown(&self, what: &'static str) -> DeviceError {
        self.fault(Fault::UnknownReply { what })
    }

    pub(super) fn fault(&self, fault: Fault) -> DeviceError {
        fault.at(&self.name)
    }
}

impl<P: Port> Drop for Client<P> {
    fn drop(&mut self) {
        self.timing.read = self.timing.read.min(PARTING);
        self.timing.tries = 1;
        self.close();
    }
}
