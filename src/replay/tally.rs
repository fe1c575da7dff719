//! What a stream of events amounts to.

use crc::{CRC_32_ISO_HDLC, Crc};

use super::Event;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Counts and checksum over a stream of events: host and target agree on these if the stream came through whole.
#[derive(Clone)]
pub struct Tally {
    /// Captures seen.
    pub captures: u32,
    /// Captures whose handler found an overflow pending.
    pub pending: u32,
    /// Overflows served.
    pub overflows: u32,
    crc: crc::Digest<'static, u32>,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            captures: 0,
            pending: 0,
            overflows: 0,
            crc: CRC.digest(),
        }
    }
}

impl Tally {
    /// Takes in one event.
    pub fn add(&mut self, event: &Event) {
        match event {
            Event::Capture {
                overflow_pending, ..
            } => {
                self.captures = self.captures.wrapping_add(1);
                self.pending = self.pending.wrapping_add(u32::from(*overflow_pending));
            }
            Event::Overflow => self.overflows = self.overflows.wrapping_add(1),
        }
        self.crc.update(&event.emit());
    }

    /// CRC-32 (ISO-HDLC) over the records' bytes so far.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        self.crc.clone().finalize()
    }

    /// Bytes of the result file: captures, pending, overflows and checksum, each 32 bits little endian.
    #[must_use]
    pub fn emit(&self) -> [u8; 16] {
        let [a0, a1, a2, a3] = self.captures.to_le_bytes();
        let [b0, b1, b2, b3] = self.pending.to_le_bytes();
        let [c0, c1, c2, c3] = self.overflows.to_le_bytes();
        let [d0, d1, d2, d3] = self.checksum().to_le_bytes();
        [
            a0, a1, a2, a3, b0, b1, b2, b3, c0, c1, c2, c3, d0, d1, d2, d3,
        ]
    }
}
