//! Ids and parameters of effects, as the sealed truth has them.

use std::borrow::Cow;

use serde_json::{Map, Value, json};

use super::Effect;
use crate::rig::Order;

impl Effect {
    /// The mechanism's id; `unknown` for what no catalogue has.
    #[must_use]
    pub const fn id(&self) -> &'static str {
        match self {
            Self::Eccentricity { .. } => "eccentricity",
            Self::DiscTilt { .. } => "disc_tilt",
            Self::LocalDefect { .. } => "local_defect",
            Self::LineError { .. } => "line_error",
            Self::WidthError { .. } => "width_error",
            Self::QuadratureError { .. } => "quadrature_error",
            Self::EdgeDelay { .. } => "edge_delay",
            Self::ChannelSkew { .. } => "channel_skew",
            Self::ThresholdRipple { .. } => "threshold_ripple",
            Self::ThresholdDrift { .. } => "threshold_drift",
            Self::TorqueRipple(_) => "torque_ripple",
            Self::GearMesh(_) => "gear_mesh",
            Self::BearingTorque(_) | Self::BearingRunout { .. } => "bearing",
            Self::TorqueTone { .. } => "torque_tone",
            Self::LoadStep { .. } => "load_step",
            Self::SpeedDrift { .. } => "speed_drift",
            Self::Friction { .. } => "friction",
            Self::StickSlip { .. } => "stick_slip",
            Self::TorsionalResonance { .. } => "torsional_resonance",
            Self::TimestampJitter { .. } => "timestamp_jitter",
            Self::CaptureLatency { .. } | Self::CaptureTask { .. } => "capture_latency",
            Self::LostEdges { .. } => "lost_edges",
            Self::ExtraEdges { .. } => "extra_edges",
            Self::IndexSlip { .. } => "index_slip",
            Self::Hysteresis { .. } => "hysteresis",
            Self::Backlash { .. } => "backlash",
            Self::ClosedLoop { .. } => "closed_loop",
            Self::Whirl { .. }
            | Self::Chirp { .. }
            | Self::OrderChirp { .. }
            | Self::ModulatedOrder { .. }
            | Self::BurstNoise { .. }
            | Self::Telegraph { .. }
            | Self::Creep { .. }
            | Self::Cell(_) => "unknown",
        }
    }

    /// Other ids that describe the very same physics: no recording tells them from this one, so they are as right.
    #[must_use]
    pub const fn same_physics(&self) -> &'static [&'static str] {
        match self {
            Self::GearMesh(_) => &["bearing"],
            Self::BearingTorque(_) => &["gear_mesh"],
            Self::Hysteresis { .. } => &["backlash"],
            Self::Backlash { .. } => &["hysteresis"],
            _ => &[],
        }
    }

    /// What physics it is, for those that no catalogue has; else the id.
    #[must_use]
    pub fn physics(&self) -> Cow<'static, str> {
        let words = match self {
            Self::Cell(cell) => return cell.words().into(),
            Self::Whirl { .. } => "eccentricity by whirl",
            Self::Chirp { .. } => "torque that sweeps in frequency",
            Self::OrderChirp { .. } => "torque that sweeps in order",
            Self::ModulatedOrder { .. } => "non-integer order with swept modulation",
            Self::BurstNoise { .. } => "noise in random bursts",
            Self::Telegraph { .. } => "random telegraph level",
            Self::Creep { .. } => "disc creeping with angle, snapping back",
            _ => self.id(),
        };
        words.into()
    }

    /// Parameters by name, SI units as the names say.
    #[must_use]
    pub fn parameters(&self) -> Map<String, Value> {
        let value = match self {
            Self::Eccentricity {
                amplitude_rad,
                phase_rad,
            }
            | Self::DiscTilt {
                amplitude_rad,
                phase_rad,
            } => json!({"amplitude_rad": amplitude_rad, "phase_rad": phase_rad}),
            Self::LocalDefect {
                angle_rad,
                width_rad,
                error_rad,
                channel,
                rises,
            } => json!({
                "angle_rad": angle_rad, "width_rad": width_rad, "error_rad": error_rad,
                "channel": channel.map(letter), "edge": rises.map(|r| if r { "rise" } else { "fall" }),
            }),
            Self::LineError { rms_rad, .. } => json!({"rms_rad": rms_rad}),
            Self::WidthError { rad: [a, b, c] } => {
                json!({"width_a_rad": a, "width_b_rad": b, "width_c_rad": c})
            }
            Self::QuadratureError { rad } => json!({"quadrature_rad": rad}),
            Self::EdgeDelay { rise_s, fall_s } => json!({
                "a.rise_s": rise_s[0], "b.rise_s": rise_s[1], "c.rise_s": rise_s[2],
                "a.fall_s": fall_s[0], "b.fall_s": fall_s[1], "c.fall_s": fall_s[2],
            }),
            Self::ChannelSkew {
                channel_s: [a, b, c],
            } => json!({"a_s": a, "b_s": b, "c_s": c}),
            Self::ThresholdRipple {
                f_hz,
                phase_rad,
                angle_rad,
                channel,
            } => json!({
                "f_hz": f_hz, "phase_rad": phase_rad, "angle_rad": angle_rad, "channel": channel.map(letter),
            }),
            Self::ThresholdDrift {
                angle_rad,
                tau_s,
                from_s,
            } => json!({"angle_rad": angle_rad, "tau_s": tau_s, "from_s": from_s}),
            Self::TorqueRipple(o) | Self::GearMesh(o) | Self::BearingTorque(o) => order(o),
            Self::BearingRunout {
                order,
                phase_rad,
                runout_rad,
            } => json!({"order": order, "phase_rad": phase_rad, "runout_rad": runout_rad}),
            Self::TorqueTone {
                f_hz,
                phase_rad,
                torque_n_m,
            } => json!({"f_hz": f_hz, "phase_rad": phase_rad, "torque_n_m": torque_n_m}),
            Self::LoadStep {
                torque_n_m,
                from_s,
                until_s,
            } => json!({"torque_n_m": torque_n_m, "from_s": from_s, "until_s": until_s}),
            Self::SpeedDrift { fraction_per_s } => json!({"fraction_per_s": fraction_per_s}),
            Self::Friction {
                coulomb_n_m,
                viscous_n_m_s,
                drag_n_m_s2,
                stribeck_n_m,
                stribeck_rad_s,
            } => json!({
                "coulomb_n_m": coulomb_n_m, "viscous_n_m_s": viscous_n_m_s, "drag_n_m_s2": drag_n_m_s2,
                "stribeck_n_m": stribeck_n_m, "stribeck_rad_s": stribeck_rad_s,
            }),
            Self::StickSlip {
                stiffness_n_m_rad,
                coulomb_n_m,
                stribeck_n_m,
                stribeck_rad_s,
            } => json!({
                "stiffness_n_m_rad": stiffness_n_m_rad, "coulomb_n_m": coulomb_n_m, "stribeck_n_m": stribeck_n_m,
                "stribeck_rad_s": stribeck_rad_s,
            }),
            Self::TorsionalResonance {
                f_hz,
                damping_ratio,
                inertia_share,
            } => {
                json!({"f_hz": f_hz, "damping_ratio": damping_ratio, "inertia_share": inertia_share})
            }
            Self::TimestampJitter { jitter_s } => json!({"jitter_s": jitter_s}),
            Self::CaptureLatency { mean_s } => json!({"mean_s": mean_s}),
            Self::CaptureTask {
                task_hz,
                busy_s,
                phase_s,
            } => json!({"task_hz": task_hz, "busy_s": busy_s, "phase_s": phase_s}),
            Self::LostEdges { count, .. } | Self::ExtraEdges { count, .. } => {
                json!({"count": count})
            }
            Self::IndexSlip { at_s, edges } => json!({"at_s": at_s, "edges": edges}),
            Self::Hysteresis { angle_rad } => json!({"angle_rad": angle_rad}),
            Self::Backlash { gap_rad } => json!({"gap_rad": gap_rad}),
            Self::ClosedLoop {
                kp_n_m_s,
                ki_n_m,
                f_hz,
            } => json!({"kp_n_m_s": kp_n_m_s, "ki_n_m": ki_n_m, "f_hz": f_hz}),
            other => json!({"physics": other.physics(), "drawn_as": format!("{other:?}")}),
        };
        let Value::Object(map) = value else {
            return Map::new();
        };
        map.into_iter().filter(|(_, v)| !v.is_null()).collect()
    }
}

fn letter(channel: usize) -> &'static str {
    ["a", "b", "c"][channel]
}

fn order(o: &Order) -> Value {
    json!({"order": o.order, "phase_rad": o.phase_rad, "torque_n_m": o.torque_n_m})
}
