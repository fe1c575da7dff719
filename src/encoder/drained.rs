//! Captures that come drained, in place of an interrupt at each edge.

use super::{Corrected, Encoder};
use crate::capture::Event;
use crate::table::Entry;

impl<E: Entry, const BITS: u32> Encoder<'_, E, BITS> {
    /// Takes what a drain of captures gives. None where it is no edge, as in [`Self::edge`]. See
    /// [`CaptureSource`](crate::capture::CaptureSource) for an example.
    #[inline(always)]
    pub fn take(&mut self, event: Event) -> Option<Corrected> {
        match event {
            Event::Change(sample) => self.edge_at(sample),
            Event::Missed(_) => {
                self.missed();
                None
            }
        }
    }

    /// Captures are missing here, an unknown number: see
    /// [`QuadratureDecoder::missed`](crate::decoder::QuadratureDecoder::missed). Angles and speeds go on from the next edge on, as
    /// after lost edges.
    ///
    /// ```
    /// # use quadcal::encoder::{Encoder, EncoderConfig};
    /// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 1000), None).unwrap();
    /// encoder.missed();
    /// assert!(encoder.decoder().is_uncertain() && encoder.faults().missed == 1);
    /// ```
    #[cold]
    #[inline(never)]
    pub fn missed(&mut self) {
        self.catch_up();
        self.decoder.missed();
    }
}
