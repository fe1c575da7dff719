//! Curves over time that a drive follows: speeds and torques, as points in the twin or in a CSV file beside it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::CurveFault;
use super::{Step, TwinError, csv_file, is_zero};

/// Latest time of a point, s.
const TIME_MAX_S: f64 = 1e7;
/// Largest speed, r/min, and torque, N m.
const VALUE_MAX: f64 = 1e6;
/// Most points of a curve.
pub(super) const POINTS_MAX: usize = 1_000_000;

/// `drive.profile`: a speed that goes in a straight line from point to point, as many ramps and holds as there are. The first point's
/// speed holds until then, the last one's from then on; two points at one time make a jump.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedProfile {
    /// Points, by time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<Step>,
    /// The same as a CSV file with `t_s,r_min`; the path is relative to the twin's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// The points of that file.
    #[serde(skip)]
    pub(super) listed: Vec<Step>,
}

impl SpeedProfile {
    /// Of points in the twin.
    #[must_use]
    pub fn new(points: Vec<Step>) -> Self {
        Self {
            points,
            ..Self::default()
        }
    }

    /// The points, wherever they stand.
    #[must_use]
    pub fn points(&self) -> &[Step] {
        match self.csv {
            Some(_) => &self.listed,
            None => &self.points,
        }
    }

    /// Speed at time 0, r/min.
    #[must_use]
    pub fn start_r_min(&self) -> f64 {
        let points = self.points();
        let begun = points.partition_point(|point| point.t_s <= 0.0);
        let first = points.get(begun.saturating_sub(1));
        first.map_or(0.0, |point| point.r_min)
    }
}

/// `drive.torque`: an open-loop torque in a straight line from point to point, constant before the first and after the last, as a torque
/// command or a measured motor current gives it. Friction and loads then decide the speed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueProfile {
    /// Speed at time 0; what speeds are relative to, too.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub start_r_min: f64,
    /// Points, by time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<TorquePoint>,
    /// The same as a CSV file with `t_s,torque_n_m`; the path is relative to the twin's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// The points of that file.
    #[serde(skip)]
    pub(super) listed: Vec<TorquePoint>,
}

impl TorqueProfile {
    /// Of points in the twin, and the speed at time 0.
    #[must_use]
    pub fn new(start_r_min: f64, points: Vec<TorquePoint>) -> Self {
        Self {
            start_r_min,
            points,
            ..Self::default()
        }
    }

    /// The points, wherever they stand.
    #[must_use]
    pub fn points(&self) -> &[TorquePoint] {
        match self.csv {
            Some(_) => &self.listed,
            None => &self.points,
        }
    }
}

/// One point of a torque curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorquePoint {
    /// Time.
    pub t_s: f64,
    /// Torque on the shaft, positive forward.
    pub torque_n_m: f64,
}

/// Time and value of every row of a curve's file with the columns `t_s` and `column`; others are left aside.
pub(super) fn read(path: &Path, column: &'static str) -> Result<Vec<(f64, f64)>, TwinError> {
    let fault = |line: u64, fault: CurveFault| TwinError::Curve {
        path: path.to_owned(),
        line,
        fault,
    };
    let broken = |e: csv::Error| {
        let line = e.position().map_or(1, csv::Position::line);
        fault(line, CurveFault::Csv { column, source: e })
    };
    let mut reader = csv_file::open(path)?;
    let headers = reader.headers().map_err(broken)?;
    let place = |wanted: &str| headers.iter().position(|name| name == wanted);
    let (Some(time_at), Some(value_at)) = (place("t_s"), place(column)) else {
        return Err(fault(1, CurveFault::Header(column)));
    };
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut record = csv::StringRecord::new();
    let mut last_s = 0.0;
    while reader.read_record(&mut record).map_err(broken)? {
        let line = record.position().map_or(1, csv::Position::line);
        let number = |at: usize, column| {
            let text = record.get(at).unwrap_or_default();
            let bad = || CurveFault::Number {
                column,
                found: text.chars().take(40).collect(),
            };
            text.parse::<f64>().map_err(|_| fault(line, bad()))
        };
        let (time_s, value) = (number(time_at, "t_s")?, number(value_at, column)?);
        if !(last_s..=TIME_MAX_S).contains(&time_s) {
            let found = time_s;
            return Err(fault(line, CurveFault::Time { found, last_s }));
        }
        if !(-VALUE_MAX..=VALUE_MAX).contains(&value) {
            let found = value;
            return Err(fault(line, CurveFault::Value { column, found }));
        }
        if points.len() == POINTS_MAX {
            return Err(fault(line, CurveFault::Points));
        }
        last_s = time_s;
        points.push((time_s, value));
    }
    if points.is_empty() {
        return Err(fault(1, CurveFault::Empty));
    }
    Ok(points)
}
