//! What an encoder makes of what was drained, held against the shaft.

use std::vec::Vec;

use super::shaft::{LINES, Shaft};
use crate::capture::{Event, Loss};
use crate::edge::Sample;
use crate::encoder::{Encoder, EncoderConfig};

/// An encoder that knows where levels began.
pub fn encoder() -> Encoder<'static> {
    let mut encoder = Encoder::new(EncoderConfig::new(LINES, 1_000_000), None).unwrap();
    encoder.edge_at(Sample {
        ticks: 0,
        levels: Shaft::START,
    });
    encoder
}

/// Feeds what was drained to an encoder and holds its position against the shaft's, told by the samples of all edges: right, or in doubt.
/// Returns what was missed, and how many samples came in doubt and without.
pub fn right_or_doubtful(events: &[Event], samples: &[Sample]) -> (Vec<Loss>, u32, u32) {
    let mut encoder = encoder();
    // The shaft as it is in truth, by itself: referenced, right from the start.
    let mut truth = self::encoder();
    let positions: Vec<_> = samples
        .iter()
        .map(|sample| {
            truth.edge_at(*sample);
            let decoder = truth.decoder();
            (sample.ticks, decoder.position(), decoder.is_referenced())
        })
        .collect();
    assert_eq!(truth.faults().total(), 0);
    let (mut missed, mut doubtful, mut sure) = (Vec::new(), 0, 0);
    for event in events {
        encoder.take(*event);
        match event {
            Event::Missed(loss) => missed.push(*loss),
            Event::Change(sample) => {
                let (_, position, referenced) = *positions
                    .iter()
                    .rfind(|(ticks, ..)| *ticks <= sample.ticks)
                    .unwrap();
                let decoder = encoder.decoder();
                if decoder.is_uncertain() {
                    doubtful += 1;
                } else {
                    sure += 1;
                    let at = sample.ticks;
                    assert_eq!(decoder.is_referenced(), referenced, "at {at}");
                    assert_eq!(decoder.position(), position, "at {at}");
                }
            }
        }
    }
    assert_eq!(encoder.faults().missed as usize, missed.len());
    (missed, doubtful, sure)
}
