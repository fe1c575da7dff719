//! A device under arbitrary input, and a model of who may change what that is written apart from it.
//!
//! The model knows the key and sees every byte; it has its own unstuffing, CRC and HMAC. For every input it says which replies may come,
//! and whether anything may change.

pub mod dice;
pub mod flash;
pub mod input;
pub mod model;
pub mod rig;
pub mod subject;

use std::sync::atomic::{AtomicU64, Ordering};

use dice::Dice;
use input::Author;
use subject::{Subject, Tally};

/// Inputs that one device lives for.
const LIFE: u64 = 20_000;

/// Feeds `inputs` inputs drawn from `seed`; `done` counts them as they go.
///
/// # Panics
/// Where the device does what the model does not allow, with the seed and the number of the input.
pub fn run(seed: u64, inputs: u64, done: &AtomicU64) -> Tally {
    let mut tally = Tally::default();
    let mut fed = 0;
    while fed < inputs {
        let life = seed.wrapping_mul(1_000_003).wrapping_add(fed / LIFE);
        let mut dice = Dice::new(life);
        let mut subject = Subject::new(life);
        let mut author = Author::default();
        for _ in 0..LIFE.min(inputs - fed) {
            let bytes = author.next(&mut dice, &subject);
            subject.pass_time(author.pause_ms(&mut dice));
            for reply in subject.feed(&bytes, &mut tally) {
                author.hear(&reply);
            }
            for _ in 0..dice.below(4) {
                subject.poll(&mut tally);
            }
            fed += 1;
            done.fetch_add(1, Ordering::Relaxed);
        }
    }
    tally
}

/// Feeds one input to a device that has just started.
///
/// # Panics
/// As [`run`].
pub fn once(bytes: &[u8]) {
    let mut subject = Subject::new(1);
    let mut tally = Tally::default();
    subject.feed(bytes, &mut tally);
    subject.poll(&mut tally);
}
