//! A reference encoder's angles, and the errors of ours against them.

use std::f64::consts::TAU;
use std::io::Read;

use quadcal::corrector::CorrectedEdge;
use quadcal::shape::EncoderShape;
use quadcal::units::TurnDelta32;
use thiserror::Error;

use super::ReferenceCheck;

/// Why a reference can't be read. Rows are counted with the heading as row 1.
#[derive(Debug, Error)]
pub enum ReferenceError {
    /// The file can't be read as CSV.
    #[error("{name}: {source}; a reference is CSV with the columns time (s) and angle_rad")]
    Csv {
        /// File name.
        name: String,
        /// What the reader found.
        source: csv::Error,
    },
    /// A column is missing.
    #[error(
        "{name}:1: no column '{column}' (found: {found}); a reference has the columns time (s) and angle_rad"
    )]
    Column {
        /// File name.
        name: String,
        /// The column looked for.
        column: &'static str,
        /// The columns there are.
        found: String,
    },
    /// A value is no finite number.
    #[error("{name}:{line}: '{value}' in column '{column}' is not a finite number")]
    Number {
        /// File name.
        name: String,
        /// Line in the file.
        line: u64,
        /// Its column.
        column: &'static str,
        /// The text found.
        value: String,
    },
    /// Time does not rise.
    #[error(
        "{name}:{line}: time {time} s is not after the {before} s above it; sort the reference by time"
    )]
    Order {
        /// File name.
        name: String,
        /// Line in the file.
        line: u64,
        /// Time there.
        time: f64,
        /// Time on the line above.
        before: f64,
    },
    /// Fewer than two rows.
    #[error("{name}: a reference needs at least two rows, this one has {rows}")]
    Short {
        /// File name.
        name: String,
        /// Rows there are.
        rows: usize,
    },
}

/// Reference angle over time, seconds on the recording's clock (tick 0 is 0 s).
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    points: Vec<(f64, f64)>,
    ratio: f64,
}

impl Reference {
    /// Reads `time,angle_rad` rows. The reference turns `ratio` times as fast as the encoder.
    ///
    /// # Errors
    /// [`ReferenceError`] with the line at fault.
    pub fn read(reader: impl Read, name: &str, ratio: f64) -> Result<Self, ReferenceError> {
        let csv_error = |source| ReferenceError::Csv {
            name: name.to_owned(),
            source,
        };
        let mut csv = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(reader);
        let headings = csv.headers().map_err(csv_error)?.clone();
        let place = |column: &'static str| {
            headings
                .iter()
                .position(|heading| heading.eq_ignore_ascii_case(column))
                .ok_or_else(|| {
                    let found = headings.iter().collect::<Vec<_>>().join(", ");
                    ReferenceError::Column {
                        name: name.to_owned(),
                        column,
                        found,
                    }
                })
        };
        let places = [("time", place("time")?), ("angle_rad", place("angle_rad")?)];
        let mut points: Vec<(f64, f64)> = Vec::new();
        for record in csv.records() {
            let record = record.map_err(csv_error)?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |(column, place): (&'static str, usize)| {
                let text = record.get(place).unwrap_or_default();
                text.parse::<f64>()
                    .ok()
                    .filter(|value| value.is_finite())
                    .ok_or_else(|| ReferenceError::Number {
                        name: name.to_owned(),
                        line,
                        column,
                        value: text.escape_debug().collect(),
                    })
            };
            let (time, angle) = (number(places[0])?, number(places[1])?);
            if let Some(&(before, _)) = points.last()
                && time <= before
            {
                return Err(ReferenceError::Order {
                    name: name.to_owned(),
                    line,
                    time,
                    before,
                });
            }
            points.push((time, angle));
        }
        if points.len() < 2 {
            return Err(ReferenceError::Short {
                name: name.to_owned(),
                rows: points.len(),
            });
        }
        Ok(Self { points, ratio })
    }

    /// Angle of the encoder's shaft by the reference, looked for from `hint` on; none outside the reference's times.
    fn angle_at(&self, time: f64, hint: &mut usize) -> Option<f64> {
        while *hint > 0 && self.points[*hint].0 > time {
            *hint -= 1;
        }
        while *hint + 2 < self.points.len() && self.points[*hint + 1].0 < time {
            *hint += 1;
        }
        let ((t0, a0), (t1, a1)) = (self.points[*hint], self.points[*hint + 1]);
        (t0..=t1)
            .contains(&time)
            .then(|| (a0 + (a1 - a0) * (time - t0) / (t1 - t0)) / self.ratio)
    }
}

/// Runs along a recording and takes e = theta_2 - theta_1 / r, equation (21), at every edge.
pub(super) struct Comparison {
    reference: Reference,
    clock_hz: f64,
    hint: usize,
    angles: [f64; 2],
    /// Of the stretch since the last interruption, whose origin is free.
    stretch: Sums,
    /// Of all stretches before, each with its own mean taken out.
    all: Sums,
}

/// Sums of both errors over all edges and over each edge of the turn.
struct Sums {
    count: f64,
    sum: [f64; 2],
    squares: [f64; 2],
    edges: Vec<([f64; 2], f64)>,
}

impl Sums {
    fn new(edges: usize) -> Self {
        Self {
            count: 0.0,
            sum: [0.0; 2],
            squares: [0.0; 2],
            edges: vec![([0.0; 2], 0.0); edges],
        }
    }
}

impl Comparison {
    #[allow(clippy::cast_precision_loss)]
    pub(super) fn new(reference: Reference, shape: EncoderShape, clock_hz: u64) -> Self {
        let edges = shape.edges() as usize;
        Self {
            reference,
            clock_hz: clock_hz as f64,
            hint: 0,
            angles: [0.0; 2],
            stretch: Sums::new(edges),
            all: Sums::new(edges),
        }
    }

    /// The count of edges was lost: what follows has an origin of its own.
    pub(super) fn interrupt(&mut self) {
        self.angles = [0.0; 2];
        if self.stretch.count == 0.0 {
            return;
        }
        let stretch = std::mem::replace(&mut self.stretch, Sums::new(self.all.edges.len()));
        let mean = stretch.sum.map(|sum| sum / stretch.count);
        self.all.count += stretch.count;
        for (which, mean) in mean.iter().enumerate() {
            self.all.squares[which] += stretch.squares[which] - stretch.sum[which] * mean;
        }
        for (all, edge) in self.all.edges.iter_mut().zip(&stretch.edges) {
            for (which, mean) in mean.iter().enumerate() {
                all.0[which] += edge.0[which] - mean * edge.1;
            }
            all.1 += edge.1;
        }
    }

    pub(super) fn push(&mut self, edge: u32, before: &CorrectedEdge, after: &CorrectedEdge) {
        let rad = |moved: TurnDelta32| f64::from(moved.0) * (TAU / 4_294_967_296.0);
        #[allow(clippy::cast_precision_loss)]
        let mut shaft_at = |edge: &CorrectedEdge| {
            let time = edge.ticks as f64 / self.clock_hz - edge.late.seconds(self.clock_hz);
            self.reference.angle_at(time, &mut self.hint)
        };
        let (Some(shaft_before), Some(shaft_after)) = (shaft_at(before), shaft_at(after)) else {
            return;
        };
        let shaft = [shaft_before, shaft_after];
        if self.stretch.count == 0.0 {
            // Errors are counted from here on, so that their squares stay small.
            self.angles = shaft;
        } else {
            let [angle_before, angle_after] = self.angles;
            self.angles = [
                angle_before + rad(before.moved),
                angle_after + rad(after.moved),
            ];
        }
        let sums = &mut self.stretch;
        sums.count += 1.0;
        let place = &mut sums.edges[edge as usize];
        place.1 += 1.0;
        for (which, shaft) in shaft.into_iter().enumerate() {
            let error = self.angles[which] - shaft;
            sums.sum[which] += error;
            sums.squares[which] += error * error;
            place.0[which] += error;
        }
    }

    /// RMSE (22), each stretch with its own origin taken out; none when reference and recording do not overlap.
    pub(super) fn finish(mut self) -> Option<ReferenceCheck> {
        self.interrupt();
        let all = &self.all;
        if all.count == 0.0 {
            return None;
        }
        let rmse = |which: usize| (all.squares[which] / all.count).max(0.0).sqrt();
        let profile = |which: usize| {
            all.edges
                .iter()
                .map(|edge| edge.0[which] / edge.1.max(1.0))
                .collect()
        };
        let of_edges = all.edges.iter().filter(|edge| edge.1 > 0.0);
        let repeating: f64 = of_edges.map(|edge| edge.0[0].powi(2) / edge.1).sum();
        let wander = (all.squares[0] - repeating).max(0.0) / all.count;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Some(ReferenceCheck {
            wander_rad: wander.sqrt(),
            edges: all.count as u64,
            before_rad: rmse(0),
            after_rad: rmse(1),
            error_before_rad: profile(0),
            error_after_rad: profile(1),
        })
    }
}

#[cfg(test)]
mod tests;
