//! Reads the CSV list of an encoder's errors that a twin may name.
//!
//! A list with `k,e_rad` numbers edges as the twin does. An exported error table (`edge,class,error_rad,..`) tells its own numbering by
//! the class of its edges: that of Hall sensors begins one edge later, and that of a wheel seen by one edge of each tooth counts teeth.

use std::path::Path;

use super::Class;
use super::disc::class_of;
use crate::twin::{Encoder, ErrorListFault, TwinError, csv_file};

/// Where the columns are.
struct Columns {
    k: usize,
    e_rad: usize,
    class: Option<usize>,
}

impl Columns {
    fn of(header: &csv::StringRecord) -> Option<Self> {
        let place = |names: &[&str]| header.iter().position(|name| names.contains(&name));
        Some(Self {
            k: place(&["k", "edge"])?,
            e_rad: place(&["e_rad", "error_rad"])?,
            class: place(&["class"]),
        })
    }
}

/// From the numbers of a list to edges of the grid.
#[derive(Clone, Copy, PartialEq)]
enum Numbering {
    /// The edge comes so many steps later on the twin's grid.
    Edges { later: u32 },
    /// Teeth: both edges have the error.
    Teeth,
}

impl Numbering {
    /// That of a list with edge `k` of the class `name`.
    fn of(encoder: &Encoder, k: u32, name: &str) -> Option<Self> {
        if name == "tooth" && matches!(encoder, Encoder::Wheel { .. }) {
            return Some(Self::Teeth);
        }
        let group = encoder.edges_per_line();
        let class = class_named(name)?;
        let later = (0..group).find(|later| class_of(encoder, k % group + later) == class)?;
        // By the shorter way round.
        Some(Self::Edges {
            later: if 2 * later > group {
                encoder.grid_edges() - (group - later)
            } else {
                later
            },
        })
    }
}

fn class_named(name: &str) -> Option<Class> {
    Some(match name {
        "A rises" | "tooth begins" => Class::ARise,
        "A falls" | "tooth ends" => Class::AFall,
        "B rises" => Class::BRise,
        "B falls" => Class::BFall,
        "C rises" => Class::CRise,
        "C falls" => Class::CFall,
        _ => return None,
    })
}

/// RMS of the standard errors of a list; 0 where it has none.
pub(super) fn spread_rad(path: &Path) -> Result<f64, TwinError> {
    let fault = |line: u64, fault: ErrorListFault| TwinError::ErrorList {
        path: path.to_owned(),
        line,
        fault,
    };
    let mut reader = csv_file::open(path)?;
    let header = reader.headers().map_err(|e| fault(1, e.into()))?;
    let Some(at) = header.iter().position(|name| name == "standard_error_rad") else {
        return Ok(0.0);
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for record in reader.records() {
        let record =
            record.map_err(|e| fault(e.position().map_or(1, csv::Position::line), e.into()))?;
        let line = record.position().map_or(1, csv::Position::line);
        let field = record.get(at).unwrap_or_default();
        let number = |_| {
            fault(
                line,
                ErrorListFault::Number(field.chars().take(40).collect()),
            )
        };
        let error: f64 = field.parse().map_err(number)?;
        if !error.is_finite() {
            return Err(fault(line, ErrorListFault::NotFinite(error)));
        }
        sum += error * error;
        count += 1.0;
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

/// e(k) of every edge of the grid, rad; those of missing teeth may be left out.
pub(super) fn read(path: &Path, encoder: &Encoder) -> Result<Vec<f64>, TwinError> {
    let fault = |line: u64, fault: ErrorListFault| TwinError::ErrorList {
        path: path.to_owned(),
        line,
        fault,
    };
    let broken = |e: csv::Error| {
        let line = e.position().map_or(1, csv::Position::line);
        fault(line, e.into())
    };
    let mut reader = csv_file::open(path)?;
    let columns = Columns::of(reader.headers().map_err(broken)?)
        .ok_or_else(|| fault(1, ErrorListFault::Header))?;
    let edges = encoder.grid_edges();
    let mut numbering = None;
    let mut found: Vec<Option<f64>> = vec![None; edges as usize];
    let mut record = csv::StringRecord::new();
    let mut line = 1;
    while reader.read_record(&mut record).map_err(broken)? {
        line = record.position().map_or(line, csv::Position::line);
        let field = |at: usize| record.get(at).unwrap_or_default();
        let bad = |at: usize| {
            fault(
                line,
                ErrorListFault::Number(field(at).chars().take(40).collect()),
            )
        };
        let k: u32 = field(columns.k).parse().map_err(|_| bad(columns.k))?;
        let e_rad: f64 = field(columns.e_rad)
            .parse()
            .map_err(|_| bad(columns.e_rad))?;
        if !e_rad.is_finite() {
            return Err(fault(line, ErrorListFault::NotFinite(e_rad)));
        }
        let class = columns.class.map(field);
        let this = class.map_or(Some(Numbering::Edges { later: 0 }), |name| {
            Numbering::of(encoder, k, name)
        });
        let numbering = *numbering.get_or_insert(this);
        let Some(known) = numbering.filter(|_| numbering == this) else {
            let class = class.unwrap_or_default().chars().take(40).collect();
            return Err(fault(line, ErrorListFault::Class { k, class }));
        };
        // Edges for each number of the list, and how much later they come.
        let (each, later) = match known {
            Numbering::Edges { later } => (1, later),
            Numbering::Teeth => (2, 0),
        };
        let last = edges / each - 1;
        if k > last {
            return Err(fault(line, ErrorListFault::OutOfGrid { k, last }));
        }
        for edge in each * k..each * (k + 1) {
            let slot = &mut found[((edge + later) % edges) as usize];
            if slot.replace(e_rad).is_some() {
                return Err(fault(line, ErrorListFault::Twice(k)));
            }
        }
    }
    let missing = |k: u32| match numbering.flatten() {
        Some(Numbering::Edges { later }) => (k + edges - later) % edges,
        Some(Numbering::Teeth) => k / 2,
        None => k,
    };
    (0..edges)
        .zip(found)
        .map(|(k, e)| match e {
            Some(e) => Ok(e),
            None if !encoder.is_real(k) => Ok(0.0),
            None => Err(fault(line, ErrorListFault::Missing(missing(k)))),
        })
        .collect()
}
