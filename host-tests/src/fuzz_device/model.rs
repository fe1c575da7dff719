//! Who may change anything, written apart from the core: unstuffing, CRC and HMAC are its own.

use quadcal::access::{AccessConfig, Key};
use quadcal::wire::{BODY_MAX, MacBytes, Nonce, Refusal, Request, VERSION};
use sha2::{Digest, Sha256};

/// What may come of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No reply, no change.
    Silence,
    /// This refusal, no change.
    Refused(Refusal),
    /// A challenge or none to be had; no change.
    Challenge,
    /// The session opens; no change.
    Opened,
    /// Whatever it reads; no change.
    Read,
    /// It may change what it asks to.
    Admitted(Request),
}

#[derive(Clone, Copy, Debug)]
struct Session {
    nonce: Nonce,
    counter: u32,
    used_ms: u64,
}

/// The model.
pub struct Model {
    config: AccessConfig,
    /// The hash after the block of key and padding, inner and outer.
    keyed: [Sha256; 2],
    given: Option<(Nonce, u64)>,
    session: Option<Session>,
    failures: u32,
    wait_until_ms: u64,
    /// Bytes since the last zero.
    pending: Vec<u8>,
}

impl Model {
    /// Nothing opened.
    #[must_use]
    pub fn new(config: AccessConfig, key: &Key) -> Self {
        let keyed = [0x36, 0x5C].map(|pad| {
            let mut block = [pad; 64];
            block.iter_mut().zip(key).for_each(|(cell, k)| *cell ^= k);
            Sha256::new_with_prefix(block)
        });
        Self {
            config,
            keyed,
            given: None,
            session: None,
            failures: 0,
            wait_until_ms: 0,
            pending: Vec::new(),
        }
    }

    /// Takes a byte; a verdict at the end of what may be a frame.
    pub fn push(&mut self, byte: u8, now_ms: u64) -> Option<Verdict> {
        if byte != 0 {
            self.pending.push(byte);
            return None;
        }
        let pending = std::mem::take(&mut self.pending);
        if pending.is_empty() {
            return None;
        }
        let body = unstuff(&pending).filter(|body| body.len() <= BODY_MAX);
        Some(body.map_or(Verdict::Silence, |body| self.judge(&body, now_ms)))
    }

    /// The device gave this challenge.
    pub fn gave(&mut self, nonce: Nonce, now_ms: u64) {
        self.given = Some((nonce, now_ms));
    }

    fn mac(&self, purpose: &[u8], nonce: &Nonce, parts: &[&[u8]]) -> MacBytes {
        let [mut inner, mut outer] = self.keyed.clone();
        inner.update(purpose);
        inner.update(nonce);
        parts.iter().for_each(|part| inner.update(part));
        outer.update(inner.finalize());
        let whole = outer.finalize();
        std::array::from_fn(|i| whole[i])
    }

    fn wait(&self, now_ms: u64) -> Option<Verdict> {
        let left = self.wait_until_ms.saturating_sub(now_ms);
        (left != 0).then(|| Verdict::Refused(Refusal::Wait(left as u32)))
    }

    fn fail(&mut self, now_ms: u64) -> Verdict {
        self.failures += 1;
        let free = u32::from(self.config.free_failures);
        if self.failures > free {
            let doubled = 2_u64.pow((self.failures - free - 1).min(31));
            let wait = u64::from(self.config.wait_ms) * doubled;
            self.wait_until_ms = now_ms + wait.min(u64::from(self.config.wait_max_ms));
        }
        Verdict::Refused(Refusal::WrongProof)
    }

    fn judge(&mut self, body: &[u8], now_ms: u64) -> Verdict {
        if body.len() < 8 {
            return Verdict::Silence;
        }
        let (rest, crc) = body.split_at(body.len() - 4);
        if crc32(rest).to_le_bytes() != crc {
            return Verdict::Silence;
        }
        if rest[0] != VERSION {
            return Verdict::Refused(Refusal::Version(VERSION));
        }
        let (signed, seal) = match rest[1] {
            0 => (rest, None),
            1 if rest.len() >= 24 => {
                let (signed, seal) = rest.split_at(rest.len() - 20);
                (signed, Some(seal))
            }
            _ => return Verdict::Silence,
        };
        let Ok((request, [])) = postcard::take_from_bytes::<Request>(&signed[4..]) else {
            return Verdict::Refused(Refusal::Unknown);
        };
        match request {
            Request::Challenge => self.wait(now_ms).unwrap_or(Verdict::Challenge),
            Request::Open { proof } => self.open(&proof, now_ms),
            Request::Identify
            | Request::Status
            | Request::Live
            | Request::Result
            | Request::Preview
            | Request::ReadTable { .. } => Verdict::Read,
            request => self.admit(request, signed, seal, now_ms),
        }
    }

    fn open(&mut self, proof: &MacBytes, now_ms: u64) -> Verdict {
        if let Some(wait) = self.wait(now_ms) {
            return wait;
        }
        let limit = u64::from(self.config.challenge_ms);
        match self.given.take() {
            Some((nonce, at_ms)) if now_ms - at_ms <= limit => {
                if self.mac(b"quadcal open", &nonce, &[]) != *proof {
                    return self.fail(now_ms);
                }
                self.failures = 0;
                self.session = Some(Session {
                    nonce,
                    counter: 0,
                    used_ms: now_ms,
                });
                Verdict::Opened
            }
            _ => Verdict::Refused(Refusal::NoSession),
        }
    }

    fn admit(
        &mut self,
        request: Request,
        signed: &[u8],
        seal: Option<&[u8]>,
        now_ms: u64,
    ) -> Verdict {
        let idle = u64::from(self.config.idle_ms);
        let live = self
            .session
            .filter(|session| now_ms - session.used_ms <= idle);
        let Some(session) = live else {
            return Verdict::Refused(Refusal::NoSession);
        };
        let Some((counter, mac)) = seal.and_then(<[u8]>::split_first_chunk::<4>) else {
            return Verdict::Refused(Refusal::WrongProof);
        };
        if let Some(wait) = self.wait(now_ms) {
            return wait;
        }
        let number = u32::from_le_bytes(*counter);
        if number <= session.counter {
            return Verdict::Refused(Refusal::Replayed);
        }
        if self.mac(b"quadcal seal", &session.nonce, &[counter, signed]) != *mac {
            return self.fail(now_ms);
        }
        self.failures = 0;
        self.session = (request != Request::Close).then_some(Session {
            counter: number,
            used_ms: now_ms,
            ..session
        });
        Verdict::Admitted(request)
    }
}

fn unstuff(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut body = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let code = usize::from(bytes[at]);
        body.extend(bytes.get(at + 1..at + code)?);
        at += code;
        if code < 255 && at < bytes.len() {
            body.push(0);
        }
    }
    Some(body)
}

/// CRC-32, four bits at a time.
fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 16] = {
        let mut table = [0; 16];
        let mut i = 0;
        while i < 16 {
            let (mut word, mut bit) = (i as u32, 0);
            while bit < 4 {
                word = (word >> 1) ^ (0xEDB8_8320 * (word & 1));
                bit += 1;
            }
            table[i] = word;
            i += 1;
        }
        table
    };
    let step = |crc: u32, nibble: u32| (crc >> 4) ^ TABLE[((crc ^ nibble) & 15) as usize];
    !bytes.iter().fold(!0, |crc, byte| {
        let byte = u32::from(*byte);
        step(step(crc, byte & 15), byte >> 4)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crc_is_the_one_of_the_check_word() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }
}
