//! One case scored against its truth.

use quadcal_host::diagnose::diagnosis::{Diagnosis, Finding, Verdict};
use quadcal_host::mechanism::Mechanism;
use serde::Serialize;

use super::cell::{Agreement, Cell};
use super::interval::off;
use super::truth::{Family, Kind, Missing, OF_THE_DISC, SizeClass, Truth};

/// What `quadcal diagnose` said of a case.
#[derive(Clone, Debug)]
pub struct Answer {
    /// How long it took, s.
    pub seconds: f64,
    /// The diagnosis, or why there is none.
    pub said: Result<Diagnosis, String>,
}

/// What was named first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Named {
    /// A mechanism, or `unknown`.
    Mechanism(Mechanism),
    /// Nothing.
    None,
    /// The command failed.
    Failed,
}

impl Named {
    /// Its id.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Mechanism(mechanism) => mechanism.id(),
            Self::None => "none",
            Self::Failed => "failed",
        }
    }
}

/// A parameter's interval against the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// The parameter's name in the finding.
    pub name: String,
    /// Whether the interval holds the true value; none where the truth has no such parameter.
    pub holds: Option<bool>,
    /// How far the true value is above the interval's middle, in halves of the interval.
    pub off: Option<f64>,
}

/// A finding, and whether it is of anything that is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Said {
    /// What was named.
    pub mechanism: Mechanism,
    /// How surely.
    pub confidence: f64,
    /// Whether nothing of the kind is there.
    pub is_false: bool,
}

impl Said {
    /// Whether it is a name of the catalogue.
    #[must_use]
    pub fn named(&self) -> bool {
        self.mechanism != Mechanism::Unknown
    }
}

/// A case scored.
#[derive(Clone, Debug, Serialize)]
pub struct Score {
    /// The case's folder.
    pub case: String,
    /// What it tries.
    pub kind: Kind,
    /// The family it is of, beside the kinds.
    pub family: Option<Family>,
    /// What is missing: ids, or words for physics in no catalogue.
    pub truth: Vec<String>,
    /// Sizes of it, in those that the ideal detector needs.
    pub times_ideal: Vec<f64>,
    /// Class of the first one's size.
    pub size: Option<SizeClass>,
    /// Whether the ideal detector tells all of it from its look-alikes.
    pub identifiable: bool,
    /// Whether the twin has the disc's errors.
    pub disc_known: bool,
    /// The verdict.
    pub verdict: Option<Verdict>,
    /// What was named first; where the twin lacks the disc's pattern too, first of what is no such pattern.
    pub first: Named,
    /// All that was named.
    pub named: Vec<Mechanism>,
    /// Look-alikes of what was named first.
    pub look_alikes: Vec<Mechanism>,
    /// How many of the missing mechanisms were named.
    pub found: usize,
    /// Named, but not missing.
    pub extras: Vec<Mechanism>,
    /// Findings on top of those of what is missing; where the twin lacks the disc's pattern too, of what is no such pattern.
    pub beside: usize,
    /// Every finding with its confidence.
    pub said: Vec<Said>,
    /// Sites and carriers named against those of what is missing.
    pub places: Agreement,
    /// RMS of the residual on held-out turns, before and after, rad.
    pub held_out_rad: Option<[f64; 2]>,
    /// Share of the reducible RMS that was removed on held-out turns, whatever was named.
    pub removed: Option<f64>,
    /// Whether the answer is right, as its kind has it.
    pub right: bool,
    /// Parameters of right findings.
    pub parameters: Vec<Compared>,
    /// Share of the reducible RMS that was removed on held-out turns; of right answers only.
    pub reducible_removed: Option<f64>,
    /// How long it took, s.
    pub seconds: f64,
    /// Why the command failed.
    pub failure: Option<String>,
}

impl Score {
    /// Scores an answer.
    #[must_use]
    pub fn of(case: &str, truth: &Truth, answer: &Answer) -> Self {
        let missing = &truth.mechanisms;
        let mut score = Self {
            case: case.to_owned(),
            kind: truth.kind,
            family: truth.family,
            truth: missing.iter().map(|one| one.physics.clone()).collect(),
            times_ideal: missing.iter().map(|one| one.times_ideal).collect(),
            size: missing.first().map(|one| SizeClass::of(one.times_ideal)),
            identifiable: missing.iter().all(Missing::identifiable),
            disc_known: truth.disc_known,
            verdict: None,
            first: Named::Failed,
            named: Vec::new(),
            look_alikes: Vec::new(),
            found: 0,
            extras: Vec::new(),
            beside: 0,
            said: Vec::new(),
            places: Agreement::default(),
            held_out_rad: None,
            removed: None,
            right: false,
            parameters: Vec::new(),
            reducible_removed: None,
            seconds: answer.seconds,
            failure: None,
        };
        match &answer.said {
            Ok(diagnosis) => score.judge(truth, diagnosis),
            Err(why) => score.failure = Some(why.clone()),
        }
        score
    }

    fn judge(&mut self, truth: &Truth, diagnosis: &Diagnosis) {
        let missing = &truth.mechanisms;
        let counts = |finding: &&Finding| {
            truth.disc_known
                || missing.iter().any(|one| one.is(finding.mechanism))
                || !OF_THE_DISC.contains(&finding.mechanism)
        };
        let findings: Vec<&Finding> = diagnosis.findings.iter().filter(counts).collect();
        let first = findings.first();
        self.said = (diagnosis.findings.iter())
            .map(|finding| Said {
                mechanism: finding.mechanism,
                confidence: finding.confidence,
                is_false: !truth.has(finding.mechanism),
            })
            .collect();
        let named: Vec<Cell> = findings
            .iter()
            .filter_map(|f| Cell::of_finding(f))
            .collect();
        let there: Vec<Cell> = missing.iter().filter_map(Missing::cell).collect();
        self.places = Agreement::of(&named, &there);
        let held_out = &diagnosis.fit.held_out;
        self.held_out_rad = (held_out.rms_before_rad.zip(held_out.rms_after_rad))
            .map(|(before, after)| [before, after]);
        self.removed = held_out.reducible_removed.or_else(|| {
            let [before, after] = self.held_out_rad?;
            // Without a floor all of it counts as reducible, which claims the least.
            let reducible = before - held_out.floor_rad.unwrap_or(0.0);
            (reducible > 0.0).then(|| (before - after) / reducible)
        });
        self.verdict = Some(diagnosis.verdict);
        self.first = first.map_or(Named::None, |first| Named::Mechanism(first.mechanism));
        self.look_alikes = first.map_or_else(Vec::new, |first| first.look_alikes.clone());
        self.named = diagnosis.findings.iter().map(|f| f.mechanism).collect();
        self.extras = (findings.iter().map(|finding| finding.mechanism))
            .filter(|&named| !missing.iter().any(|one| one.is(named)))
            .collect();
        let right: Vec<(&Missing, &Finding)> = missing
            .iter()
            .filter(|one| one.id != Mechanism::Unknown)
            .filter_map(|one| {
                let finding = findings.iter().find(|found| one.is(found.mechanism))?;
                Some((one, *finding))
            })
            .collect();
        self.found = right.len();
        self.beside = findings.len() - right.len().min(findings.len());
        self.right = match truth.kind {
            Kind::One | Kind::Masked | Kind::Loop => self.names_first(missing),
            Kind::Several => self.found == missing.len() && self.extras.is_empty(),
            Kind::LookAlike => self.leaves_open(truth, diagnosis),
            Kind::Nothing => {
                diagnosis.verdict == Verdict::Complete && diagnosis.findings.is_empty()
            }
            Kind::Outside => matches!(
                self.first,
                Named::None | Named::Mechanism(Mechanism::Unknown)
            ),
        };
        for (one, finding) in right {
            let intervals = finding.parameters.iter().filter(|(_, p)| p.ci95.is_some());
            self.parameters.extend(intervals.map(|(name, _)| {
                let off = off(truth, one, finding, name);
                Compared {
                    mechanism: finding.mechanism,
                    name: name.clone(),
                    holds: off.map(|off| off.abs() <= 1.0),
                    off,
                }
            }));
        }
        if self.right && (truth.kind.has_one_name() || truth.kind == Kind::Several) {
            self.reducible_removed = diagnosis.fit.held_out.reducible_removed;
        }
    }

    /// Whether the missing mechanism is the first; where no detector tells it from its look-alikes, among the first's is as good.
    fn names_first(&self, missing: &[Missing]) -> bool {
        let Some(one) = missing.first() else {
            return false;
        };
        let first = matches!(self.first, Named::Mechanism(named) if one.is(named));
        let among = self.look_alikes.iter().any(|&alike| one.is(alike));
        first || (!one.identifiable() && among)
    }

    /// Whether it is called ambiguous, with all that it may be.
    fn leaves_open(&self, truth: &Truth, diagnosis: &Diagnosis) -> bool {
        let said =
            |id: &Mechanism| self.first == Named::Mechanism(*id) || self.look_alikes.contains(id);
        diagnosis.verdict == Verdict::Ambiguous && truth.indistinguishable.iter().all(said)
    }

    /// Why a wrong answer is wrong; none where it is right.
    #[must_use]
    pub fn wrong(&self) -> Option<String> {
        if self.right {
            return None;
        }
        if let Some(why) = &self.failure {
            return Some(format!("failed: {why}"));
        }
        let verdict = self.verdict.map_or("none", verdict_name);
        let alike: Vec<&str> = self.look_alikes.iter().map(|alike| alike.id()).collect();
        let alike = if alike.is_empty() {
            String::new()
        } else {
            format!(" or {}", alike.join(", "))
        };
        Some(match self.kind {
            Kind::Several => {
                let named: Vec<&str> = self.named.iter().map(|named| named.id()).collect();
                format!(
                    "{verdict}: {} of {} found, {} too many; named {}",
                    self.found,
                    self.truth.len(),
                    self.extras.len(),
                    if named.is_empty() {
                        "none".to_owned()
                    } else {
                        named.join(", ")
                    }
                )
            }
            _ => format!("{verdict}: {}{alike}", self.first.id()),
        })
    }
}

/// A verdict as in the JSON.
#[must_use]
pub const fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Complete => "complete",
        Verdict::Explained => "explained",
        Verdict::Partly => "partly",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unknown => "unknown",
    }
}
