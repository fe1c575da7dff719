//! What the firmware of a real device supplies.

use std::hash::{BuildHasher, Hasher, RandomState};

use quadcal::access::Nonces;
use quadcal::recalibrate::{Interlock, Obstacle};
use quadcal::wire::Nonce;

/// What the drive allows.
pub(super) struct Switches {
    pub calibrate: Option<Obstacle>,
    pub commit: Option<Obstacle>,
}

impl Interlock for Switches {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        self.calibrate.map_or(Ok(()), Err)
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        self.commit.map_or(Ok(()), Err)
    }
}

/// Nonces from the keys that the standard library draws for its hash tables: good enough for a device that is not there.
pub(super) struct Drawn;

impl Nonces for Drawn {
    fn nonce(&mut self) -> Option<Nonce> {
        let draw = || RandomState::new().build_hasher().finish().to_le_bytes();
        let mut nonce = [0; 16];
        let (low, high) = nonce.split_at_mut(8);
        low.copy_from_slice(&draw());
        high.copy_from_slice(&draw());
        Some(nonce)
    }
}
