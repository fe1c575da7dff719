//! Mechanisms put on top of a twin: the rig that is recorded has one more than the twin that is diagnosed.

use anyhow::{Context, Result};
use quadcal_blind::ideal::DETECTABLE;
use quadcal_host::mechanism::Mechanism;
use toml::{Table, Value, toml};

use super::sight;
use super::tree::{self, number};

/// How a mechanism's size is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sizing {
    /// Its mark grows with this power of its size; first guess.
    Grows(f64),
    /// It comes in whole counts; one is detectable.
    Counted,
    /// It has no size: it is there, or not.
    Whole,
}

/// What a twin says of its rig, as far as a mechanism's section needs it.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// Grid step, rad.
    step: f64,
    /// A speed that it turns at, rad/s.
    speed: f64,
    /// Its length, s.
    long: f64,
    inertia: f64,
    channels: usize,
    index: bool,
}

/// A mechanism that this twin can have on top.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// How its size is found.
    pub sizing: Sizing,
    facts: Facts,
}

impl Plant {
    /// That of a mechanism; none where the twin can't have it.
    #[must_use]
    pub fn of(mechanism: Mechanism, twin: &Table) -> Option<Self> {
        let facts = Facts::of(twin)?;
        let sizing = facts.sizing(mechanism, twin)?;
        Some(Self {
            mechanism,
            sizing,
            facts,
        })
    }

    /// The rig with the mechanism of a size on top.
    #[must_use]
    pub fn on(&self, twin: &Table, size: f64) -> Table {
        let mut rig = twin.clone();
        self.facts.put(&mut rig, self.mechanism, size);
        rig
    }

    /// The detectable size: where the ideal detector has d' = 5. None where no size of it shows in this rig.
    ///
    /// # Errors
    /// Where the rig can't be simulated.
    pub fn detectable(&self, twin: &Table) -> Result<Option<f64>> {
        let power = match self.sizing {
            Sizing::Grows(power) => power,
            Sizing::Counted | Sizing::Whole => return Ok(Some(1.0)),
        };
        let mut size = self.facts.first(self.mechanism, twin);
        for _ in 0..8 {
            let rig = self.on(twin, size);
            let shown = sight::distance(twin, &rig)
                .with_context(|| format!("{} of size {size:e} on top", self.mechanism.id()))?;
            if !(shown.is_finite() && shown > 1e-6) {
                return Ok(None);
            }
            let more = (DETECTABLE / shown).powf(1.0 / power);
            if (more - 1.0).abs() < 0.05 {
                return Ok(Some(size));
            }
            let next = (size * more.clamp(1e-3, 1e3)).max(least(self.mechanism));
            if next == size {
                // What shows is the least that a twin can say.
                return Ok(Some(size));
            }
            size = next;
            if size > self.facts.most(self.mechanism) {
                return Ok(None);
            }
        }
        Ok(None)
    }
}

impl Facts {
    fn of(twin: &Table) -> Option<Self> {
        let count = |dotted: &str| number(twin, dotted);
        let (edges, channels) = if let Some(lines) = count("encoder.quadrature.lines") {
            (4.0 * lines, 2)
        } else if let Some(pairs) = count("encoder.hall.pole_pairs") {
            (6.0 * pairs, 3)
        } else {
            (2.0 * count("encoder.wheel.teeth")?, 1)
        };
        let steps = tree::get(twin, &tree::path("drive.steps")).and_then(Value::as_array);
        let last = steps.and_then(|steps| tree::as_number(steps.last()?.get("r_min")?));
        let r_min = ["constant", "run_down", "speed_loop"]
            .iter()
            .find_map(|kind| count(&format!("drive.{kind}.r_min")))
            .or(last)?;
        let speed = (r_min * std::f64::consts::TAU / 60.0).abs();
        let long = match count("duration.seconds") {
            Some(seconds) => seconds,
            None => count("duration.turns")? * std::f64::consts::TAU / speed,
        };
        let index = tree::get(twin, &tree::path("encoder.quadrature.index"));
        Some(Self {
            step: std::f64::consts::TAU / edges,
            speed,
            long,
            inertia: count("shaft.inertia_kg_m2")?,
            channels,
            index: index.and_then(Value::as_bool).unwrap_or(false),
        })
    }

    /// How a mechanism's size is found; none where the twin can't have it, or has it where there is room for one only.
    fn sizing(self, mechanism: Mechanism, twin: &Table) -> Option<Sizing> {
        let free = |section: &str| !twin.contains_key(section);
        let constant = number(twin, "drive.constant.r_min").is_some();
        let there = match mechanism {
            Mechanism::Unknown => false,
            Mechanism::LineError => {
                number(twin, "errors.position.uniform.amplitude_rad").is_some()
                    || number(twin, "errors.position.normal.rms_rad").is_some()
            }
            Mechanism::QuadratureError => self.channels == 2,
            Mechanism::ChannelSkew => self.channels > 1,
            Mechanism::IndexSlip => self.index,
            Mechanism::CaptureLatency => free("capture_latency"),
            Mechanism::TorsionalResonance => free("torsional_resonance") && free("stick_slip"),
            Mechanism::SpeedDrift => {
                free("speed_drift") && number(twin, "drive.speed_loop.r_min").is_none()
            }
            Mechanism::StickSlip | Mechanism::ClosedLoop => constant && free("stick_slip"),
            Mechanism::Hysteresis => free("hysteresis"),
            Mechanism::Backlash => free("backlash"),
            _ => true,
        };
        there.then_some(match mechanism {
            Mechanism::TimestampJitter => Sizing::Grows(2.0),
            Mechanism::LostEdges | Mechanism::ExtraEdges | Mechanism::IndexSlip => Sizing::Counted,
            Mechanism::StickSlip | Mechanism::ClosedLoop => Sizing::Whole,
            _ => Sizing::Grows(1.0),
        })
    }

    /// A size to begin the search with.
    fn first(self, mechanism: Mechanism, twin: &Table) -> f64 {
        let angle = 1e-3 * self.step;
        match mechanism {
            Mechanism::EdgeDelay | Mechanism::ChannelSkew | Mechanism::CaptureLatency => {
                angle / self.speed
            }
            Mechanism::TimestampJitter => {
                let tick = 1.0 / number(twin, "timer.clock_hz").unwrap_or(1e6);
                number(twin, "timer.jitter_s").unwrap_or(0.0).hypot(tick)
            }
            Mechanism::TorqueRipple
            | Mechanism::GearMesh
            | Mechanism::TorqueTone
            | Mechanism::LoadStep
            | Mechanism::Friction => 1e-4 * self.inertia * self.speed * self.speed,
            Mechanism::SpeedDrift => 1e-4 / self.long,
            Mechanism::TorsionalResonance => 0.01,
            _ => angle,
        }
    }

    /// The largest size that a real rig has: above it, it is no small thing that is missing.
    fn most(self, mechanism: Mechanism) -> f64 {
        let angle = (3.0 * self.step).min(0.1);
        match mechanism {
            Mechanism::Eccentricity | Mechanism::DiscTilt | Mechanism::Bearing => 0.05,
            Mechanism::LineError
            | Mechanism::WidthError
            | Mechanism::QuadratureError
            | Mechanism::LocalDefect
            | Mechanism::ThresholdRipple
            | Mechanism::ThresholdDrift
            | Mechanism::Hysteresis
            | Mechanism::Backlash => angle,
            Mechanism::EdgeDelay | Mechanism::ChannelSkew | Mechanism::CaptureLatency => {
                0.2 * self.step / self.speed
            }
            Mechanism::TorsionalResonance => 0.6,
            _ => f64::INFINITY,
        }
    }

    /// Puts a mechanism of a size on top.
    fn put(self, rig: &mut Table, mechanism: Mechanism, size: f64) {
        let (middle, turn_hz) = (0.4 * self.long, self.speed / std::f64::consts::TAU);
        let mut push = |list: &str, section: Table| tree::push(rig, list, section);
        match mechanism {
            Mechanism::LineError => {
                for key in ["uniform.amplitude_rad", "normal.rms_rad"] {
                    let key = format!("errors.position.{key}");
                    if number(rig, &key).is_some() {
                        tree::add(rig, &key, size);
                    }
                }
            }
            Mechanism::WidthError => tree::add(rig, "errors.width_a_rad", size),
            Mechanism::QuadratureError => tree::add(rig, "errors.quadrature_rad", size),
            Mechanism::Eccentricity => tree::add(rig, "errors.eccentricity.amplitude_rad", size),
            Mechanism::DiscTilt => tree::add(rig, "errors.tilt.amplitude_rad", size),
            Mechanism::LocalDefect => {
                let width = (8.0 * self.step).min(0.3);
                push(
                    "local_defect",
                    toml! { angle_rad = 5.1
                    width_rad = width
                    error_rad = size },
                );
            }
            Mechanism::Hysteresis => tree::set(rig, "hysteresis.angle_rad", size),
            Mechanism::Backlash => tree::set(rig, "backlash.gap_rad", size),
            Mechanism::EdgeDelay => tree::add(rig, "edge_delay.a.rise_s", size),
            Mechanism::ChannelSkew => tree::add(rig, "channel_skew.b_s", size),
            Mechanism::ThresholdRipple => push(
                "threshold_ripple",
                toml! { f_hz = (7.37 * turn_hz)
                angle_rad = size },
            ),
            Mechanism::ThresholdDrift => push(
                "threshold_drift",
                toml! { angle_rad = size
                tau_s = (0.2 * self.long)
                from_s = (0.25 * self.long) },
            ),
            Mechanism::TimestampJitter => {
                let now = number(rig, "timer.jitter_s").unwrap_or(0.0);
                tree::set(rig, "timer.jitter_s", now.hypot(size));
            }
            Mechanism::CaptureLatency => {
                tree::set(rig, "capture_latency.task_hz", 1000.0);
                tree::set(rig, "capture_latency.busy_s", size);
            }
            Mechanism::LostEdges => {
                let edges = (self.long * self.speed / self.step) as i64;
                let count = size as i64;
                let each = (1..=count).map(|at| Value::Integer(at * edges / (count + 2)));
                tree::set(rig, "faults.lost_edges", Value::Array(each.collect()));
            }
            Mechanism::ExtraEdges => {
                let interval = self.step / self.speed;
                tree::set(
                    rig,
                    "faults.glitch_probability",
                    size * interval / self.long,
                );
                tree::set(rig, "faults.glitch_width_s", 0.1 * interval);
            }
            Mechanism::IndexSlip => push(
                "index_slip",
                toml! { at_s = middle
                edges = (size as i64) },
            ),
            Mechanism::TorqueRipple => push(
                "ripple",
                toml! { order = 7
                torque_n_m = size },
            ),
            Mechanism::GearMesh => push(
                "gear_mesh",
                toml! { order = 9.37
                torque_n_m = size },
            ),
            Mechanism::Bearing => push(
                "bearing",
                toml! { order = 3.57
                runout_rad = size },
            ),
            Mechanism::TorqueTone => push(
                "torque_tone",
                toml! { f_hz = (5.43 * turn_hz)
                torque_n_m = size },
            ),
            Mechanism::TorsionalResonance => {
                tree::set(rig, "torsional_resonance.f_hz", 20.3 * turn_hz);
                tree::set(rig, "torsional_resonance.damping_ratio", 0.02);
                tree::set(rig, "torsional_resonance.inertia_share", size);
            }
            Mechanism::Friction => tree::add(rig, "shaft.coulomb_n_m", size),
            Mechanism::StickSlip => {
                let stiffness = self.inertia * (10.0 * self.speed).powi(2);
                tree::set(rig, "stick_slip.stiffness_n_m_rad", stiffness);
                tree::add(rig, "shaft.coulomb_n_m", 0.2 * stiffness);
                tree::set(rig, "shaft.stribeck_n_m", 0.2 * stiffness);
                tree::set(rig, "shaft.stribeck_rad_s", 0.4 * self.speed);
            }
            Mechanism::LoadStep => push(
                "load_step",
                toml! { torque_n_m = (-size)
                from_s = middle
                until_s = (0.6 * self.long) },
            ),
            Mechanism::SpeedDrift => tree::set(rig, "speed_drift.fraction_per_s", size),
            Mechanism::ClosedLoop => {
                let r_min = number(rig, "drive.constant.r_min").unwrap_or(0.0);
                tree::remove(rig, &tree::path("drive.constant"));
                tree::set(rig, "drive.speed_loop.r_min", r_min);
                let f_hz = (self.speed / self.step / 3.0).min(1000.0);
                tree::set(rig, "drive.speed_loop.f_hz", f_hz);
                tree::set(rig, "drive.speed_loop.bandwidth_hz", f_hz / 50.0);
            }
            Mechanism::Unknown => {}
        }
    }
}

/// The smallest size that a twin can say.
const fn least(mechanism: Mechanism) -> f64 {
    match mechanism {
        Mechanism::TorsionalResonance => 1e-6,
        _ => 0.0,
    }
}

/// The twin as a quiet rig: stamps of 3 ns, no torque noise. What sets how stiffly its drive holds the speed stays.
#[must_use]
pub fn quiet(twin: &Table) -> Table {
    let mut quiet = twin.clone();
    if number(twin, "noise.speed_wander.rms_fraction").is_some() {
        tree::set(&mut quiet, "noise.speed_wander.rms_fraction", 1e-12);
    } else {
        quiet.remove("noise");
    }
    tree::set(&mut quiet, "timer.jitter_s", 3e-9);
    tree::set(&mut quiet, "timer.clock_hz", 1_000_000_000_i64);
    quiet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twin() -> Table {
        tree::parse(
            "duration = { turns = 10 }\n[encoder.quadrature]\nlines = 250\nindex = true\n\
             [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-3\n[drive.constant]\nr_min = 300\n\
             [timer]\nclock_hz = 84000000\njitter_s = 1e-6\n",
        )
        .unwrap()
    }

    #[test]
    fn the_detectable_size_has_the_distance_that_counts_as_detectable() {
        for id in [
            Mechanism::Eccentricity,
            Mechanism::GearMesh,
            Mechanism::TimestampJitter,
            Mechanism::EdgeDelay,
        ] {
            let plant = Plant::of(id, &twin()).unwrap();
            let size = plant.detectable(&twin()).unwrap().unwrap();
            let shown = sight::distance(&twin(), &plant.on(&twin(), size)).unwrap();
            assert!((shown / DETECTABLE - 1.0).abs() < 0.15, "{id}: {shown}");
        }
    }

    #[test]
    fn a_play_does_not_show_where_nothing_reverses_and_an_index_that_is_not_there_does_not_slip() {
        let plant = Plant::of(Mechanism::Hysteresis, &twin()).unwrap();
        assert_eq!(plant.detectable(&twin()).unwrap(), None);
        let mut bare = twin();
        tree::set(&mut bare, "encoder.quadrature.index", false);
        assert!(Plant::of(Mechanism::IndexSlip, &bare).is_none());
    }

    #[test]
    fn every_mechanism_on_top_leaves_a_twin() {
        for id in Mechanism::ALL {
            if let Some(plant) = Plant::of(id, &twin()) {
                let size = 1e-3 * plant.facts.first(id, &twin()).max(1e-9);
                let size = if plant.sizing == Sizing::Counted {
                    3.0
                } else {
                    size
                };
                tree::twin(&plant.on(&twin(), size)).unwrap_or_else(|e| panic!("{id}: {e:#}"));
                tree::twin(&plant.on(&quiet(&twin()), size)).unwrap();
            }
        }
    }
}
