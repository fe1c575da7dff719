//! Captures that come late.

use serde::{Deserialize, Serialize};

/// `capture_latency`: the time of a stamp is late, the order of edges is kept. Either the exponential latency of an interrupt, or a task
/// that blocks captures: edges in its busy time, from n / task_hz + phase on, are stamped at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaptureLatency {
    /// Mean of an exponential latency, own for every capture; 0 to 1 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_s: Option<f64>,
    /// Rate of the task, 1 mHz to 10 MHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task_hz: Option<f64>,
    /// How long it blocks each time, less than its period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub busy_s: Option<f64>,
    /// When it first blocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_s: Option<f64>,
}
