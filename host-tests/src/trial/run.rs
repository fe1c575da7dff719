//! `quadcal diagnose` on a case, as a process of its own that is given the open folder and nothing else.

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use process_control::{ChildExt, Control};
use quadcal_host::diagnose::diagnosis::Diagnosis;

use super::score::Answer;

/// Longest that one case may take; a command that hangs has failed.
const LIMIT: Duration = Duration::from_secs(180);

/// The command under trial.
#[derive(Clone, Debug)]
pub struct Quadcal {
    /// The program, as an absolute path.
    pub program: PathBuf,
}

impl Quadcal {
    /// What it says of its version.
    #[must_use]
    pub fn version(&self) -> String {
        let output = Command::new(&self.program).arg("--version").output();
        let said = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
        said.unwrap_or_else(|_| "of unknown version".to_owned())
    }

    /// Diagnoses the case in a folder; its JSON goes to `json`, an absolute path.
    #[must_use]
    pub fn diagnose(&self, folder: &Path, json: &Path) -> Answer {
        let begin = Instant::now();
        let ended = self.run(folder, json);
        let seconds = begin.elapsed().as_secs_f64();
        Answer {
            seconds,
            said: ended.and_then(|()| read(json)),
        }
    }

    fn run(&self, folder: &Path, json: &Path) -> Result<(), String> {
        let mut command = Command::new(&self.program);
        command.current_dir(folder).arg("diagnose");
        let files = files(folder);
        command.args(files.iter().map(|(recording, _)| recording));
        for (_, twin) in &files {
            command.args(["--twin", twin]);
        }
        command.arg("--json").arg(json).arg("--quiet");
        // What an earlier run left must not pass for an answer.
        let _ = fs::remove_file(json);
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", self.program.display()))?;
        let ended = child
            .controlled_with_output()
            .time_limit(LIMIT)
            .terminate_for_timeout()
            .wait()
            .map_err(|error| error.to_string())?;
        let Some(output) = ended else {
            return Err(format!("no end after {} s", LIMIT.as_secs()));
        };
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let lines = said.lines().filter(|line| !line.trim().is_empty());
        let first: Vec<&str> = lines.take(3).collect();
        Err(format!("{}: {}", output.status, first.join(" | ")))
    }
}

fn read(json: &Path) -> Result<Diagnosis, String> {
    let text = fs::read_to_string(json).map_err(|error| format!("no JSON: {error}"))?;
    serde_json::from_str(&text).map_err(|error| format!("JSON that can't be read: {error}"))
}

/// Recordings of a case with their twins.
fn files(folder: &Path) -> Vec<(String, String)> {
    if folder.join("rec.csv").exists() {
        return vec![("rec.csv".to_owned(), "twin.toml".to_owned())];
    }
    (1..)
        .map(|number| {
            let twin = match number {
                1 => "twin.toml".to_owned(),
                _ => format!("twin{number}.toml"),
            };
            (format!("rec{number}.csv"), twin)
        })
        .take_while(|(recording, _)| folder.join(recording).exists())
        .collect()
}
