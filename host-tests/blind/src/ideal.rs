//! The ideal detector: what size of an effect could be told from noise at all.
//!
//! It knows everything but whether the effect is there: its shape, the spectrum of the torque noise, the size of the stamps'
//! error. Then the best that can be done is a matched filter. Its signal is the difference, edge by edge, of the noiseless times
//! with and without the effect, in rad; divided by the true noise (see [`crate::whiten`]) its length is d', the distance of the
//! two hypotheses in standard deviations. What no one knows beforehand is taken out of the signal first, by least squares in the
//! whitened signal: an offset of the angle, the mean speed, and the disc's whole pattern where the twin does not give it. The size
//! that the ideal detector needs is the one with d' = 5.
//!
//! Where an effect has look-alikes, their signals of any size are taken out as well: the d' that is left says how surely the
//! recordings tell it from them.
//!
//! Effects that add no signal but variance have d' from the Fisher information of the innovations' variances; what comes in whole
//! counts (lost edges, glitches, an index that slips) needs one.
//!
//! What a play shows after a reversal hangs on how near to the turn the last edges lie, and noise moves the turn by many edges: its
//! d' is that of the run which was recorded (see [`play`]).

mod alike;
mod passed;
mod play;
mod project;
mod sight;
#[cfg(test)]
mod tests;
mod variance;

use std::borrow::Cow;

use crate::effect::Effect;
use crate::rig::{Profile, Rig};

use passed::Passed;
pub use play::{play, shows_play};
use sight::Sight;

/// d' at which an effect counts as detectable.
pub const DETECTABLE: f64 = 5.0;

/// The ideal detector for the recordings of a rig.
pub struct Ideal<'a> {
    rigs: Cow<'a, [Rig]>,
    sights: Vec<Sight>,
}

impl<'a> Ideal<'a> {
    /// The detector; runs each rig once without effects and noise.
    #[must_use]
    pub fn new(rigs: &'a [Rig]) -> Self {
        Self::over(Cow::Borrowed(rigs))
    }

    fn over(mut rigs: Cow<'a, [Rig]>) -> Self {
        if rigs
            .iter()
            .any(|rig| matches!(rig.profile, Profile::Loop { .. }))
        {
            // Which interval a sample sees hangs on a hair, so on a rough disc the answer of a loop to a small effect is not small.
            // An even disc shows the answer that a signal has on average.
            for rig in rigs.to_mut() {
                rig.disc_rad.fill(0.0);
            }
        }
        Self {
            sights: rigs.iter().map(Sight::new).collect(),
            rigs,
        }
    }

    /// The detector for an effect. What changes the shaft's speed slowly also changes how far ripples swing it; so does noise, so
    /// that tells nothing of the effect, and the ripples are left out. So is the disc, for the shaft's angles are compared.
    #[must_use]
    pub fn of(rigs: &'a [Rig], effect: &Effect) -> Self {
        if !effect.is_slow() {
            return Self::new(rigs);
        }
        let calm = rigs.iter().map(|rig| Rig {
            ripples: Vec::new(),
            disc_rad: vec![0.0; rig.disc_rad.len()],
            ..rig.clone()
        });
        Self::over(Cow::Owned(calm.collect()))
    }

    /// d' of an effect.
    #[must_use]
    pub fn distance(&self, effect: &Effect) -> f64 {
        if let Some(distance) = variance::distance(effect, &self.rigs, &self.passed()) {
            return distance;
        }
        project::length(&self.residual(effect))
    }

    /// d' that is left of an effect when its look-alikes, of any size, have explained what they can: how surely its name is the
    /// right one. None where it has no look-alike that moves edges as it does.
    #[must_use]
    pub fn separation(&self, effect: &Effect) -> Option<f64> {
        let others = alike::look_alikes(effect, &self.rigs);
        if others.is_empty() {
            return None;
        }
        let mut signal = self.residual(effect);
        let others = others.iter().map(|other| self.residual(other)).collect();
        project::take_out(&mut signal, others);
        Some(project::length(&signal))
    }

    fn residual(&self, effect: &Effect) -> Vec<f64> {
        let signals: Vec<Vec<f64>> = (self.rigs.iter().zip(&self.sights))
            .map(|(rig, sight)| sight.signal(rig, effect))
            .collect();
        project::residual(&self.rigs, &self.passed(), &signals)
    }

    fn passed(&self) -> Vec<&Passed> {
        self.sights.iter().map(|sight| &sight.passed).collect()
    }

    /// RMS by which an effect moves the edges, rad, in the recording where it moves them most.
    #[must_use]
    pub fn rms(&self, effect: &Effect) -> f64 {
        let each = self.rigs.iter().zip(&self.sights).map(|(rig, sight)| {
            let signal = sight.signal(rig, effect);
            let mean = signal.iter().sum::<f64>() / signal.len() as f64;
            let sum: f64 = signal.iter().map(|s| (s - mean) * (s - mean)).sum();
            (sum / signal.len() as f64).sqrt()
        });
        each.fold(0.0, f64::max)
    }

    /// The factor on an effect's size that makes it just detectable; none where no size does.
    #[must_use]
    pub fn factor(&self, effect: &Effect) -> Option<f64> {
        if effect.size() == 0.0 {
            // Counted, not sized.
            return Some(1.0);
        }
        let mut factor = 1.0;
        // Signals are close to linear in size: a few secant steps through 0 settle what is not.
        for _ in 0..6 {
            let distance = self.distance(&effect.scaled(factor));
            if !(distance.is_finite() && distance > 0.0) {
                return None;
            }
            // Variance goes as the square of a size.
            let power = if is_variance(effect) { 0.5 } else { 1.0 };
            let more = (DETECTABLE / distance).powf(power);
            factor *= more.clamp(1e-4, 1e4);
            if (more - 1.0).abs() < 1e-3 {
                return Some(factor);
            }
        }
        Some(factor)
    }
}

pub use variance::is_variance;

/// The rig that really turns: an effect may take the place of what the twin declares.
#[must_use]
pub fn changed(rig: &Rig, effect: &Effect) -> Rig {
    let mut rig = rig.clone();
    if let Effect::ClosedLoop {
        kp_n_m_s,
        ki_n_m,
        f_hz,
    } = *effect
    {
        rig.profile = Profile::Loop {
            speed: rig.profile.start(),
            f_hz,
            kp_n_m_s,
            ki_n_m,
        };
        rig.stiffness = 0.0;
    }
    rig
}
