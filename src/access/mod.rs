//! Who may change anything: sessions, opened with a challenge and a key.
//!
//! ```text
//! host                                  device
//!   Challenge            ------------>    draws a nonce of 16 bytes
//!                        <------------  Challenge { nonce }
//!   Open { proof }       ------------>    compares
//!                        <------------  Opened { idle_ms }
//!   sealed request       ------------>    session open? counter above the last? MAC right?
//!                        <------------  Done
//! ```
//!
//! The proof is HMAC-SHA-256(key, "quadcal open" nonce), the MAC of a seal HMAC-SHA-256(key, "quadcal seal" nonce counter bytes),
//! where the bytes are those of the frame before its seal and the counter has four, least significant first. Of either the first 16
//! bytes go over the wire.
//!
//! - A nonce opens one session at the most, and is asked for anew after a wrong proof. A challenge lets an open session be; a right proof
//!   ends it for the new one.
//! - Within a session counters rise. One that doesn't is a replay, and so is any frame of an earlier session, as its nonce
//!   was another.
//! - After [`AccessConfig::free_failures`] wrong proofs or seals in a row nothing is compared for a while, which doubles from one failure
//!   to the next.
//! - A session ends after [`AccessConfig::idle_ms`] without a sealed request.
//!
//! What this does not do: keep anything secret that goes over the wire, prove to the host who the device is, or help against
//! someone who cuts the line or keeps the device busy with wrong proofs. Reading needs no session.

mod proof;

#[cfg(test)]
mod tests;

pub use proof::{KEY_BYTES, Key, KeyHolder};

use crate::wire::{Frame, MacBytes, Nonce, Refusal};

/// Numbers that are never used twice and that nobody can tell beforehand: from the chip's random number generator.
pub trait Nonces {
    /// The next one; none while there is none to be had, and then no session opens.
    fn nonce(&mut self) -> Option<Nonce>;
}

/// How sessions end and how failures are slowed down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AccessConfig {
    /// Time without a sealed request after which a session ends, milliseconds.
    pub idle_ms: u32,
    /// Time that a challenge can be answered in, milliseconds.
    pub challenge_ms: u32,
    /// Wrong proofs or seals in a row that cost nothing.
    pub free_failures: u8,
    /// Time that the first one after those costs, milliseconds.
    pub wait_ms: u32,
    /// Time that one costs at the most, milliseconds.
    pub wait_max_ms: u32,
}

impl Default for AccessConfig {
    fn default() -> Self {
        Self {
            idle_ms: 300_000,
            challenge_ms: 10_000,
            free_failures: 3,
            wait_ms: 1000,
            wait_max_ms: 60_000,
        }
    }
}

/// A challenge that was given.
#[derive(Clone, Copy)]
struct Given {
    nonce: Nonce,
    at_ms: u64,
}

/// A session.
#[derive(Clone, Copy)]
struct Session {
    nonce: Nonce,
    counter: u32,
    used_ms: u64,
}

/// The device's side. Times are milliseconds of a clock that does not go back.
pub struct Access {
    config: AccessConfig,
    key: Key,
    given: Option<Given>,
    session: Option<Session>,
    failures: u8,
    wait_until_ms: u64,
}

impl Access {
    /// No session.
    #[must_use]
    pub const fn new(config: AccessConfig, key: Key) -> Self {
        Self {
            config,
            key,
            given: None,
            session: None,
            failures: 0,
            wait_until_ms: 0,
        }
    }

    /// Gives a challenge.
    ///
    /// # Errors
    /// [`Refusal::Wait`] after too many failures, [`Refusal::NoNonce`].
    pub fn challenge(&mut self, nonces: &mut impl Nonces, now_ms: u64) -> Result<Nonce, Refusal> {
        self.wait(now_ms)?;
        let nonce = nonces.nonce().ok_or(Refusal::NoNonce)?;
        self.given = Some(Given {
            nonce,
            at_ms: now_ms,
        });
        Ok(nonce)
    }

    /// Opens a session; the time after which it ends by itself, milliseconds.
    ///
    /// # Errors
    /// [`Refusal::Wait`] after too many failures, [`Refusal::NoSession`] without a challenge or when it is too old,
    /// [`Refusal::WrongProof`].
    pub fn open(&mut self, proof: &MacBytes, now_ms: u64) -> Result<u32, Refusal> {
        self.wait(now_ms)?;
        let given = self.given.take().ok_or(Refusal::NoSession)?;
        if now_ms.saturating_sub(given.at_ms) > self.config.challenge_ms.into() {
            return Err(Refusal::NoSession);
        }
        if !proof::proof_is_right(&self.key, &given.nonce, proof) {
            return Err(self.fail(now_ms));
        }
        self.failures = 0;
        self.session = Some(Session {
            nonce: given.nonce,
            counter: 0,
            used_ms: now_ms,
        });
        Ok(self.config.idle_ms)
    }

    /// Whether a frame may change anything. A seal counts once.
    ///
    /// # Errors
    /// [`Refusal::NoSession`], [`Refusal::Wait`] after too many failures, [`Refusal::Replayed`], [`Refusal::WrongProof`] also
    /// for a frame without a seal.
    pub fn admit(&mut self, frame: &Frame<'_>, now_ms: u64) -> Result<(), Refusal> {
        self.end_idle(now_ms);
        let session = self.session.ok_or(Refusal::NoSession)?;
        let seal = frame.seal.ok_or(Refusal::WrongProof)?;
        self.wait(now_ms)?;
        if seal.counter <= session.counter {
            return Err(Refusal::Replayed);
        }
        if !proof::seal_is_right(&self.key, &session.nonce, frame.signed, &seal) {
            return Err(self.fail(now_ms));
        }
        self.failures = 0;
        self.session = Some(Session {
            counter: seal.counter,
            used_ms: now_ms,
            ..session
        });
        Ok(())
    }

    /// Ends the session.
    pub fn close(&mut self) {
        self.session = None;
    }

    /// Whether a session is open.
    #[must_use]
    pub fn is_open(&self, now_ms: u64) -> bool {
        self.session.is_some_and(|session| {
            now_ms.saturating_sub(session.used_ms) <= self.config.idle_ms.into()
        })
    }

    fn end_idle(&mut self, now_ms: u64) {
        if !self.is_open(now_ms) {
            self.session = None;
        }
    }

    fn wait(&self, now_ms: u64) -> Result<(), Refusal> {
        match self.wait_until_ms.saturating_sub(now_ms) {
            0 => Ok(()),
            left => Err(Refusal::Wait(u32::try_from(left).unwrap_or(u32::MAX))),
        }
    }

    /// Counts a failure.
    fn fail(&mut self, now_ms: u64) -> Refusal {
        self.failures = self.failures.saturating_add(1);
        if let Some(doubled) = self
            .failures
            .checked_sub(self.config.free_failures.saturating_add(1))
        {
            let wait = u64::from(self.config.wait_ms) << doubled.min(31);
            self.wait_until_ms = now_ms + wait.min(self.config.wait_max_ms.into());
        }
        Refusal::WrongProof
    }
}
