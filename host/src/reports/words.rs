//! Findings in plain words, the same in reports and on the terminal.

use std::f64::consts::TAU;

use quadcal::estimate::{Advice, Anchor, Goal, Rejection, Totals};
use quadcal::units::RAD_PER_TURN32;

use crate::calibrate::{Calibration, LinesFrom, RecordingUse};
use crate::report::{si, si_digits};
use crate::sensor::{SensorKind, SensorPlan};
use crate::showcase::Showcase;

/// What kind of sensor it is.
#[must_use]
pub const fn sensor(kind: SensorKind) -> &'static str {
    match kind {
        SensorKind::Quadrature {
            index_state: Some(_),
        } => "quadrature with index",
        SensorKind::Quadrature { index_state: None } => "quadrature without index",
        SensorKind::Hall => "three Hall sensors",
        SensorKind::Wheel { missing: 1.., .. } => "toothed wheel with a gap",
        SensorKind::Wheel { .. } => "one channel",
    }
}

/// Says so where the number of lines was guessed, after it.
#[must_use]
pub fn lines_guessed(calibration: &Calibration) -> &'static str {
    let guess = |used: &RecordingUse| used.lines_from == LinesFrom::Pattern;
    if calibration.recordings.iter().any(guess) {
        " (guessed from how the intervals repeat; --lines says it)"
    } else {
        ""
    }
}

/// Scatter of the speed, before and after.
#[must_use]
pub fn scatter(before: f64, after: f64) -> String {
    format!(
        "{:.3} % before, {:.3} % after",
        100.0 * before,
        100.0 * after
    )
}

/// The headline of a table that does harm on later turns.
#[must_use]
pub fn worse_later(shown: &Showcase) -> String {
    let scatter = &shown.check.scatter;
    format!(
        "The table fits the turns it was learned from, but on later turns it makes the speed scatter more ({}): it does not hold at \
         their speeds",
        self::scatter(scatter.before, scatter.after)
    )
}

/// What edge 0 is tied to.
#[must_use]
pub fn origin(plan: SensorPlan) -> &'static str {
    match (plan.anchor(), plan.kind) {
        (Anchor::Index, SensorKind::Wheel { .. }) => "the gap",
        (Anchor::Index, _) => "the index",
        (Anchor::FirstEdge, _) => "the first edge (holds for this recording only)",
    }
}

/// Speeds of the slowest and the fastest turn used, r/min; zero where there was none.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn speeds_r_min(totals: &Totals, clock_hz: u64) -> [f64; 2] {
    [totals.longest, totals.shortest].map(|ticks| match ticks {
        0 => 0.0,
        ticks => 60.0 * clock_hz as f64 / ticks as f64,
    })
}

/// A range of speeds; one number where both ends print alike.
#[must_use]
pub fn speed_range([slowest, fastest]: [f64; 2]) -> String {
    let digits = |speed: f64| si_digits(speed, "r/min", 4).0;
    let (slowest, fastest) = (digits(slowest), digits(fastest));
    if slowest == fastest {
        format!("{slowest} r/min")
    } else {
        format!("{slowest} to {fastest} r/min")
    }
}

/// Turns that were not used, by name and reason.
#[must_use]
pub fn rejections(totals: &Totals) -> [(&'static str, u32, &'static str); 4] {
    [
        (
            "broken",
            totals.broken,
            "with lost or extra edges, a glitch or a reversal",
        ),
        (
            "irregular",
            totals.irregular,
            "with a stop or an edge more than a step out of place",
        ),
        (
            "change of speed",
            totals.speed_change,
            "whose speed changed too much: a third or more off that of the turn before",
        ),
        (
            "disagreeing",
            totals.disagrees,
            "that disagree with their neighbours (load step or shock)",
        ),
    ]
}

/// How long a turn took, four digits, as turns differ by little.
#[must_use]
pub fn took(seconds: f64) -> String {
    let (number, unit) = si_digits(seconds, "s", 4);
    format!("{number} {unit}")
}

/// Why a turn was not used, in few words.
#[must_use]
pub const fn reason(reason: Rejection) -> &'static str {
    match reason {
        Rejection::Broken => "broken edges",
        Rejection::Irregular => "irregular edges",
        Rejection::SpeedChange => "change of speed",
        Rejection::Disagrees => "disagrees with its neighbours",
    }
}

/// The same as a name in files, that of its count in a calibration's JSON.
#[must_use]
pub const fn reason_id(reason: Rejection) -> &'static str {
    match reason {
        Rejection::Broken => "broken",
        Rejection::Irregular => "irregular",
        Rejection::SpeedChange => "speed_change",
        Rejection::Disagrees => "disagrees",
    }
}

/// Turns that were not used, and why.
#[must_use]
pub fn rejected(totals: &Totals) -> String {
    let reasons = rejections(totals);
    let all = reasons.iter().map(|(_, count, _)| count).sum::<u32>();
    let text: Vec<String> = reasons
        .into_iter()
        .filter(|(_, count, _)| *count > 0)
        .map(|(_, count, why)| format!("{count} {why}"))
        .collect();
    if all == 0 {
        "none".to_owned()
    } else {
        format!("{all}: {}", text.join("; "))
    }
}

/// Five digits with a prefix.
#[must_use]
pub fn precise(rad: f64) -> String {
    let (number, unit) = si_digits(rad, "rad", 5);
    format!("{number} {unit}")
}

/// Five digits with a prefix, and the standard error if it is known.
#[must_use]
pub fn with_error(rad: f64, standard_error_rad: f64) -> String {
    if standard_error_rad.is_nan() {
        precise(rad)
    } else {
        format!("{} ± {}", precise(rad), si(standard_error_rad, "rad"))
    }
}

/// How much smaller the error gets, in percent.
#[must_use]
pub fn reduction_percent(before: f64, after: f64) -> f64 {
    if before > 0.0 {
        100.0 * (1.0 - after / before)
    } else {
        0.0
    }
}

/// What more turns would do to an expected error, and what came of the goal; nothing where no turns were compared.
#[must_use]
pub fn progress(calibration: &Calibration, after_rad: f64) -> Option<String> {
    let last = calibration.progress.last()?;
    // The solved table knows more than its outlook: of that only the ratio counts.
    let share = last.after_twice_rad() / last.error_rad();
    let twice = si_digits(after_rad * share.min(1.0), "rad", 2);
    let twice = format!("{} {}", twice.0, twice.1);
    Some(match calibration.goal {
        None => format!("as many turns again would leave about {twice}"),
        Some(goal) => {
            let met = goal_met(goal, after_rad);
            let aim = si_digits(f64::from(goal.error) * RAD_PER_TURN32, "rad", 2);
            let aim = format!("{} {}", aim.0, aim.1);
            match last.outlook.advice(goal) {
                _ if met => format!("the goal of {aim} is met after {} turns", last.turns),
                Advice::GoalMet => format!(
                    "learning ended after {} turns, as the goal of {aim} was to be expected; solved, the table falls a little short of it",
                    last.turns
                ),
                Advice::NoFurtherGain => format!(
                    "more turns hardly help: as many again would leave about {twice}, and the clock or a drift limits the rest"
                ),
                Advice::GoOn => format!(
                    "the goal of {aim} is not met; as many turns again would leave about {twice}: record longer"
                ),
            }
        }
    })
}

fn goal_met(goal: Goal, after_rad: f64) -> bool {
    after_rad <= f64::from(goal.error) * RAD_PER_TURN32
}

/// What came of the goal, as in the JSON; nothing without a goal, or where no turns were compared.
#[must_use]
pub fn goal_id(calibration: &Calibration, after_rad: f64) -> Option<&'static str> {
    let goal = calibration.goal?;
    let advice = calibration.progress.advice(goal)?;
    Some(match advice {
        _ if goal_met(goal, after_rad) => "goal_met",
        Advice::GoOn | Advice::GoalMet => "go_on",
        Advice::NoFurtherGain => "no_further_gain",
    })
}

/// An angle as data sheets give it: arc seconds, or degrees where it is large.
#[must_use]
pub fn arc_seconds(rad: f64) -> String {
    let degrees = rad / TAU * 360.0;
    if degrees.abs() >= 0.1 {
        format!("{} degrees", si_digits(degrees, "", 3).0)
    } else {
        format!("{} arc seconds", si_digits(3600.0 * degrees, "", 3).0)
    }
}
