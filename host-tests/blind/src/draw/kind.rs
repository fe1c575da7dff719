//! Kinds of case and how many of each a trial has.

use crate::random::Dice;

/// What a case tries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum Kind {
    /// One effect, 3, 5, 10 or 30 times the detectable size
    One,
    /// Two or three effects
    Several,
    /// An effect under a pattern of the disc 10 to 100 times larger, in the twin or not
    Masked,
    /// An effect under a speed loop that the twin knows
    Loop,
    /// Two mechanisms that this recording can't tell apart
    LookAlike,
    /// Nothing is missing
    Nothing,
    /// Physics in no catalogue
    Outside,
}

impl Kind {
    /// Every kind with its share in a trial, percent.
    pub const SHARES: [(Self, u32); 7] = [
        (Self::One, 40),
        (Self::Several, 10),
        (Self::Masked, 10),
        (Self::Loop, 6),
        (Self::LookAlike, 10),
        (Self::Nothing, 12),
        (Self::Outside, 12),
    ];

    /// Its name in the truth.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::Several => "several",
            Self::Masked => "masked",
            Self::Loop => "loop",
            Self::LookAlike => "look_alike",
            Self::Nothing => "nothing",
            Self::Outside => "outside",
        }
    }
}

/// Kind of every case of a trial and its number within the kind: in random order, so that a case's number says nothing.
#[must_use]
pub fn plan(cases: usize, seed: u64, only: Option<Kind>) -> Vec<(Kind, usize)> {
    let mut plan = Vec::with_capacity(cases);
    if let Some(kind) = only {
        plan.extend((0..cases).map(|number| (kind, number)));
    } else {
        let mut counts = [0; Kind::SHARES.len()];
        for number in 0..cases {
            // The kind that lags furthest behind its share is next.
            let lag = |at: &usize| {
                f64::from(Kind::SHARES[*at].1) * (number + 1) as f64 / 100.0
                    - f64::from(counts[*at])
            };
            let next = (0..counts.len()).max_by(|a, b| lag(a).total_cmp(&lag(b)));
            let next = next.unwrap_or(0);
            plan.push((Kind::SHARES[next].0, counts[next] as usize));
            counts[next] += 1;
        }
    }
    Dice::new(seed, 0).shuffle(&mut plan);
    plan
}
