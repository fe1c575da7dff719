//! Cases of a trial: drawn by the generator, or made before; and work on many of them at once.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use quadcal_blind::draw::{Family, Kind, again, plan};
use quadcal_blind::write;
use thiserror::Error;

use super::run::Quadcal;
use super::score::Score;
use super::truth::Truth;
use crate::parallel::in_parallel;

/// Why a trial came to nothing. What goes wrong in a single case counts against the command instead.
#[derive(Debug, Error)]
pub enum TrialError {
    /// A file or folder.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// It.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A truth that is none.
    #[error("{path}: not a truth of this version: {source}", path = path.display())]
    Truth {
        /// Its file.
        path: PathBuf,
        /// What is wrong in it.
        source: serde_json::Error,
    },
    /// The generator can't write a case.
    #[error("{0:#}")]
    Draw(anyhow::Error),
    /// A sealed folder without cases.
    #[error("{path}: no case-*/truth.json in it", path = path.display())]
    NoCases {
        /// It.
        path: PathBuf,
    },
}

impl TrialError {
    /// Of a file or folder.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}

/// What to draw. The same gives the same cases.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Cases.
    pub cases: usize,
    /// Seed of everything.
    pub seed: u64,
    /// Of this kind only.
    pub kind: Option<Kind>,
    /// Of this family, in place of the kinds.
    pub family: Option<Family>,
    /// The cases of these names only; all where there are none.
    pub only: Vec<String>,
    /// How often each is recorded again with other noise.
    pub again: u64,
}

impl Draw {
    /// How many recordings of a case it makes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.wanted().count() * (1 + self.again as usize)
    }

    /// Places of the cases in the plan.
    fn wanted(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cases).filter(|&place| self.only.is_empty() || self.only.contains(&name(place, 0)))
    }
}

/// What stands between a case's name and the number of its repetition.
const AGAIN: &str = "-again-";

/// A case's name without the number of its repetition.
#[must_use]
pub fn first_name(case: &str) -> &str {
    case.split_once(AGAIN).map_or(case, |(first, _)| first)
}

/// Where the cases of a trial lie; the truth apart from them.
#[derive(Clone, Debug)]
pub struct Folders {
    /// Recordings and twins, a folder for each case.
    pub open: PathBuf,
    /// The truths, a folder for each case.
    pub sealed: PathBuf,
    /// Where the JSON of the answers goes.
    pub answers: PathBuf,
}

impl Folders {
    /// All three within one folder.
    #[must_use]
    pub fn within(folder: &Path) -> Self {
        Self {
            open: folder.join("open"),
            sealed: folder.join("sealed"),
            answers: folder.join("answers"),
        }
    }

    /// Draws cases. `done` is told of each.
    ///
    /// # Errors
    /// [`TrialError::Draw`] where one can't be written.
    pub fn draw(&self, draw: &Draw, jobs: usize, done: impl Fn() + Sync) -> Result<(), TrialError> {
        let plan = match draw.family {
            Some(family) => family.plan(draw.cases, draw.seed),
            None => plan(draw.cases, draw.seed, draw.kind),
        };
        let repetitions = |place| (0..=draw.again).map(move |repetition| (place, repetition));
        let wanted: Vec<(usize, u64)> = draw.wanted().flat_map(repetitions).collect();
        let each = in_parallel(jobs, wanted.len(), |at| {
            let (place, repetition) = wanted[at];
            let case = again(draw.seed, place, draw.family, plan[place], repetition);
            let name = name(place, repetition);
            write::open_folder(&self.open.join(&name), &case.runs).map_err(TrialError::Draw)?;
            write::sealed(&self.sealed.join(&name), &case.truth).map_err(TrialError::Draw)?;
            done();
            Ok(())
        });
        each.into_iter().collect()
    }

    /// Names of the cases, in order.
    ///
    /// # Errors
    /// [`TrialError::NoCases`] where there are none.
    pub fn names(&self) -> Result<Vec<String>, TrialError> {
        let entries = fs::read_dir(&self.sealed).map_err(TrialError::io(&self.sealed))?;
        let mut names = Vec::new();
        for entry in entries {
            let entry = entry.map_err(TrialError::io(&self.sealed))?;
            if entry.path().join("truth.json").is_file() {
                names.push(entry.file_name().to_string_lossy().into_owned());
            }
        }
        names.sort();
        if names.is_empty() {
            return Err(TrialError::NoCases {
                path: self.sealed.clone(),
            });
        }
        Ok(names)
    }

    /// Lets the command diagnose cases, and scores them. The truth is read when the answers are in.
    ///
    /// # Errors
    /// [`TrialError`] where a folder can't be used or a truth can't be read.
    pub fn judge(
        &self,
        names: &[String],
        quadcal: &Quadcal,
        jobs: usize,
        done: impl Fn() + Sync,
    ) -> Result<Vec<Score>, TrialError> {
        fs::create_dir_all(&self.answers).map_err(TrialError::io(&self.answers))?;
        let answers = fs::canonicalize(&self.answers).map_err(TrialError::io(&self.answers))?;
        let said = in_parallel(jobs, names.len(), |at| {
            let json = answers.join(format!("{}.json", names[at]));
            let answer = quadcal.diagnose(&self.open.join(&names[at]), &json);
            done();
            answer
        });
        let pairs = names.iter().zip(&said);
        pairs
            .map(|(name, answer)| {
                let path = self.sealed.join(name).join("truth.json");
                let text = fs::read_to_string(&path).map_err(TrialError::io(&path))?;
                let truth: Truth = serde_json::from_str(&text)
                    .map_err(|source| TrialError::Truth { path, source })?;
                Ok(Score::of(name, &truth, answer))
            })
            .collect()
    }
}

/// Name of a case, and of its repetition where it is one.
fn name(place: usize, repetition: u64) -> String {
    match repetition {
        0 => format!("case-{place:04}"),
        _ => format!("case-{place:04}{AGAIN}{repetition:02}"),
    }
}
