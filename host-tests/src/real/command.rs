//! `quadcal diagnose`, run as a user runs it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use quadcal_host::diagnose::diagnosis::{Diagnosis, Finding};
use quadcal_host::mechanism::Mechanism;
use quadcal_host::twin::Twin;

/// The command and the folder that it writes to.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The program.
    pub program: PathBuf,
    /// What `diagnose` is given on top of recordings and twins.
    pub arguments: Vec<String>,
    /// Folder for twins, answers and reports.
    pub folder: PathBuf,
}

/// What a diagnosis came to.
#[derive(Clone, Debug)]
pub struct Said {
    /// Its JSON.
    pub diagnosis: Diagnosis,
    /// The twin that it wrote.
    pub twin: Twin,
}

impl Bench {
    /// Diagnoses a recording against a twin in the folder, both by path; `name` is what the outputs are called.
    ///
    /// # Errors
    /// The command's own words where it fails.
    pub fn diagnose(&self, recording: &Path, twin: &Path, name: &str) -> Result<Said> {
        let file = |end: &str| self.folder.join(format!("{name}{end}"));
        let new = file("-new.toml");
        let output = Command::new(&self.program)
            .arg("diagnose")
            .args(&self.arguments)
            .arg(recording)
            .arg("--twin")
            .arg(twin)
            .arg("--json")
            .arg(file(".json"))
            .arg("--report")
            .arg(file(".html"))
            .arg("--write-twin")
            .arg(&new)
            .arg("--quiet")
            .output()
            .with_context(|| self.program.display().to_string())?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{name}: {said}");
        fs::write(file(".txt"), &output.stdout)?;
        let json = fs::read_to_string(file(".json"))?;
        Ok(Said {
            diagnosis: serde_json::from_str(&json)?,
            twin: Twin::load(&new)?,
        })
    }

    /// Writes a file into the folder.
    ///
    /// # Errors
    /// Where it can't be written.
    pub fn write(&self, name: &str, text: &str) -> Result<PathBuf> {
        let path = self.folder.join(name);
        fs::write(&path, text).with_context(|| path.display().to_string())?;
        Ok(path)
    }
}

impl Said {
    /// The finding of a mechanism.
    #[must_use]
    pub fn of(&self, mechanism: Mechanism) -> Option<&Finding> {
        let mut all = self.diagnosis.findings.iter();
        all.find(|finding| finding.mechanism == mechanism)
    }

    /// Names of the findings, strongest first.
    #[must_use]
    pub fn names(&self) -> String {
        let all = self.diagnosis.findings.iter();
        let names: Vec<String> = all.map(|finding| finding.mechanism.to_string()).collect();
        names.join(", ")
    }
}
