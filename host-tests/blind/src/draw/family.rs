//! Families of cases beside the kinds: what a trial of the kinds leaves out.

use super::case::{Drawn, add, sized};
use super::cells;
use super::effects;
use super::kind::Kind;
use super::rigs::{Shape, rigs};
use crate::encoder::Encoder;
use crate::pieces::{KNOTS, Pieces};
use crate::random::Dice;
use crate::rig::{NoiseShape, Profile, Rig, Told};

/// What is unlike the cases of the kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum Family {
    /// A twin that knows sensor, timer and inertia alone
    Thin,
    /// A drive that the twin does not know: ramps, holds, dwells, reversals
    FreeDrive,
    /// Noise that is not white and normal
    Heavy,
    /// Sixty effects in no catalogue
    CatalogueFree,
}

/// Effects that show whatever the drive does.
const ANY_DRIVE: [&str; 14] = [
    "eccentricity",
    "disc_tilt",
    "local_defect",
    "edge_delay",
    "channel_skew",
    "width_error",
    "quadrature_error",
    "threshold_ripple",
    "torque_ripple",
    "gear_mesh",
    "torque_tone",
    "lost_edges",
    "extra_edges",
    "hysteresis",
];

/// Draws of a rig before the effect is made smaller.
const DRAWS: usize = 25;

impl Family {
    /// Its name in the truth.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Thin => "thin",
            Self::FreeDrive => "free_drive",
            Self::Heavy => "heavy",
            Self::CatalogueFree => "catalogue_free",
        }
    }

    /// Kind of every case and its number, in random order.
    #[must_use]
    pub fn plan(self, cases: usize, seed: u64) -> Vec<(Kind, usize)> {
        let kind = |number: usize| match self {
            Self::Thin => Kind::Nothing,
            Self::FreeDrive if number.is_multiple_of(3) => Kind::Nothing,
            Self::Heavy if number.is_multiple_of(2) => Kind::Nothing,
            Self::FreeDrive | Self::Heavy => Kind::One,
            Self::CatalogueFree => Kind::Outside,
        };
        let mut plan: Vec<_> = (0..cases).map(|number| (kind(number), number)).collect();
        Dice::new(seed, 0).shuffle(&mut plan);
        plan
    }

    /// Draws a case of a kind; none where the effect does not fit the rig.
    pub(super) fn draw(
        self,
        dice: &mut Dice,
        drawn: &mut Drawn,
        (kind, number): (Kind, usize),
        attempt: usize,
    ) -> Option<()> {
        match self {
            Self::Thin => {
                let shape = dice.pick(&[
                    Shape::Constant,
                    Shape::TwoSpeeds,
                    Shape::Ramp,
                    Shape::Reversal,
                    Shape::RunDown,
                    Shape::Loops,
                ]);
                drawn.rigs = rigs(dice, shape, |e| shape != Shape::Loops || e.edges() >= 400);
                for rig in &mut drawn.rigs {
                    rig.told = Told::InertiaOnly;
                    rig.disc_known = false;
                    rig.noise_known = false;
                }
                Some(())
            }
            Self::FreeDrive => {
                // A third has nothing missing: the others go through the effects.
                let id = ANY_DRIVE[(number - number / 3).saturating_sub(1) % ANY_DRIVE.len()];
                let fits = |encoder: Encoder| kind == Kind::Nothing || effects::fits(id, encoder);
                drawn.rigs = rigs(dice, Shape::Constant, fits);
                let rig = &mut drawn.rigs[0];
                rig.told = Told::NoDrive;
                free(dice, rig);
                one(dice, drawn, kind, id, attempt)
            }
            Self::Heavy => {
                let id = ANY_DRIVE[number / 2 % ANY_DRIVE.len()];
                let by_speed = number / 2 % 3 == 2;
                let shape = match kind {
                    _ if by_speed && id != "hysteresis" => Shape::Ramp,
                    Kind::One => effects::shape(dice, id),
                    _ => dice.pick(&[
                        Shape::Constant,
                        Shape::TwoSpeeds,
                        Shape::Ramp,
                        Shape::Reversal,
                        Shape::RunDown,
                    ]),
                };
                let fits = |encoder: Encoder| kind == Kind::Nothing || effects::fits(id, encoder);
                drawn.rigs = rigs(dice, shape, fits);
                heavy(dice, &mut drawn.rigs, number / 2 % 3);
                one(dice, drawn, kind, id, attempt)
            }
            Self::CatalogueFree => {
                let which = number % cells::COUNT;
                drawn.rigs = rigs(dice, cells::shape(which), |e| cells::fits(which, e));
                let effect = cells::effect(dice, which, &drawn.rigs);
                let times = if attempt < DRAWS { 30.0 } else { 10.0 };
                drawn.effects.push(sized(&drawn.rigs, &effect, times)?);
                Some(())
            }
        }
    }
}

/// Adds one effect at 10 times the detectable size, where the kind has one; smaller where that never fits.
fn one(dice: &mut Dice, drawn: &mut Drawn, kind: Kind, id: &str, attempt: usize) -> Option<()> {
    if kind == Kind::Nothing {
        return Some(());
    }
    let times = [10.0, 5.0, 3.0][(attempt / DRAWS).min(2)];
    add(dice, drawn, id, times)
}

/// Lets a drive follow six speeds, each held, with ramps between: one of them standstill, at least one in reverse.
fn free(dice: &mut Dice, rig: &mut Rig) {
    let top = rig.profile.top();
    let dwell = dice.whole(1, 4) as usize;
    let turn = dice.whole(1, 4) as usize;
    let mut knots = [(0.0, top); KNOTS];
    let (mut time, mut forward) = (0.0, true);
    for level in 0..KNOTS / 2 {
        // Once it goes back it stays so for a level that is no dwell.
        if level == turn || (level > turn + 1 && dice.chance(0.3)) {
            forward = !forward;
        }
        let size = if level == 0 {
            top
        } else {
            top * dice.between(0.3, 1.0)
        };
        let speed = match (level == dwell, forward) {
            (true, _) => 0.0,
            (_, true) => size,
            (_, false) => -size,
        };
        if level > 0 {
            time += dice.between(0.2, 1.5);
        }
        knots[2 * level] = (time, speed);
        time += dice.between(0.5, 1.5);
        knots[2 * level + 1] = (time, speed);
    }
    let pieces = Pieces::new(knots);
    let pieces = pieces.stretched(0.95 * rig.turns * std::f64::consts::TAU / pieces.way_rad());
    rig.profile = Profile::Free(pieces);
    rig.longest_s = 1.2 * pieces.end_s();
}

/// Gives rigs a noise that is not white and normal, which their twins do not declare.
fn heavy(dice: &mut Dice, rigs: &mut [Rig], which: usize) {
    let top = rigs
        .iter()
        .fold(0.0, |most: f64, rig| most.max(rig.profile.top()));
    let corner = dice.log_between(1.0, 10.0);
    for rig in rigs {
        rig.noise_known = false;
        match which {
            0 => {
                rig.noise_shape = NoiseShape::StudentStamps;
                rig.jitter_s = 0.01 * rig.encoder.step_rad() / top;
            }
            1 => {
                // As much in all at its slow end as the rig has, and more there than elsewhere.
                let excess = 30.0;
                rig.noise_psd *= 3.0 / excess;
                rig.noise_shape = NoiseShape::TwoSlopes {
                    corner_hz: corner * rig.profile.top() / std::f64::consts::TAU,
                    excess,
                };
            }
            _ => rig.noise_shape = NoiseShape::BySpeed { at_rad_s: top },
        }
    }
}
