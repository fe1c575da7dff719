//! Ranges and conflicts of delays.

use super::Checker;
use crate::twin::{Encoder, Twin};

impl Twin {
    pub(super) fn check_delays(&self, c: &mut Checker<'_>) {
        let e = self.edge_delay.unwrap_or_default();
        let s = self.channel_skew.unwrap_or_default();
        let hall = matches!(self.encoder, Encoder::Hall { .. });
        let two = hall || matches!(self.encoder, Encoder::Quadrature { .. });
        for (key, delay_s, has_channel) in [
            ("edge_delay.a.rise_s", e.a.rise_s, true),
            ("edge_delay.a.fall_s", e.a.fall_s, true),
            ("edge_delay.b.rise_s", e.b.rise_s, two),
            ("edge_delay.b.fall_s", e.b.fall_s, two),
            ("edge_delay.c.rise_s", e.c.rise_s, hall),
            ("edge_delay.c.fall_s", e.c.fall_s, hall),
            ("channel_skew.a_s", s.a_s, true),
            ("channel_skew.b_s", s.b_s, two),
            ("channel_skew.c_s", s.c_s, hall),
        ] {
            c.between(
                key,
                delay_s,
                0.0,
                1.0,
                "no edge is captured before it happens: delay the others instead",
            );
            c.require(
                has_channel || delay_s == 0.0,
                key,
                delay_s,
                "0 for this kind of encoder",
                "take it out, or change the encoder's kind",
            );
        }
    }
}
