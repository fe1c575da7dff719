//! What a simulation could not get done: more steps of time than a recording needs, more terms than a shaft has.

use std::f64::consts::TAU;

use super::Checker;
use crate::twin::{Drive, Duration, EffectSite, Noise, Twin};

/// Steps of noise that a run may take whatever its edges: about ten seconds of work.
const STEPS_MAX: f64 = 1e7;
/// The same of integration, where many terms make a step dearer.
const PIECES_MAX: f64 = 5e6;
/// The same of a speed loop, whose rate is that of a real drive.
const SAMPLES_MAX: f64 = 1e8;
/// Steps of time for each edge that a longer run may take: what is faster than an edge is averaged over its interval.
const STEPS_AN_EDGE: f64 = 100.0;
/// Steps of integration in the time in which something turns by a radian, or falls by e.
const STEPS_A_RADIAN: f64 = 3.0;
/// Steps of noise in a correlation time or a period, where a twin does not say; as in the simulator.
const NOISE_STEPS: f64 = 50.0;
/// Edges that may be on their way to the timer at a time.
const IN_FLIGHT_MAX: f64 = 1e5;
/// Most entries of a list whose every entry costs time at every step or edge.
const TERMS_MAX: usize = 250;
/// Most entries of a list of instants.
const INSTANTS_MAX: usize = 5000;
/// Most defects of a disc.
const DEFECTS_MAX: usize = 1000;

const SLOWER: &str = "use a slower one, or record less time";

impl Twin {
    pub(super) fn check_cost(&self, c: &mut Checker<'_>) {
        for (key, entries, most) in [
            ("ripple", self.ripple.len(), TERMS_MAX),
            ("gear_mesh", self.gear_mesh.len(), TERMS_MAX),
            ("bearing", self.bearing.len(), TERMS_MAX),
            ("torque_tone", self.torque_tone.len(), TERMS_MAX),
            ("threshold_ripple", self.threshold_ripple.len(), TERMS_MAX),
            ("threshold_drift", self.threshold_drift.len(), TERMS_MAX),
            ("effect", self.effect.len(), TERMS_MAX),
            ("load_step", self.load_step.len(), INSTANTS_MAX),
            ("index_slip", self.index_slip.len(), INSTANTS_MAX),
            ("local_defect", self.local_defect.len(), DEFECTS_MAX),
        ] {
            c.list(key, entries, most);
        }
        if self.drive == Drive::Unknown || self.duration == Duration::Unknown {
            return;
        }
        self.check_noise_steps(c);
        self.check_integration(c);
        self.check_in_flight(c);
    }

    /// Edges a second at the nominal speed.
    fn edge_hz(&self) -> f64 {
        f64::from(self.encoder.grid_edges()) * self.drive.nominal_rad_s().abs() / TAU
    }

    /// Steps a second that a run may take, `most` in all where edges are few.
    fn step_hz(&self, most: f64) -> f64 {
        (STEPS_AN_EDGE * self.edge_hz()).max(most / self.seconds())
    }

    /// About how long a run takes, s.
    fn seconds(&self) -> f64 {
        match self.duration {
            Duration::Seconds(seconds) => seconds,
            Duration::Turns(turns) => turns * TAU / self.drive.nominal_rad_s().abs(),
            Duration::Unknown => 0.0,
        }
    }

    fn check_noise_steps(&self, c: &mut Checker<'_>) {
        let most_hz = self.step_hz(STEPS_MAX);
        let shortest_s = 1.0 / most_hz;
        let mut hold = |key: &str, hold_s: f64| {
            let allowed = format!(
                "{shortest_s:.3e} or more: up to {STEPS_AN_EDGE} steps of noise an edge, or {STEPS_MAX:e} in all"
            );
            c.require(hold_s >= shortest_s, key, hold_s, &allowed, SLOWER);
        };
        match self.noise {
            Some(Noise::White { hold_s, .. }) => {
                hold("noise.white.hold_s", hold_s.unwrap_or(f64::INFINITY));
            }
            Some(Noise::SpeedWander { hold_s, .. }) => {
                hold("noise.speed_wander.hold_s", hold_s.unwrap_or(f64::INFINITY));
            }
            None => {}
        }
        let far = self
            .torsional_resonance
            .filter(|r| r.load_psd_n2_m2_s.is_some());
        if let Some(hold_s) = far.and_then(|r| r.load_hold_s) {
            hold("torsional_resonance.load_hold_s", hold_s);
        }
        if let Some(Noise::SpeedWander {
            correlation_rad: Some(correlation),
            hold_s,
            ..
        }) = self.noise
        {
            let a_step = if hold_s.is_some() {
                STEPS_A_RADIAN
            } else {
                NOISE_STEPS
            };
            let least = a_step * self.drive.nominal_rad_s().abs() / most_hz;
            let allowed = format!(
                "{least:.3e} or more: up to {STEPS_AN_EDGE} steps of noise an edge, or {STEPS_MAX:e} in all"
            );
            let key = "noise.speed_wander.correlation_rad";
            c.require(correlation >= least, key, correlation, &allowed, SLOWER);
        }
        if let Some(resonance) = far.filter(|r| r.load_hold_s.is_none()) {
            let most = most_hz / NOISE_STEPS;
            let allowed = format!(
                "up to {most:.3e}: {NOISE_STEPS} steps of noise a period, {STEPS_MAX:e} in all"
            );
            let key = "torsional_resonance.f_hz";
            c.require(
                resonance.f_hz <= most,
                key,
                resonance.f_hz,
                &allowed,
                SLOWER,
            );
        }
        if let Drive::SpeedLoop { f_hz, .. } = self.drive {
            let most = self.step_hz(SAMPLES_MAX);
            let allowed = format!(
                "up to {most:.3e}: {STEPS_AN_EDGE} samples an edge, or {SAMPLES_MAX:e} in all"
            );
            c.require(
                f_hz <= most,
                "drive.speed_loop.f_hz",
                f_hz,
                &allowed,
                SLOWER,
            );
        }
    }

    /// What turns or falls so fast that the integration takes too many steps.
    fn check_integration(&self, c: &mut Checker<'_>) {
        let most = self.step_hz(PIECES_MAX) / STEPS_A_RADIAN;
        let mut fast = |key: &str, value: f64, rad_s: f64| {
            let allowed = format!(
                "up to {:.3e}: {STEPS_AN_EDGE} steps of integration an edge, or {PIECES_MAX:e} in all",
                value * (most / rad_s)
            );
            c.require(rad_s <= most, key, value, &allowed, SLOWER);
        };
        let speed = self.drive.nominal_rad_s().abs();
        let orders =
            |list: &'static str, order: f64, i: usize| (format!("{list}[{i}].order"), order);
        let ripples = self.ripple.iter().map(|r| r.order).enumerate();
        let gears = self.gear_mesh.iter().map(|g| g.order).enumerate();
        let bearings = self.bearing.iter().enumerate();
        let bearings = bearings.filter(|(_, b)| b.runout_rad.is_none());
        let all = ripples.map(|(i, order)| orders("ripple", order, i));
        let all = all.chain(gears.map(|(i, order)| orders("gear_mesh", order, i)));
        for (key, order) in all.chain(bearings.map(|(i, b)| orders("bearing", b.order, i))) {
            fast(&key, order, order * speed);
        }
        for (i, tone) in self.torque_tone.iter().enumerate() {
            fast(
                &format!("torque_tone[{i}].f_hz"),
                tone.f_hz,
                TAU * tone.f_hz,
            );
        }
        for (i, one) in self.effect.iter().enumerate() {
            if !matches!(one.site, EffectSite::Torque | EffectSite::Drive) {
                continue;
            }
            let seconds = self.seconds();
            for (key, value, rad_s) in [
                ("order", one.order, one.order.map(|order| order * speed)),
                ("f_hz", one.f_hz, {
                    let rate = one.rate_hz_s.unwrap_or(0.0).abs();
                    one.f_hz.map(|f_hz| TAU * (f_hz + rate * seconds))
                }),
                ("width_rad", one.width_rad, {
                    one.width_rad.map(|width| speed / width)
                }),
                ("modulation_hz", one.modulation_hz, {
                    one.modulation_hz.map(|f_hz| TAU * f_hz)
                }),
            ] {
                if let (Some(value), Some(rad_s)) = (value, rad_s) {
                    fast(&format!("effect[{i}].{key}"), value, rad_s);
                }
            }
        }
        if let Some(resonance) = &self.torsional_resonance {
            let damped = TAU * resonance.f_hz * (1.0 + 2.0 * resonance.damping_ratio);
            fast("torsional_resonance.f_hz", resonance.f_hz, damped);
        }
        let (s, inertia) = (&self.shaft, self.shaft.inertia_or_one());
        for (key, value) in [
            ("shaft.viscous_n_m_s", s.viscous_n_m_s),
            ("shaft.stiffness_n_m_s", s.stiffness_n_m_s),
        ] {
            fast(key, value, value / inertia);
        }
        fast(
            "shaft.drag_n_m_s2",
            s.drag_n_m_s2,
            2.0 * s.drag_n_m_s2 * speed / inertia,
        );
        if s.stribeck_n_m > 0.0 {
            let falls = s.stribeck_n_m / (inertia * s.stribeck_rad_s);
            fast("shaft.stribeck_n_m", s.stribeck_n_m, falls);
        }
        if let Some(spring) = &self.stick_slip {
            let stiffness = spring.stiffness_n_m_rad;
            fast(
                "stick_slip.stiffness_n_m_rad",
                stiffness,
                (stiffness / inertia).sqrt(),
            );
        }
    }

    /// Edges that are late wait in memory.
    fn check_in_flight(&self, c: &mut Checker<'_>) {
        let most = IN_FLIGHT_MAX / self.edge_hz();
        let e = self.edge_delay.unwrap_or_default();
        let s = self.channel_skew.unwrap_or_default();
        let latency = self.capture_latency.unwrap_or_default();
        for (key, late_s) in [
            ("edge_delay.a.rise_s", e.a.rise_s),
            ("edge_delay.a.fall_s", e.a.fall_s),
            ("edge_delay.b.rise_s", e.b.rise_s),
            ("edge_delay.b.fall_s", e.b.fall_s),
            ("edge_delay.c.rise_s", e.c.rise_s),
            ("edge_delay.c.fall_s", e.c.fall_s),
            ("channel_skew.a_s", s.a_s),
            ("channel_skew.b_s", s.b_s),
            ("channel_skew.c_s", s.c_s),
            ("capture_latency.mean_s", latency.mean_s.unwrap_or(0.0)),
            ("capture_latency.busy_s", latency.busy_s.unwrap_or(0.0)),
            ("faults.glitch_width_s", self.faults.glitch_width_s),
        ] {
            let allowed =
                format!("up to {most:.3e} at this speed: {IN_FLIGHT_MAX:e} edges on their way");
            c.require(
                late_s <= most,
                key,
                late_s,
                &allowed,
                "give the time of a real capture",
            );
        }
    }
}
