//! Looks for patterns one after another until what is left is noise.

use std::f64::consts::TAU;

use super::model::{Fit, Noisy, explained, fit_terms};
use super::residual::Residual;
use super::scan::Spectrum;
use super::term::{Pattern, Rhythm, Term};

/// Probability that noise alone gives a finding anywhere in a recording.
const FALSE_ALARM: f64 = 1e-3;

/// Patterns at the most.
const TERMS_MOST: usize = 24;

/// A pattern that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The pattern.
    pub term: Term,
    /// Fall of the sum of white squares when it was added, less what its unknowns cost (Schwarz).
    pub gain: f64,
    /// Other patterns that explain it nearly as well, best first, with theirs.
    pub rivals: Vec<(Term, f64)>,
}

/// What was found, and the noise that is left.
pub struct Outcome<'a> {
    /// The patterns, in the order in which they were found.
    pub found: Vec<Found>,
    /// All of them fitted together.
    pub fit: Option<Fit>,
    /// The stretches with their noise.
    pub stretches: Vec<Noisy<'a>>,
    /// Speed that sizes hold for, rad/s.
    pub reference: f64,
    /// Largest power of a rhythm that is left, over what noise alone reaches.
    pub left: f64,
}

/// Searches all stretches of a rig's recordings.
#[must_use]
pub fn search<'a>(residuals: &'a [Residual], tick_s: f64) -> Outcome<'a> {
    let reference = residuals
        .iter()
        .map(Residual::mean_speed)
        .fold(0.0, f64::max);
    let zero: Vec<Vec<f64>> = residuals
        .iter()
        .map(|r| vec![0.0; r.angles.len()])
        .collect();
    let noisy = |made: &[Vec<f64>], before: Option<&[Noisy<'_>]>| -> Vec<Noisy<'a>> {
        let each = residuals.iter().zip(made).enumerate();
        each.map(|(i, (r, made))| Noisy::of(r, made, tick_s, before.map(|b| b[i].noise)))
            .collect()
    };
    let mut outcome = Outcome {
        found: Vec::new(),
        fit: None,
        stretches: noisy(&zero, None),
        reference,
        left: 0.0,
    };
    let mut made = zero;
    while outcome.found.len() < TERMS_MOST {
        let terms: Vec<Term> = outcome.found.iter().map(|found| found.term).collect();
        let Some(best) = outcome.strongest(&terms, &made) else {
            break;
        };
        outcome.found.push(best);
        let terms: Vec<Term> = outcome.found.iter().map(|found| found.term).collect();
        for _ in 0..2 {
            outcome.fit = fit_terms(&terms, &outcome.stretches, reference);
            let Some(fit) = &outcome.fit else {
                break;
            };
            made = residuals
                .iter()
                .map(|residual| explained(&terms, &fit.sizes, residual, reference))
                .collect();
            outcome.stretches = noisy(&made, Some(&outcome.stretches));
        }
    }
    outcome
}

impl Outcome<'_> {
    /// The pattern that explains most of what is left, if it is no accident.
    fn strongest(&mut self, terms: &[Term], made: &[Vec<f64>]) -> Option<Found> {
        let mut candidates = Vec::new();
        self.left = 0.0;
        for (stretch, made) in self.stretches.iter().zip(made) {
            let white = stretch.white(made);
            let spectrum = Spectrum::of(&white);
            let threshold = spectrum.threshold(FALSE_ALARM);
            let mut peaks = spectrum.peaks(threshold);
            peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
            let strongest = peaks.first().map_or(0.0, |peak| peak.1);
            self.left = self.left.max(strongest / threshold);
            for &(at, _) in peaks.iter().take(2) {
                let place = spectrum.frequency(at) * stretch.residual.edges as f64;
                candidates.extend(hypotheses(
                    stretch.residual,
                    place,
                    1.0 / (2.0 * turns(stretch.residual)),
                ));
            }
        }
        let mut once: Vec<Term> = Vec::new();
        for candidate in candidates {
            if !once.contains(&candidate) {
                once.push(candidate);
            }
        }
        let candidates = once;
        let edges: f64 = self
            .stretches
            .iter()
            .map(|s| s.residual.places.len() as f64)
            .sum();
        let base = fit_terms(terms, &self.stretches, self.reference).map_or(0.0, |fit| fit.gain);
        let mut tried: Vec<(Term, f64)> = candidates
            .into_iter()
            .filter(|candidate| !terms.contains(candidate))
            .filter_map(|candidate| {
                let candidate = self.refined(candidate, made);
                let all: Vec<Term> = terms.iter().copied().chain([candidate]).collect();
                let gain = fit_terms(&all, &self.stretches, self.reference)?.gain - base;
                // Schwarz: what a number more must explain.
                Some((candidate, gain - candidate.unknowns() as f64 * edges.ln()))
            })
            .collect();
        tried.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (term, gain) = *tried.first().filter(|best| best.1 > 0.0)?;
        const RIVAL: f64 = 10.0;
        Some(Found {
            term,
            gain,
            rivals: tried[1..]
                .iter()
                .filter(|rival| gain - rival.1 < RIVAL)
                .copied()
                .collect(),
        })
    }

    /// The same with its frequency where it explains most.
    fn refined(&self, term: Term, made: &[Vec<f64>]) -> Term {
        let with = |frequency: f64| Term {
            rhythm: match term.rhythm {
                Rhythm::Order(_) => Rhythm::Order(frequency),
                Rhythm::Hertz(_) => Rhythm::Hertz(frequency),
                Rhythm::Constant => Rhythm::Constant,
            },
            ..term
        };
        let (frequency, mut step) = match term.rhythm {
            Rhythm::Constant => return term,
            // A whole number of cycles a turn is what it is.
            Rhythm::Order(order) if order.fract() == 0.0 => return term,
            Rhythm::Order(order) => (order, 0.25 / self.turns_most()),
            Rhythm::Hertz(hertz) => (hertz, 0.25 * self.reference / (TAU * self.turns_most())),
        };
        let gain = |frequency: f64| self.gain_alone(with(frequency), made);
        let (mut best, mut most) = (frequency, gain(frequency));
        for _ in 0..6 {
            for side in [-step, step] {
                let there = gain(best + side);
                if there > most {
                    (best, most) = (best + side, there);
                }
            }
            step *= 0.5;
        }
        with(best)
    }

    /// What a pattern explains of what is left.
    fn gain_alone(&self, term: Term, made: &[Vec<f64>]) -> f64 {
        let (mut right, mut gram) = ([0.0; 2], [[0.0; 2]; 2]);
        for (stretch, made) in self.stretches.iter().zip(made) {
            let white = stretch.white(made);
            let columns: Vec<Vec<f64>> = term
                .columns(stretch.residual, self.reference)
                .into_iter()
                .map(|column| stretch.whitened(column))
                .collect();
            for (i, a) in columns.iter().enumerate() {
                right[i] += a.iter().zip(&white).map(|(a, b)| a * b).sum::<f64>();
                for (j, b) in columns.iter().enumerate() {
                    gram[i][j] += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                }
            }
        }
        let determinant = gram[0][0] * gram[1][1] - gram[0][1] * gram[1][0];
        (right[0] * right[0] * gram[1][1] - 2.0 * right[0] * right[1] * gram[0][1]
            + right[1] * right[1] * gram[0][0])
            / determinant
    }

    fn turns_most(&self) -> f64 {
        let each = self.stretches.iter().map(|stretch| turns(stretch.residual));
        each.fold(1.0, f64::max)
    }
}

#[allow(clippy::cast_precision_loss)]
fn turns(residual: &Residual) -> f64 {
    residual.places.len() as f64 / residual.edges as f64
}

/// What may make a rhythm at so many cycles a turn, known to within `within`.
#[allow(clippy::cast_precision_loss)]
fn hypotheses(residual: &Residual, place: f64, within: f64) -> Vec<Term> {
    let lines = (residual.edges / residual.classes) as f64;
    let turns_per_s = residual.mean_speed() / TAU;
    let mut terms = Vec::new();
    let mut add = |order: f64, pattern: Pattern, alike: bool| {
        if order < within {
            if !alike {
                for exponent in [0, 1] {
                    terms.push(Term {
                        rhythm: Rhythm::Constant,
                        pattern,
                        exponent,
                    });
                }
            }
            return;
        }
        let whole = order.round();
        if (order - whole).abs() < within && whole > 0.0 {
            for exponent in if alike { &[0, -2][..] } else { &[0] } {
                terms.push(Term {
                    rhythm: Rhythm::Order(whole),
                    pattern,
                    exponent: *exponent,
                });
            }
        } else {
            terms.push(Term {
                rhythm: Rhythm::Order(order),
                pattern,
                exponent: if alike { -2 } else { 0 },
            });
        }
        terms.push(Term {
            rhythm: Rhythm::Hertz(order * turns_per_s),
            pattern,
            exponent: 0,
        });
    };
    // Above, a rhythm of all edges can't be told from one of unlike classes.
    if residual.classes == 1 || place < lines / 2.0 {
        add(place, Pattern::ALL, true);
    }
    // Edges of unlike classes show a rhythm beside the multiples of the lines.
    for carrier in 1..=(residual.classes / 2) {
        let order = (carrier as f64 * lines - place).abs();
        if order < lines / 2.0 {
            for pattern in Pattern::of_classes(residual.classes) {
                add(order, *pattern, false);
            }
        }
    }
    terms
}
