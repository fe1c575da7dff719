//! Captures that come late.

use super::random::{Purpose, Stream};
use crate::twin::{CaptureLatency, Twin};

/// What holds a capture up.
#[derive(Clone, Debug)]
pub(super) enum Latency {
    /// Nothing.
    None,
    /// A new exponential time for each.
    Exponential { mean_s: f64, random: Box<Stream> },
    /// Until a task's busy time ends.
    Task {
        rate_hz: f64,
        busy_s: f64,
        phase_s: f64,
    },
}

impl Latency {
    pub(super) fn new(twin: &Twin) -> Self {
        match twin.capture_latency {
            Some(CaptureLatency {
                mean_s: Some(mean_s),
                ..
            }) => Self::Exponential {
                mean_s,
                random: Box::new(Stream::new(twin.seed, Purpose::Latency)),
            },
            Some(CaptureLatency {
                task_hz: Some(rate_hz),
                busy_s,
                phase_s,
                ..
            }) => Self::Task {
                rate_hz,
                busy_s: busy_s.unwrap_or(0.0),
                phase_s: phase_s.unwrap_or(0.0),
            },
            _ => Self::None,
        }
    }

    /// When a change that arrives at a time is captured, s.
    pub(super) fn captured_s(&mut self, arrival_s: f64) -> f64 {
        match self {
            Self::None => arrival_s,
            // 1 - u is never 0, so the logarithm is finite.
            Self::Exponential { mean_s, random } => {
                arrival_s - *mean_s * libm::log(1.0 - random.unit())
            }
            Self::Task {
                rate_hz,
                busy_s,
                phase_s,
            } => {
                let period = ((arrival_s - *phase_s) * *rate_hz).floor();
                let end = period / *rate_hz + *phase_s + *busy_s;
                // Before its first time the task does not run.
                if period >= 0.0 && arrival_s < end {
                    end
                } else {
                    arrival_s
                }
            }
        }
    }
}
