//! Effects that add variance and no signal.

use super::passed::Passed;
use crate::effect::Effect;
use crate::rig::Rig;
use crate::whiten::Whitener;

/// Whether an effect's mark is variance alone: then d' goes as the square of its size.
#[must_use]
pub const fn is_variance(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::TimestampJitter { .. } | Effect::CaptureLatency { .. } | Effect::BurstNoise { .. }
    )
}

/// d' of an effect that adds variance: the change of the edges' own variance times the root of its Fisher information, half the
/// sum of the squared relative changes of the innovations' variances. None for others.
///
/// The mean of a latency is an offset that no one can see; its spread is what is left, the square of the mean. A torsional mode is
/// driven by noise that no one knows, so what it shows is the ratio of the spectra of the angle with and without it.
pub(super) fn distance(effect: &Effect, rigs: &[Rig], runs: &[&Passed]) -> Option<f64> {
    if let Effect::TorsionalResonance {
        f_hz,
        damping_ratio,
        inertia_share,
    } = *effect
    {
        let each = rigs
            .iter()
            .zip(runs)
            .map(|(rig, run)| resonance(rig, run, f_hz, damping_ratio, inertia_share));
        return Some(each.sum::<f64>().sqrt());
    }
    let information = |added: &dyn Fn(f64) -> f64| -> f64 {
        let each = runs.iter().map(|run| {
            let noise = run.noise.iter().zip(&run.speed).map(|(edge, &speed)| {
                let mut edge = *edge;
                edge.own_rad2 += added(speed);
                edge
            });
            let with = Whitener::new(&noise.collect::<Vec<_>>(), run.density);
            let pairs = run.whitener.deviations().zip(with.deviations());
            // The first few innovations only find angle and speed.
            pairs
                .skip(10)
                .map(|(without, with)| 0.5 * (with / without).powi(2).ln().powi(2))
                .sum::<f64>()
        });
        each.sum()
    };
    // Linear in the variance where it is small, and the size looked for is small: the derivative scaled up.
    let small = 1e-3 * rigs[0].stamp_rms_s().powi(2);
    let per_second2 = || information(&|speed| speed * speed * small).sqrt() / small;
    match *effect {
        Effect::TimestampJitter { jitter_s } => Some(jitter_s * jitter_s * per_second2()),
        Effect::CaptureLatency { mean_s } => Some(mean_s * mean_s * per_second2()),
        Effect::BurstNoise {
            angle_rad, share, ..
        } => {
            // Only a share of the edges has it, so only that share of the information.
            let speed = rigs[0].profile.top();
            let small = small * speed * speed;
            let rate = information(&|_| small).sqrt() / small;
            Some(angle_rad * angle_rad * rate * share.sqrt())
        }
        _ => None,
    }
}

/// Squared d' of a torsional mode: half the sum, over the frequencies that a recording resolves, of the squared relative change of
/// the angle's spectrum.
fn resonance(rig: &Rig, run: &Passed, f_hz: f64, damping_ratio: f64, share: f64) -> f64 {
    let (Some(&first), Some(&last)) = (run.time.first(), run.time.last()) else {
        return 0.0;
    };
    let long = last - first;
    let edges = run.time.len() as f64;
    let own: f64 = run.noise.iter().map(|edge| edge.own_rad2).sum::<f64>() / edges;
    let floor = own * long / edges;
    let damping = rig.damping(true);
    let mode = std::f64::consts::TAU * f_hz;
    let mut sum = 0.0;
    for line in 1..(edges / 2.0) as u64 {
        let w = std::f64::consts::TAU * line as f64 / long;
        let rigid = run.density / (w * w * (w * w + damping * damping));
        // Seen from the near side the inertia is near + far k / (k - far w^2): dynamic stiffness with a damped spring.
        let near = 1.0 - share;
        let reduced = near * share;
        let spring = nalgebra::Complex::new(
            mode * mode * reduced,
            2.0 * damping_ratio * mode * reduced * w,
        );
        let far = share * w * w;
        let inertia = near + share * spring / (spring - far);
        let response = nalgebra::Complex::new(0.0, damping * w) - inertia * w * w;
        let coupled = run.density / response.norm_sqr();
        // Log ratio: as the relative change where that is small, and not carried away by one sharp line where it is not.
        let ratio = ((coupled + floor) / (rigid + floor)).ln();
        sum += 0.5 * ratio * ratio;
    }
    sum
}
