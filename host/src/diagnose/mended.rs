//! A twin with a finding in it: it can be simulated, and should then explain the recording.

use super::basis::{Basis, change_of};
use super::estimate::Estimate;
use crate::twin::{
    Bearing, Channel, ChannelSkew, EdgeDelay, Flank, Harmonic, Hysteresis, LoadStep, LocalDefect,
    Ripple, SpeedDrift, ThresholdDrift, ThresholdRipple, TorqueTone, Twin,
};

/// A twin being mended, and what its disc lacks: errors of each edge, rad.
#[derive(Clone, Debug)]
pub struct Mended {
    /// The twin.
    pub twin: Twin,
    /// What is added to its disc's errors, for each edge of the recording; empty where nothing is.
    pub errors_rad: Vec<f64>,
    /// Edges a turn of the recording: of a wheel's tooth it may have one.
    pub edges: usize,
    /// Its edge classes.
    pub classes: usize,
}

/// Whether a finding goes into the list of a disc's errors, edge by edge.
#[must_use]
pub fn listed(basis: Basis) -> bool {
    match basis {
        Basis::Round { order } => order.fract() == 0.0 && order > 2.0,
        Basis::Width { .. } | Basis::Shift { .. } => true,
        _ => false,
    }
}

/// Channel of a number.
fn channel(number: usize) -> Channel {
    [Channel::A, Channel::B, Channel::C][number.min(2)]
}

impl Mended {
    /// Puts an estimate in; `recording` is this twin's, of so many.
    pub fn add(&mut self, estimate: &Estimate, recording: usize, recordings: usize) {
        let mut at = 0;
        for basis in &estimate.hypothesis.bases {
            let count = basis.count();
            let rest = estimate.sizes.len() - at;
            // Sizes of each recording's own, or one for all.
            let own = rest >= count * recordings
                && recordings > 1
                && estimate.hypothesis.bases.len() == 1;
            let from = if own { at + recording * count } else { at };
            let Some(sizes) = estimate.sizes.get(from..from + count) else {
                return;
            };
            self.add_basis(*basis, sizes);
            at += if own { count * recordings } else { count };
        }
    }

    fn add_basis(&mut self, basis: Basis, sizes: &[f64]) {
        let twin = &mut self.twin;
        let amplitude = if sizes.len() == 2 {
            sizes[0].hypot(sizes[1])
        } else {
            sizes[0]
        };
        let phase_rad = if sizes.len() == 2 {
            sizes[0].atan2(sizes[1])
        } else {
            0.0
        };
        let torque = |order: f64| Ripple {
            order,
            phase_rad,
            torque_n_m: Some(amplitude),
            speed_fraction: None,
        };
        match basis {
            Basis::Round { order } if order.fract() == 0.0 => {
                let harmonic = |old: Option<Harmonic>| {
                    // amplitude sin(order theta - phase)
                    let (s, c) = old.map_or((0.0, 0.0), |h| {
                        (
                            h.amplitude_rad * h.phase_rad.cos(),
                            -h.amplitude_rad * h.phase_rad.sin(),
                        )
                    });
                    let (s, c) = (s + sizes[1], c + sizes[0]);
                    Some(Harmonic {
                        amplitude_rad: s.hypot(c),
                        phase_rad: (-c).atan2(s),
                    })
                };
                let listed = twin.errors.csv.is_some()
                    || !twin.errors.list_rad.is_empty()
                    || !self.errors_rad.is_empty();
                match order {
                    1.0 if !listed => twin.errors.eccentricity = harmonic(twin.errors.eccentricity),
                    2.0 if !listed => twin.errors.tilt = harmonic(twin.errors.tilt),
                    _ => self.add_disc(|theta, _, _| {
                        let (sin, cos) = (order * theta).sin_cos();
                        sizes[0] * cos + sizes[1] * sin
                    }),
                }
            }
            Basis::Round { order } => twin.bearing.push(Bearing {
                order,
                phase_rad,
                torque_n_m: None,
                speed_fraction: None,
                runout_rad: Some(amplitude),
            }),
            Basis::TorqueOrder { order } if order.fract() == 0.0 => twin.ripple.push(torque(order)),
            Basis::TorqueOrder { order } => twin.gear_mesh.push(torque(order)),
            Basis::TorqueTone { f_hz } => twin.torque_tone.push(TorqueTone {
                f_hz,
                phase_rad,
                torque_n_m: Some(amplitude),
                speed_fraction: None,
            }),
            Basis::LevelTone { f_hz, channel: c } => {
                twin.threshold_ripple = Some(ThresholdRipple {
                    f_hz,
                    phase_rad,
                    angle_rad: amplitude,
                    channel: c.map(channel),
                });
            }
            Basis::LevelDrift { from_s, tau_s } => {
                twin.threshold_drift = Some(ThresholdDrift {
                    angle_rad: amplitude,
                    tau_s,
                    from_s: from_s.max(0.0),
                    channel: None,
                });
            }
            Basis::Width { channel: c } => self.add_disc(|_, channel, rises| {
                if !rises && c.is_none_or(|c| c == channel) {
                    sizes[0]
                } else {
                    0.0
                }
            }),
            Basis::Shift { channel: c } => {
                self.add_disc(|_, channel, _| if c == channel { sizes[0] } else { 0.0 });
            }
            Basis::RiseLate { channel: c } => {
                let mut delay: EdgeDelay = twin.edge_delay.unwrap_or_default();
                for (number, one) in [&mut delay.a, &mut delay.b, &mut delay.c]
                    .into_iter()
                    .enumerate()
                {
                    if c.is_some_and(|c| c != number) {
                        continue;
                    }
                    // Only the difference shows: no delay is negative.
                    let difference = one.rise_s - one.fall_s + sizes[0];
                    one.rise_s = difference.max(0.0);
                    one.fall_s = (-difference).max(0.0);
                }
                twin.edge_delay = Some(delay);
            }
            Basis::Late { channel: c } => {
                let mut skew: ChannelSkew = twin.channel_skew.unwrap_or_default();
                let mut all = [skew.a_s, skew.b_s, skew.c_s];
                all[c.min(2)] += sizes[0];
                let least = all.into_iter().fold(0.0, f64::min);
                [skew.a_s, skew.b_s, skew.c_s] = all.map(|late| late - least);
                twin.channel_skew = Some(skew);
            }
            Basis::Bump {
                angle_rad,
                width_rad,
                channel: c,
                rises,
            } => twin.local_defect.push(LocalDefect {
                angle_rad: angle_rad.rem_euclid(std::f64::consts::TAU),
                width_rad,
                error_rad: sizes[0],
                channel: c.map(channel),
                edge: rises.map(|rises| if rises { Flank::Rise } else { Flank::Fall }),
            }),
            Basis::Load { from_s, until_s } => twin.load_step.push(LoadStep {
                torque_n_m: sizes[0],
                from_s: from_s.max(0.0),
                until_s: until_s.is_finite().then_some(until_s),
            }),
            Basis::Drift => {
                twin.speed_drift = Some(SpeedDrift {
                    fraction_per_s: Some(sizes[0]),
                    fraction: None,
                    tau_s: None,
                });
            }
            Basis::Coulomb => twin.shaft.coulomb_n_m = (twin.shaft.coulomb_n_m + sizes[0]).max(0.0),
            Basis::Viscous => {
                twin.shaft.viscous_n_m_s = (twin.shaft.viscous_n_m_s + sizes[0]).max(0.0);
            }
            Basis::Drag => twin.shaft.drag_n_m_s2 = (twin.shaft.drag_n_m_s2 + sizes[0]).max(0.0),
            Basis::Stribeck { rad_s } => {
                twin.shaft.stribeck_n_m = (twin.shaft.stribeck_n_m + sizes[0]).max(0.0);
                twin.shaft.stribeck_rad_s = rad_s;
            }
            Basis::Direction => {
                let old = twin.hysteresis.map_or(0.0, |h| h.angle_rad);
                twin.hysteresis = Some(Hysteresis {
                    angle_rad: (old + sizes[0]).max(0.0),
                    channel: None,
                });
            }
            Basis::Task { .. } | Basis::Lagged { .. } => {}
        }
    }

    /// Adds errors of the disc by angle, channel and kind of edge.
    fn add_disc(&mut self, error: impl Fn(f64, usize, bool) -> f64) {
        let (edges, classes) = (self.edges, self.classes);
        let mut all = std::mem::take(&mut self.errors_rad);
        all.resize(edges, 0.0);
        for (edge, sum) in all.iter_mut().enumerate() {
            let ahead = usize::from(classes == 6);
            let change = change_of((edge + ahead) % classes, classes as i64);
            let theta = edge as f64 * std::f64::consts::TAU / edges as f64;
            *sum += error(theta, change.channel, change.rises);
        }
        self.errors_rad = all;
    }
}
