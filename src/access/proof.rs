//! The two message authentication codes, and the host's side of a session.

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

use crate::wire::{MacBytes, Nonce, Seal};

/// Bytes of a key.
pub const KEY_BYTES: usize = 32;

/// What device and host share.
pub type Key = [u8; KEY_BYTES];

/// What a code is made for; of one length, so that no code for the one is a code for the other.
const OPEN: &[u8; 12] = b"quadcal open";
const SEAL: &[u8; 12] = b"quadcal seal";

fn hmac(key: &Key, purpose: &[u8; 12], nonce: &Nonce) -> Hmac<Sha256> {
    // A key is as long as half a block of the hash, and so is taken as it is.
    let mut hmac = Hmac::<Sha256>::new(&padded(key).into());
    hmac.update(purpose);
    hmac.update(nonce);
    hmac
}

/// A key as a block of the hash: zeros behind it, as HMAC has it for any key that is shorter.
fn padded(key: &Key) -> [u8; 64] {
    let mut block = [0; 64];
    for (cell, byte) in block.iter_mut().zip(key) {
        *cell = *byte;
    }
    block
}

fn sealing(key: &Key, nonce: &Nonce, counter: u32, signed: &[u8]) -> Hmac<Sha256> {
    let mut hmac = hmac(key, SEAL, nonce);
    hmac.update(&counter.to_le_bytes());
    hmac.update(signed);
    hmac
}

fn first_half(hmac: Hmac<Sha256>) -> MacBytes {
    let whole: [u8; 32] = hmac.finalize().into_bytes().into();
    core::array::from_fn(|i| whole[i])
}

/// Whether a proof is right; takes as long whatever is wrong with it.
pub(super) fn proof_is_right(key: &Key, nonce: &Nonce, proof: &MacBytes) -> bool {
    hmac(key, OPEN, nonce).verify_truncated_left(proof).is_ok()
}

/// Whether a seal's code is right; takes as long whatever is wrong with it.
pub(super) fn seal_is_right(key: &Key, nonce: &Nonce, signed: &[u8], seal: &Seal) -> bool {
    sealing(key, nonce, seal.counter, signed)
        .verify_truncated_left(&seal.mac)
        .is_ok()
}

/// The side of a session that holds the key and asks: the host's.
#[derive(Clone)]
pub struct KeyHolder {
    key: Key,
    nonce: Nonce,
    counter: u32,
}

impl KeyHolder {
    /// For the challenge that the device gave.
    #[must_use]
    pub const fn new(key: Key, nonce: Nonce) -> Self {
        Self {
            key,
            nonce,
            counter: 0,
        }
    }

    /// What opens the session: [`crate::wire::Request::Open`].
    #[must_use]
    pub fn proof(&self) -> MacBytes {
        first_half(hmac(&self.key, OPEN, &self.nonce))
    }

    /// The seal of the next request, whose bytes before the seal are `signed`.
    pub fn seal(&mut self, signed: &[u8]) -> Seal {
        self.counter = self.counter.saturating_add(1);
        let mac = first_half(sealing(&self.key, &self.nonce, self.counter, signed));
        Seal {
            counter: self.counter,
            mac,
        }
    }
}
