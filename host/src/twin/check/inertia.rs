//! What needs the inertia.

use super::Checker;
use crate::twin::{Drive, Noise, Twin};

impl Twin {
    /// Everything given as a torque needs `shaft.inertia_kg_m2`; but without a drive nothing is simulated, and a torque may be in units of
    /// the unknown inertia.
    pub(super) fn check_inertia(&self, c: &mut Checker<'_>) {
        if self.shaft.inertia_kg_m2 != 0.0 || self.drive == Drive::Unknown {
            return;
        }
        if let Some((key, value)) = self.first_torque() {
            c.require(
                false,
                &key,
                value,
                "only with shaft.inertia_kg_m2",
                "give the inertia of all that turns: a torque moves the shaft by it",
            );
        }
    }

    /// Key and value of the first torque.
    fn first_torque(&self) -> Option<(String, f64)> {
        let s = &self.shaft;
        let shaft = [
            ("shaft.viscous_n_m_s", s.viscous_n_m_s),
            ("shaft.coulomb_n_m", s.coulomb_n_m),
            ("shaft.drag_n_m_s2", s.drag_n_m_s2),
            ("shaft.stribeck_n_m", s.stribeck_n_m),
            ("shaft.stiffness_n_m_s", s.stiffness_n_m_s),
        ];
        let shaft = shaft.into_iter().filter(|(_, value)| *value != 0.0);
        let others = [
            ("stick_slip.stiffness_n_m_rad", {
                self.stick_slip.map(|spring| spring.stiffness_n_m_rad)
            }),
            ("torsional_resonance.load_psd_n2_m2_s", {
                self.torsional_resonance.and_then(|r| r.load_psd_n2_m2_s)
            }),
            (
                "noise.white.psd_n2_m2_s",
                match self.noise {
                    Some(Noise::White { psd_n2_m2_s, .. }) => Some(psd_n2_m2_s),
                    _ => None,
                },
            ),
        ];
        let others = others
            .into_iter()
            .filter_map(|(key, value)| Some((key, value?)));
        let fixed = self.drive_torques().into_iter().chain(shaft).chain(others);
        let fixed = fixed.map(|(key, value)| (key.to_owned(), value));
        fixed.chain(self.listed_torques()).next()
    }

    fn drive_torques(&self) -> Vec<(&'static str, f64)> {
        match &self.drive {
            Drive::Torque(torque) => {
                let first = torque.points().first();
                vec![("drive.torque", first.map_or(0.0, |point| point.torque_n_m))]
            }
            Drive::SpeedLoop {
                kp_n_m_s,
                ki_n_m,
                limit_n_m,
                ..
            } => {
                let keys = [
                    ("drive.speed_loop.kp_n_m_s", kp_n_m_s),
                    ("drive.speed_loop.ki_n_m", ki_n_m),
                    ("drive.speed_loop.limit_n_m", limit_n_m),
                ];
                let given = keys
                    .into_iter()
                    .filter_map(|(key, value)| Some((key, (*value)?)));
                given.collect()
            }
            _ => Vec::new(),
        }
    }

    fn listed_torques(&self) -> impl Iterator<Item = (String, f64)> {
        let ripple = self.ripple.iter().map(|r| r.torque_n_m).enumerate();
        let gears = self.gear_mesh.iter().map(|g| g.torque_n_m).enumerate();
        let bearings = self.bearing.iter().map(|b| b.torque_n_m).enumerate();
        let tones = self.torque_tone.iter().map(|t| t.torque_n_m).enumerate();
        let loads = self
            .load_step
            .iter()
            .map(|l| Some(l.torque_n_m))
            .enumerate();
        let effects = self.effect.iter().map(|e| e.torque_n_m).enumerate();
        let named = |name: &'static str| {
            move |(i, torque): (usize, Option<f64>)| {
                Some((format!("{name}[{i}].torque_n_m"), torque?))
            }
        };
        let all = ripple.filter_map(named("ripple"));
        let all = all.chain(gears.filter_map(named("gear_mesh")));
        let all = all.chain(bearings.filter_map(named("bearing")));
        let all = all.chain(tones.filter_map(named("torque_tone")));
        let all = all.chain(loads.filter_map(named("load_step")));
        all.chain(effects.filter_map(named("effect")))
    }
}
