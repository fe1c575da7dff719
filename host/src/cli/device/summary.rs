//! The results of device commands as JSON. Fields are described in `docs/device-json.md`, which a test holds to these.

use quadcal::recalibrate::{Figures, Stage};
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::{Identity, Learned, LogLevel, Status, TableInfo};
use serde::Serialize;

use crate::device::{class_name, failure_name, failure_text, stage_name};

/// 2^-32 turn in rad.
pub(super) fn rad(turn32: u32) -> f64 {
    f64::from(turn32) * RAD_PER_TURN32
}

/// Who a device is.
#[derive(Debug, Serialize)]
pub(super) struct IdentitySummary {
    port: String,
    firmware: String,
    protocol_version: u8,
    slot_version: u16,
    pub edges_per_turn: u32,
    pub edge_classes: u8,
    pub clock_hz: u64,
    pub serial: Option<u64>,
}

impl IdentitySummary {
    pub fn new(port: &str, identity: &Identity) -> Self {
        let [major, minor, patch] = identity.firmware;
        Self {
            port: port.to_owned(),
            firmware: format!("{major}.{minor}.{patch}"),
            protocol_version: quadcal::wire::VERSION,
            slot_version: identity.slot_version,
            edges_per_turn: identity.edges,
            edge_classes: identity.classes,
            clock_hz: identity.clock_hz,
            serial: given(identity.serial),
        }
    }
}

fn given(number: u64) -> Option<u64> {
    (number != 0).then_some(number)
}

/// The table in use.
#[derive(Debug, Serialize)]
pub(super) struct TableSummary {
    place: &'static str,
    pub sequence: u32,
    turns: u32,
    standard_error_rad: f64,
    table_rms_rad: f64,
    serial: Option<u64>,
    learned_at_unix_s: Option<u64>,
    temperature_c: Option<f64>,
}

impl TableSummary {
    pub fn new(table: &TableInfo) -> Self {
        Self {
            place: if table.place == 0 { "A" } else { "B" },
            sequence: table.sequence,
            turns: table.turns,
            standard_error_rad: rad(table.standard_error),
            table_rms_rad: rad(table.table_rms),
            serial: given(table.serial),
            learned_at_unix_s: given(table.learned_at),
            temperature_c: table.temperature_q4.map(|q4| f64::from(q4) / 16.0),
        }
    }
}

/// Why a calibration came to nothing.
#[derive(Debug, Serialize)]
pub(super) struct FailureSummary {
    reason: &'static str,
    text: String,
}

impl FailureSummary {
    pub fn new(failure: &quadcal::recalibrate::Failure) -> Self {
        Self {
            reason: failure_name(failure),
            text: failure_text(failure),
        }
    }
}

/// Where things stand.
#[derive(Debug, Serialize)]
pub(super) struct StatusSummary {
    port: String,
    stage: &'static str,
    failure: Option<FailureSummary>,
    turns: u32,
    turns_wanted: u32,
    rejected_turns: u32,
    solved_percent: u8,
    session_open: bool,
    table: Option<TableSummary>,
    erasures: [u32; 2],
    log_level: &'static str,
    unreadable_frames: u32,
    uptime_s: f64,
}

impl StatusSummary {
    #[allow(clippy::cast_precision_loss)]
    pub fn new(port: &str, status: &Status) -> Self {
        Self {
            port: port.to_owned(),
            stage: stage_name(status.stage),
            failure: match &status.stage {
                Stage::Failed(failure) => Some(FailureSummary::new(failure)),
                _ => None,
            },
            turns: status.turns,
            turns_wanted: status.turns_wanted,
            rejected_turns: status.rejected,
            solved_percent: status.solved_percent,
            session_open: status.session,
            table: status.table.as_ref().map(TableSummary::new),
            erasures: status.wear,
            log_level: level_name(status.log_level),
            unreadable_frames: status.bad_frames,
            uptime_s: status.uptime_ms as f64 / 1e3,
        }
    }
}

pub(super) const fn level_name(level: LogLevel) -> &'static str {
    match level {
        LogLevel::Off => "off",
        LogLevel::Error => "error",
        LogLevel::Warn => "warn",
        LogLevel::Info => "info",
        LogLevel::Debug => "debug",
    }
}

/// How far edges are off with a table.
#[derive(Debug, Serialize)]
struct ScatterSummary {
    interval_rms_rad: f64,
    angle_rms_rad: f64,
}

/// New table against old on fresh turns.
#[derive(Debug, Serialize)]
pub(super) struct ProofSummary {
    turns: u32,
    rejected_turns: u32,
    old: ScatterSummary,
    new: ScatterSummary,
    better: bool,
    worse: bool,
}

impl ProofSummary {
    pub fn new(figures: &Figures) -> Self {
        let scatter = |scatter: quadcal::recalibrate::Scatter| ScatterSummary {
            interval_rms_rad: rad(scatter.interval),
            angle_rms_rad: rad(scatter.angle),
        };
        Self {
            turns: figures.turns,
            rejected_turns: figures.rejected,
            old: scatter(figures.old),
            new: scatter(figures.new),
            better: figures.better,
            worse: figures.is_worse(),
        }
    }
}

/// The preview.
#[derive(Debug, Serialize)]
pub(super) struct PreviewSummary {
    pub port: String,
    pub proof: Option<ProofSummary>,
}

/// Mean error and delay of an edge class.
#[derive(Debug, Serialize)]
struct ClassSummary {
    edge: String,
    offset_rad: f64,
    delay_s: f64,
}

/// What a calibration found.
#[derive(Debug, Serialize)]
pub(super) struct LearnedSummary {
    turns: u32,
    rejected_turns: u32,
    standard_error_rad: f64,
    class_standard_error_rad: f64,
    table_rms_rad: f64,
    classes: Vec<ClassSummary>,
}

impl LearnedSummary {
    #[allow(clippy::cast_precision_loss)]
    pub fn new(learned: &Learned, identity: &Identity) -> Self {
        let tick_s = 1.0 / identity.clock_hz.max(1) as f64;
        let count = usize::from(identity.classes);
        let classes = learned.class_offsets.iter().zip(learned.class_delays);
        Self {
            turns: learned.turns,
            rejected_turns: learned.rejected,
            standard_error_rad: rad(learned.standard_error),
            class_standard_error_rad: rad(learned.class_standard_error),
            table_rms_rad: rad(learned.table_rms),
            classes: classes
                .take(count)
                .enumerate()
                .map(|(class, (offset, delay))| ClassSummary {
                    edge: class_name(count, class),
                    offset_rad: f64::from(*offset) * RAD_PER_TURN32,
                    delay_s: f64::from(delay) / 256.0 * tick_s,
                })
                .collect(),
        }
    }
}

/// What came of a recalibration.
#[derive(Debug, Serialize)]
pub(super) struct CalibrationSummary {
    pub port: String,
    /// `committed`, `waiting`, `given_up`, `failed`, `stopped` or `unknown`.
    pub outcome: &'static str,
    pub failure: Option<FailureSummary>,
    pub learned: Option<LearnedSummary>,
    pub proof: Option<ProofSummary>,
    pub table: Option<TableSummary>,
}

/// What a command changed.
#[derive(Debug, Serialize)]
pub(super) struct ChangeSummary {
    pub port: String,
    pub done: &'static str,
    pub stage: &'static str,
    pub table: Option<TableSummary>,
    pub log_level: &'static str,
}

impl ChangeSummary {
    pub fn new(port: &str, done: &'static str, status: &Status) -> Self {
        Self {
            port: port.to_owned(),
            done,
            stage: stage_name(status.stage),
            table: status.table.as_ref().map(TableSummary::new),
            log_level: level_name(status.log_level),
        }
    }
}

/// A table read or handed over.
#[derive(Debug, Serialize)]
pub(super) struct TransferSummary {
    pub port: String,
    pub file: String,
    pub bytes: usize,
    pub edges_per_turn: u32,
    pub turns: u32,
    pub standard_error_rad: f64,
    pub committed: bool,
    /// `committed`, `waiting`, `worse`, `failed`, `stopped` or `unknown`, of a table handed over.
    pub outcome: Option<&'static str>,
    pub proof: Option<ProofSummary>,
    pub table: Option<TableSummary>,
}
