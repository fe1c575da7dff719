//! Sessions opened, used, replayed and left alone, and keys guessed at.

use super::*;
use crate::wire::{Draft, Kind, Parser, Request, Seal, WireBytes};
use proptest::prelude::*;
use std::string::String;

const KEY: Key = [7; KEY_BYTES];

/// Nonces that count up.
struct Counting(u8);

impl Nonces for Counting {
    fn nonce(&mut self) -> Option<Nonce> {
        self.0 = self.0.checked_add(1)?;
        Some([self.0; 16])
    }
}

fn access() -> Access {
    Access::new(AccessConfig::default(), KEY)
}

fn opened(access: &mut Access, now_ms: u64) -> KeyHolder {
    let nonce = access
        .challenge(&mut Counting(now_ms as u8), now_ms)
        .unwrap();
    let holder = KeyHolder::new(KEY, nonce);
    assert_eq!(access.open(&holder.proof(), now_ms), Ok(300_000));
    holder
}

fn sealed(request: &Request, seal: impl FnOnce(&[u8]) -> Seal) -> WireBytes {
    let draft = Draft::new(Kind::Sealed, 1, request).unwrap();
    let seal = seal(draft.signed());
    draft.finish(Some(seal))
}

/// What becomes of a frame.
fn admit(access: &mut Access, wire: &[u8], now_ms: u64) -> Result<(), Refusal> {
    let mut parser = Parser::new();
    for byte in wire {
        if let Some(frame) = parser.push(*byte) {
            return access.admit(&frame.unwrap(), now_ms);
        }
    }
    panic!("no frame");
}

#[test]
fn codes_are_hmac_sha_256_over_the_documented_bytes() {
    let hex = |bytes: &[u8]| -> String { bytes.iter().map(|b| std::format!("{b:02x}")).collect() };
    let mut holder = KeyHolder::new(KEY, [1; 16]);
    // Computed with Python's hmac module.
    assert_eq!(hex(&holder.proof()), "32dc65d8a48ecb47225622b8ee20d941");
    let seal = holder.seal(b"abc");
    assert_eq!(
        (seal.counter, hex(&seal.mac).as_str()),
        (1, "d0611a82a7e58ff4332a9e0256821b42")
    );
}

#[test]
fn a_sealed_request_counts_once_and_only_while_the_session_lives() {
    let mut access = access();
    let mut holder = opened(&mut access, 1);
    let first = sealed(&Request::Commit, |bytes| holder.seal(bytes));
    let second = sealed(&Request::Erase, |bytes| holder.seal(bytes));
    let third = sealed(&Request::Abort, |bytes| holder.seal(bytes));
    assert_eq!(admit(&mut access, &first, 2), Ok(()));
    assert_eq!(admit(&mut access, &first, 3), Err(Refusal::Replayed));
    // One that was lost on the way may be left out, but does not count afterwards.
    assert_eq!(admit(&mut access, &third, 4), Ok(()));
    assert_eq!(admit(&mut access, &second, 5), Err(Refusal::Replayed));
    let next = sealed(&Request::Abort, |bytes| holder.seal(bytes));
    assert!(access.is_open(4 + 300_000));
    assert_eq!(
        admit(&mut access, &next, 5 + 300_000),
        Err(Refusal::NoSession)
    );
    assert!(!access.is_open(5 + 300_000));
    // Neither does it count in the next session.
    opened(&mut access, 400_002);
    assert_eq!(admit(&mut access, &next, 400_003), Err(Refusal::WrongProof));
}

#[test]
fn a_challenge_is_answered_once_in_time_and_lets_the_session_be() {
    let mut access = access();
    let mut holder = opened(&mut access, 0);
    let mut nonces = Counting(40);
    let nonce = access.challenge(&mut nonces, 0).unwrap();
    let other = KeyHolder::new([8; KEY_BYTES], nonce);
    assert_eq!(access.open(&other.proof(), 1), Err(Refusal::WrongProof));
    let right = KeyHolder::new(KEY, nonce);
    assert_eq!(access.open(&right.proof(), 1), Err(Refusal::NoSession));
    let wire = sealed(&Request::Abort, |bytes| holder.seal(bytes));
    assert_eq!(admit(&mut access, &wire, 2), Ok(()));
    let late = KeyHolder::new(KEY, access.challenge(&mut nonces, 3).unwrap());
    assert_eq!(access.open(&late.proof(), 10_004), Err(Refusal::NoSession));
    assert_eq!(
        access.challenge(&mut Counting(255), 3),
        Err(Refusal::NoNonce)
    );
    access.close();
    let wire = sealed(&Request::Abort, |bytes| holder.seal(bytes));
    assert_eq!(admit(&mut access, &wire, 4), Err(Refusal::NoSession));
}

#[test]
fn failures_cost_more_and_more_time_whatever_comes_in_it() {
    let mut access = access();
    let mut nonces = Counting(0);
    let mut now = 0;
    let mut waits = std::vec::Vec::new();
    for _ in 0..12 {
        while let Err(refusal) = access.challenge(&mut nonces, now) {
            let Refusal::Wait(left) = refusal else {
                panic!("{refusal:?}")
            };
            let right = KeyHolder::new(KEY, [nonces.0; 16]);
            assert_eq!(access.open(&right.proof(), now), Err(refusal));
            waits.push(left);
            now += u64::from(left);
        }
        assert_eq!(access.open(&[0; 16], now), Err(Refusal::WrongProof));
    }
    assert_eq!(
        waits,
        [1000, 2000, 4000, 8000, 16_000, 32_000, 60_000, 60_000]
    );
    opened(&mut access, now + 60_000);
    assert_eq!(access.challenge(&mut nonces, now + 60_000), Ok([13; 16]));
}

proptest! {
    #[test]
    fn no_seal_but_the_right_one_is_taken(counter: u32, mac: [u8; 16], bit in 0_usize..1000) {
        let mut access = access();
        let mut holder = opened(&mut access, 0);
        let guessed = sealed(&Request::Erase, |_| Seal { counter, mac });
        let refused = if counter == 0 { Refusal::Replayed } else { Refusal::WrongProof };
        prop_assert_eq!(admit(&mut access, &guessed, 1), Err(refused));
        // Any one bit of what is signed or of the seal.
        let draft = Draft::new(Kind::Sealed, 1, &Request::ReadTable { offset: 77 }).unwrap();
        let mut signed = std::vec::Vec::from(draft.signed());
        let seal = holder.seal(&signed);
        let bit = bit % (8 * signed.len());
        signed[bit / 8] ^= 1 << (bit % 8);
        let frame = Frame { kind: Kind::Sealed, number: 1, message: &[], signed: &signed, seal: Some(seal) };
        prop_assert_eq!(access.admit(&frame, 1), Err(Refusal::WrongProof));
        signed[bit / 8] ^= 1 << (bit % 8);
        let frame = Frame { kind: Kind::Sealed, number: 1, message: &[], signed: &signed, seal: Some(seal) };
        prop_assert_eq!(access.admit(&frame, 1), Ok(()));
    }
}
