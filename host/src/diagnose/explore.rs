//! What is missing, by the search, by what it comes to, and by the noise.

use super::bent;
use super::board::{Board, Model};
use super::conclude::{Conclusion, conclude};
use super::ends::Ends;
use super::noise::{
    LOAD, NoiseFinding, find_task, is_own, noise_findings, own_columns, rhythmic_findings,
};
use super::rounding;
use super::run::{DiagnoseError, Recorded, nothing};
use super::search::{Found, Searched, nothing_of, search};
use crate::mechanism::Mechanism;

/// Part of the rhythms' score that a mode needs in their place, and a task.
const MODE: f64 = 0.3;
const TASK: f64 = 0.8;
/// Times that what is too large to be linear is put into the twins, and part of what has no name that may be left then.
const BENT: usize = 2;
const LESS: f64 = 0.3;

/// What recordings come to.
#[derive(Clone, Debug)]
pub struct Explored {
    /// The recordings against their twins.
    pub given: Board,
    /// The same in the noise that was found, less the disc's pattern.
    pub board: Board,
    /// The search.
    pub searched: Searched,
    /// What was concluded of it.
    pub concluded: Conclusion,
    /// What the noise lacks.
    pub noise: Vec<NoiseFinding>,
}

impl Explored {
    /// Explores recordings against their twins.
    ///
    /// # Errors
    /// [`DiagnoseError`] where there is nothing to say.
    pub fn of(
        rig: &[Recorded],
        board: Board,
        progress: &mut dyn FnMut(f64, &'static str),
    ) -> Result<Self, DiagnoseError> {
        let mut explored = Self::once(rig, board, progress)?;
        for _ in 0..BENT {
            let Some(about) = explored.about(rig) else {
                break;
            };
            let again = Self::once(rig, about, progress)?;
            if again.nameless() > LESS * explored.nameless() {
                break;
            }
            explored = again;
        }
        Ok(explored)
    }

    /// Squares of what has no name.
    fn nameless(&self) -> f64 {
        let nameless = self.concluded.nameless.as_ref();
        nameless.map_or(0.0, |nameless| nameless.squares)
    }

    /// The recordings linear about the strongest finding, where something without a name is left as it is too large.
    fn about(&self, rig: &[Recorded]) -> Option<Board> {
        self.concluded.nameless.as_ref()?;
        bent::about(rig, &self.given, &self.searched)
    }

    fn once(
        rig: &[Recorded],
        mut board: Board,
        progress: &mut dyn FnMut(f64, &'static str),
    ) -> Result<Self, DiagnoseError> {
        let given = board.clone();
        progress(0.2, "Searching");
        let rounding = rounding::is_all(&board);
        let looked = if rounding {
            nothing_of(&board)
        } else {
            search(&mut board)
        };
        let searched = looked.ok_or_else(|| nothing(rig))?;
        if rounding {
            return Ok(Self {
                given,
                board,
                searched,
                concluded: Conclusion {
                    whiteness_p: 1.0,
                    ..Conclusion::default()
                },
                noise: Vec::new(),
            });
        }
        progress(0.6, "Weighing");
        let (mut concluded, heard) = rayon::join(
            || conclude(&board, &searched),
            || Heard::of(rig, &given, &board, &searched),
        );
        let noise = noise(rig, &given, &board, &searched, heard, &mut concluded);
        Ok(Self {
            given,
            board,
            searched,
            concluded,
            noise,
        })
    }

    /// Other recordings of the same edges and more in the noise that was found, less the disc's pattern, and what everything with a name
    /// leaves of them, white. What a task may have held up is in doubt by so much, s.
    #[must_use]
    pub fn rest(
        &self,
        other: &Board,
        held: &[Option<Ends>],
        doubt_s: f64,
    ) -> Option<(Board, Vec<Vec<f64>>)> {
        let mut other = other.in_doubt(held, doubt_s, &self.board);
        if let Some(pattern) = self.searched.pattern.as_ref() {
            other.take_off(&pattern.errors_rad);
        }
        let named = self.concluded.named.iter();
        let own = named.flat_map(|name| name.hypothesis.columns(&other));
        let columns = other.nuisances().into_iter().chain(own).collect();
        let left = other.fit(columns)?.left;
        Some((other, left))
    }
}

/// What the noise lacks, as far as it does not hang on the conclusion.
struct Heard {
    /// Noise in the place of rhythms, where rhythms were found.
    instead: Option<Vec<NoiseFinding>>,
    /// What else there is, where it is not that.
    beside: Vec<NoiseFinding>,
}

impl Heard {
    fn of(rig: &[Recorded], given: &Board, board: &Board, searched: &Searched) -> Self {
        let mut found = searched.found.iter();
        let rhythms = found.any(|f| f.hypothesis.rhythm().is_some());
        let instead = rhythms.then(|| in_place(rig, given, board, searched));
        let beside = if instead.as_ref().is_none_or(Vec::is_empty) {
            noise_findings(board, &searched.model)
        } else {
            Vec::new()
        };
        Self { instead, beside }
    }
}

/// What the noise lacks; where that explains what the search only resembled, it takes its place.
fn noise(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    searched: &Searched,
    heard: Heard,
    concluded: &mut Conclusion,
) -> Vec<NoiseFinding> {
    let mut noise: Vec<NoiseFinding> = Vec::new();
    if heard.instead.is_some() || concluded.nameless.is_some() {
        let known = heard.instead;
        noise = known.unwrap_or_else(|| in_place(rig, given, board, searched));
        if !noise.is_empty() {
            concluded
                .named
                .retain(|name| name.hypothesis.rhythm().is_none());
            concluded.nameless = None;
        }
    }
    if noise.is_empty() && concluded.nameless.is_none() {
        noise = heard.beside;
    }
    noise.retain(|one| !is_known(one, rig));
    noise
}

/// Whether a mode that was found is the one that all twins have.
fn is_known(found: &NoiseFinding, rig: &[Recorded]) -> bool {
    /// Standard errors by which it may be another, and part of its frequency.
    const DEVIATIONS: f64 = 4.0;
    const PART: f64 = 0.01;
    found.mechanism == Mechanism::TorsionalResonance
        && rig.iter().all(|one| {
            one.twin.torsional_resonance.is_some_and(|mode| {
                let load = mode.load_psd_n2_m2_s.unwrap_or(0.0);
                let shaken = found.parameters.iter().any(|own| own.name == LOAD);
                let own = found.parameters.iter().all(|own| {
                    let (known, part) = match own.name {
                        "f_hz" => (mode.f_hz, PART),
                        "damping_ratio" => (mode.damping_ratio, 0.0),
                        LOAD => (load, 0.0),
                        _ => (mode.inertia_share, 0.0),
                    };
                    (own.value - known).abs() < (DEVIATIONS * own.standard_error).max(part * known)
                });
                own && (shaken || load == 0.0)
            })
        })
}

/// Noise that is one thing where the rhythms that were found are many, or a task beside what else was found.
fn in_place(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    searched: &Searched,
) -> Vec<NoiseFinding> {
    let mut noise = instead(rig, given, searched);
    if noise.is_empty() {
        noise.extend(task_beside(board, searched));
    }
    noise
}

/// A task that explains the rhythms that were found, beside whatever else was.
fn task_beside(board: &Board, searched: &Searched) -> Option<NoiseFinding> {
    let rhythm = |found: &&Found| found.hypothesis.rhythm().is_some();
    let score: f64 = searched.found.iter().filter(rhythm).map(|f| f.score).sum();
    let others = searched.found.iter().filter(|found| !rhythm(found));
    let columns = board
        .nuisances()
        .into_iter()
        .chain(others.flat_map(|found| found.columns.clone()));
    let model = board.fit(columns.collect())?;
    let task = find_task(board, &model.left)?.finding;
    (task.plausible() && task.delta_bic > TASK * score).then_some(task)
}

/// Noise that is one thing where the rhythms that were found are many: a mode or a task.
fn instead(rig: &[Recorded], given: &Board, searched: &Searched) -> Vec<NoiseFinding> {
    let rhythms = || {
        let all = searched.found.iter();
        all.filter(|found| found.hypothesis.rhythm().is_some())
    };
    let score: f64 = rhythms().map(|found| found.score).sum();
    let before = given
        .fit(given.nuisances())
        .unwrap_or_else(|| Model::none(given));
    let mut noise = rhythmic_findings(given, &before);
    noise.retain(|one| match one.mechanism {
        Mechanism::TorsionalResonance => one.delta_bic > MODE * score,
        Mechanism::CaptureLatency => one.delta_bic > TASK * score && !one.frequencies_hz.is_empty(),
        _ => false,
    });
    let own = own_columns(given, rig);
    let task = noise
        .iter()
        .any(|one| one.mechanism == Mechanism::CaptureLatency);
    if task || own.is_empty() {
        return noise;
    }
    // A mode answers the twin's own ripples otherwise than a stiff shaft does: what is left of them speaks neither for nor against it,
    // and a ripple near the mode would be taken for noise that it answers.
    let others = rhythms().filter(|found| !is_own(given, rig, &found.hypothesis));
    let score: f64 = others.map(|found| found.score).sum();
    let columns = given.nuisances().into_iter().chain(own).collect();
    let Some(before) = given.fit(columns) else {
        return noise;
    };
    let mut apart = rhythmic_findings(given, &before);
    apart.retain(|one| {
        one.mechanism == Mechanism::TorsionalResonance && one.delta_bic > MODE * score
    });
    if apart.is_empty() { noise } else { apart }
}
