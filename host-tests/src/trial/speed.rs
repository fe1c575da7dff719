//! How long a diagnosis of a minute-long recording takes.

use std::fs;
use std::io;
use std::path::Path;

use std::process::Command;

use quadcal_host::mechanism::Mechanism;
use thiserror::Error;

use super::run::Quadcal;
use super::score::{Answer, Named};

/// Most that it may take, s.
pub const LIMIT_S: f64 = 5.0;

/// 6000 edges a turn at 25 r/min for 60 s: 150,000 edges.
const TWIN: &str = "\
duration = { seconds = 60.0 }

[encoder.quadrature]
lines = 1500
index = true

[errors]
seed = 7
position = { normal = { rms_rad = 2e-5 } }
width_a_rad = 4e-5
width_b_rad = -3e-5
quadrature_rad = 5e-5

[shaft]
inertia_kg_m2 = 1e-4
viscous_n_m_s = 1e-4
stiffness_n_m_s = 4e-4

[drive.constant]
r_min = 25

[noise.white]
psd_n2_m2_s = 1e-13

[timer]
clock_hz = 84_000_000
jitter_s = 1e-7
";

/// What the recordings have that the twin has not, each large enough to be found.
const MISSING: [(&[Mechanism], &str); 3] = [
    (&[], ""),
    (
        &[Mechanism::GearMesh],
        "[[gear_mesh]]\norder = 7.3\ntorque_n_m = 2e-6\n",
    ),
    (
        &[
            Mechanism::EdgeDelay,
            Mechanism::TorqueTone,
            Mechanism::Eccentricity,
        ],
        "[edge_delay]\na = { rise_s = 4e-7 }\nb = { rise_s = 4e-7 }\n[[torque_tone]]\nf_hz = 11.0\ntorque_n_m = 1e-5\n",
    ),
];

/// Why there is no time.
#[derive(Debug, Error)]
pub enum SpeedError {
    /// A file can't be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The recording can't be simulated.
    #[error("quadcal simulate: {0}")]
    Simulate(String),
}

/// A diagnosis timed.
#[derive(Clone, Debug)]
pub struct Timed {
    /// What the twin lacks.
    pub missing: &'static [Mechanism],
    /// Edges of the recording, index not counted.
    pub edges: usize,
    /// What was said, and how long it took.
    pub answer: Answer,
}

impl Timed {
    /// What the twin lacks, each with how it was found, in words.
    #[must_use]
    pub fn missing(&self) -> String {
        if self.missing.is_empty() {
            return "nothing".to_owned();
        }
        let each = self.missing.iter();
        let each: Vec<String> = each
            .map(|one| format!("{} ({})", one.id(), self.how(*one)))
            .collect();
        each.join(", ")
    }

    /// How a mechanism that the twin lacks was found: at one speed it may be a look-alike of what was named.
    fn how(&self, missing: Mechanism) -> &'static str {
        let findings = self.answer.said.as_ref();
        let findings = findings.map_or(&[][..], |diagnosis| &diagnosis.findings);
        if findings.iter().any(|found| found.mechanism == missing) {
            "named"
        } else if findings
            .iter()
            .any(|found| found.look_alikes.contains(&missing))
        {
            "among the look-alikes"
        } else {
            "missed"
        }
    }

    /// What was named, in words.
    #[must_use]
    pub fn named(&self) -> String {
        match &self.answer.said {
            Ok(diagnosis) if diagnosis.findings.is_empty() => Named::None.id().to_owned(),
            Ok(diagnosis) => {
                let ids: Vec<&str> = diagnosis
                    .findings
                    .iter()
                    .map(|f| f.mechanism.id())
                    .collect();
                ids.join(", ")
            }
            Err(why) => format!("failed: {why}"),
        }
    }
}

/// Simulates recordings of a minute in a folder, with an absolute path, and times the diagnosis of each.
///
/// # Errors
/// [`SpeedError`] where a recording can't be made.
pub fn minute(quadcal: &Quadcal, folder: &Path) -> Result<Vec<Timed>, SpeedError> {
    let each = MISSING.into_iter().enumerate();
    each.map(|(number, (missing, more))| {
        let folder = folder.join(format!("minute-{number}"));
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("twin.toml"), TWIN)?;
        // Eccentricity is a key of a section that is there already.
        let real = if missing.contains(&Mechanism::Eccentricity) {
            TWIN.replace(
                "\n[shaft]",
                "eccentricity = { amplitude_rad = 1e-3, phase_rad = 1.0 }\n\n[shaft]",
            )
        } else {
            TWIN.to_owned()
        };
        fs::write(
            folder.join("rig.toml"),
            format!("seed = 11\n{real}\n{more}"),
        )?;
        let output = Command::new(&quadcal.program)
            .current_dir(&folder)
            .args(["simulate", "rig.toml", "-o", "rec.csv", "--quiet"])
            .output()?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            return Err(SpeedError::Simulate(said));
        }
        let text = fs::read_to_string(folder.join("rec.csv"))?;
        let rows: Vec<&str> = text
            .lines()
            .filter(|line| line.starts_with(|first: char| first.is_ascii_digit()))
            .collect();
        let level = |row: &str| row.ends_with(",1");
        let index = rows
            .windows(2)
            .filter(|pair| level(pair[0]) != level(pair[1]));
        let edges = rows.len() - index.count();
        let answer = quadcal.diagnose(&folder, &folder.join("answer.json"));
        Ok(Timed {
            missing,
            edges,
            answer,
        })
    })
    .collect()
}
