//! What a twin says of each edge: the angle by which it is off the grid, and the shaft's answer to everything that pushes it.

use std::f64::consts::TAU;

use super::course::Course;
use super::effect::{Carrier, Effect, On, Scene, Site, along_time};
use super::lsq::add;
use super::plant::{Here, Jolt, Law, Motion, Plant, Swing, sign};
use super::record::Record;
use super::speed_loop::{self, Unsaid};
use crate::twin::{Channel, Drive, Twin};

/// What a twin says of a recording.
#[derive(Clone, Debug)]
pub struct Declared {
    /// Disc, level, play and delays: the grid angle of each edge less the shaft's at its time, rad.
    pub off: Vec<f64>,
    /// What drive, torques and friction do to angle and speed, less a straight way.
    pub response: Vec<Motion>,
}

/// A twin's effects that are sums of cells, each with its sizes.
pub fn effects(twin: &Twin) -> Vec<(Effect, Vec<f64>)> {
    let swing = Swing::of(twin);
    let wave = |amplitude: f64, phase: f64| vec![amplitude * phase.sin(), amplitude * phase.cos()];
    let on = |channel: Option<Channel>| On {
        channel: channel.map(|channel| channel as u8),
        rises: None,
    };
    let mut all = Vec::new();
    let mut add = |site, carrier, sizes| all.push((Effect::new(site, carrier), sizes));
    let torque = |turning: f64, torque: Option<f64>, fraction: Option<f64>, phase: f64| {
        wave(swing.torque(turning, torque, fraction), phase)
    };
    for one in twin.ripple.iter().chain(&twin.gear_mesh) {
        let turning = one.order * swing.nominal;
        let sizes = torque(turning, one.torque_n_m, one.speed_fraction, one.phase_rad);
        add(Site::Torque, Carrier::Order(one.order), sizes);
    }
    for one in &twin.bearing {
        let turning = one.order * swing.nominal;
        let pushed = || torque(turning, one.torque_n_m, one.speed_fraction, one.phase_rad);
        let (site, sizes) = match one.runout_rad {
            Some(runout) => (Site::Disc(On::ALL), wave(runout, one.phase_rad)),
            None => (Site::Torque, pushed()),
        };
        add(site, Carrier::Order(one.order), sizes);
    }
    for one in &twin.torque_tone {
        let turning = TAU * one.f_hz;
        let sizes = torque(turning, one.torque_n_m, one.speed_fraction, one.phase_rad);
        add(Site::Torque, Carrier::Tone(one.f_hz), sizes);
    }
    for one in &twin.load_step {
        let carrier = Carrier::Window(one.from_s, one.until_s.unwrap_or(f64::INFINITY));
        add(Site::Torque, carrier, vec![one.torque_n_m]);
    }
    for one in &twin.threshold_ripple {
        let sizes = wave(one.angle_rad, one.phase_rad);
        add(Site::Level(on(one.channel)), Carrier::Tone(one.f_hz), sizes);
    }
    for one in &twin.threshold_drift {
        let carrier = Carrier::Settling(one.from_s, one.tau_s);
        add(Site::Level(on(one.channel)), carrier, vec![one.angle_rad]);
    }
    if let Some(play) = &twin.hysteresis {
        let site = Site::Disc(on(play.channel));
        add(site, Carrier::Direction, vec![play.angle_rad]);
    }
    if let Some(play) = &twin.backlash {
        add(Site::Disc(On::ALL), Carrier::Direction, vec![play.gap_rad]);
    }
    let delays = twin.edge_delay.unwrap_or_default();
    let skew = twin.channel_skew.unwrap_or_default();
    let delays = [delays.a, delays.b, delays.c];
    let each = (0..).zip(delays).zip([skew.a_s, skew.b_s, skew.c_s]);
    for ((channel, delay), skew_s) in each {
        for (rises, delay_s) in [(true, delay.rise_s), (false, delay.fall_s)] {
            let on = On {
                channel: Some(channel),
                rises: Some(rises),
            };
            if delay_s + skew_s != 0.0 {
                add(Site::Stamp(on), Carrier::Steady, vec![delay_s + skew_s]);
            }
        }
    }
    let drift = twin.speed_drift.unwrap_or_default();
    if let Some(rate) = drift.fraction_per_s {
        add(Site::Drive, Carrier::Time, vec![rate]);
    } else if let (Some(fraction), Some(tau_s)) = (drift.fraction, drift.tau_s) {
        add(Site::Drive, Carrier::Settling(0.0, tau_s), vec![fraction]);
    }
    // What is part of the disc is in its errors.
    let others = twin.effect.iter().map(|one| (one.effect(), one.sizes()));
    all.extend(others.filter(|(effect, _)| !effect.is_of_disc()));
    all
}

/// Speed that a twin's drive asks for along time: straight between points, and what it drifts by.
#[derive(Clone, Debug)]
pub struct Asked {
    points: Vec<(f64, f64)>,
    drift: Vec<(Effect, f64)>,
    /// Whether the drive gives what following it takes, friction included: a speed loop does not.
    follows: bool,
}

impl Asked {
    /// Of a twin.
    pub fn of(twin: &Twin) -> Self {
        let rad_s = |r_min: f64| r_min * (TAU / 60.0);
        let points = match &twin.drive {
            Drive::Unknown | Drive::Torque(_) => Vec::new(),
            Drive::Profile(profile) => {
                let each = profile.points().iter();
                each.map(|point| (point.t_s, rad_s(point.r_min))).collect()
            }
            Drive::Constant { r_min }
            | Drive::RunDown { r_min, .. }
            | Drive::SpeedLoop { r_min, .. } => vec![(0.0, rad_s(*r_min))],
            Drive::Ramp {
                from_r_min,
                to_r_min,
                over_s,
            } => vec![(0.0, rad_s(*from_r_min)), (*over_s, rad_s(*to_r_min))],
            Drive::Steps(steps) => {
                let mut points: Vec<(f64, f64)> = Vec::new();
                for step in steps {
                    let before = points.last().map(|(_, before)| (step.t_s, *before));
                    points.extend(before);
                    let from_s = before.map_or(0.0, |_| step.t_s);
                    points.push((from_s, rad_s(step.r_min)));
                }
                points
            }
        };
        let all = effects(twin).into_iter();
        let drift = all.filter(|(effect, _)| effect.site == Site::Drive);
        Self {
            points,
            drift: drift.map(|(effect, sizes)| (effect, sizes[0])).collect(),
            follows: twin.speed_loop().is_none(),
        }
    }

    /// What friction is balanced at: the speed that an open-loop drive asks for, no motion where there is none.
    pub fn here(&self, here: Here) -> Here {
        let (speed, rate) = match self.follows {
            true => self.at(here.time_s, here.inside_s),
            false => (0.0, 0.0),
        };
        let way = sign(if speed == 0.0 { rate } else { speed });
        Here { speed, way, ..here }
    }

    /// Instants at which what friction is balanced at jumps, s.
    pub fn breaks_s(&self) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.points.iter().map(|(time_s, _)| *time_s).collect();
        for pair in self.points.windows(2) {
            let ((from_s, one), (until_s, other)) = (pair[0], pair[1]);
            if one * other < 0.0 {
                breaks.push(from_s + (until_s - from_s) * one / (one - other));
            }
        }
        breaks
    }

    /// Speed at a time, rad/s, and its rate, rad/s^2; `inside_s` says on which side of a jump.
    pub fn at(&self, time_s: f64, inside_s: f64) -> (f64, f64) {
        let next = self.points.partition_point(|(t, _)| *t <= inside_s);
        let before = next.checked_sub(1).map(|at| self.points[at]);
        let (speed, rate) = match (before, self.points.get(next).copied()) {
            (None, Some((_, speed))) | (Some((_, speed)), None) => (speed, 0.0),
            (Some((from, one)), Some((until, other))) => {
                let rate = (other - one) / (until - from);
                (one + rate * (time_s - from), rate)
            }
            (None, None) => (0.0, 0.0),
        };
        let here = along_time(Here {
            time_s,
            inside_s,
            angle: 0.0,
            speed,
            way: sign(speed),
        });
        let drift = self.drift.iter().map(|(effect, size)| {
            let [one, _] = effect.value(here);
            (size * one.at, size * one.slope)
        });
        let (by, slope) = drift.fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
        (speed * (1.0 + by), rate * (1.0 + by) + speed * slope)
    }
}

impl Declared {
    /// Whether anything that the twin says moves the shaft.
    pub fn is_pushed(&self) -> bool {
        let mut each = self.response.iter();
        each.any(|[angle, _]| *angle != 0.0)
    }

    /// What a twin says of a recording; `looped` is the speed loop of a drive that it does not declare, `disc` its errors.
    pub fn new(
        record: &Record,
        twin: &Twin,
        looped: Option<&Unsaid>,
        disc: &[f64],
        course: &Course,
        plant: &Plant,
    ) -> Self {
        let asked = Asked::of(twin);
        let scene = Scene {
            record,
            disc,
            course,
            plant,
            asked: &asked,
        };
        let mut off = record.shown(disc);
        let mut response = drive(twin, looped, &scene);
        for (effect, sizes) in effects(twin) {
            match effect.site {
                Site::Drive => {}
                Site::Torque => push(&mut response, &scene, &effect, &sizes),
                _ => {
                    for (column, size) in effect.columns(&scene).iter().zip(&sizes) {
                        add(&mut off, *size, column);
                    }
                }
            }
        }
        let mean_s = mean_late_s(twin);
        add(&mut off, -mean_s, &course.speed);
        Self { off, response }
    }

    /// What drive, torques and friction do to the angle, rad, less a straight way.
    pub fn angles(&self) -> Vec<f64> {
        self.response.iter().map(|[angle, _]| *angle).collect()
    }
}

/// Adds what a torque makes of angle and speed at each edge.
pub fn push(into: &mut [Motion], scene: &Scene<'_>, effect: &Effect, sizes: &[f64]) {
    for (motions, size) in effect.motions(scene).iter().zip(sizes) {
        for (into, by) in into.iter_mut().zip(motions) {
            add(into, *size, by);
        }
    }
}

/// How late each stamp is by the delays that a twin declares, s.
pub fn late_s(twin: &Twin, record: &Record) -> Vec<f64> {
    let mut late = vec![mean_late_s(twin); record.len()];
    for (effect, sizes) in effects(twin) {
        if let Site::Stamp(on) = effect.site {
            for (at, late) in late.iter_mut().enumerate() {
                if on.has(record.captured(at)) {
                    *late += sizes[0];
                }
            }
        }
    }
    late
}

/// Mean of a declared latency of every capture, s.
fn mean_late_s(twin: &Twin) -> f64 {
    let latency = twin.capture_latency;
    latency.and_then(|latency| latency.mean_s).unwrap_or(0.0)
}

/// Way from a standstill within which ripples that nobody has found yet may hold a shaft that an unknown drive turns, rad, and their order:
/// some times what takes a motor through a standstill.
const NEAR: f64 = TAU;
const MOTOR: f64 = 6.0;

/// Part of the speed by which it changes over an interval from which on its course within is in doubt, and part of a torque that is open
/// there, and by which that has to change for the course to be worked out anew.
pub const OPEN: f64 = 0.3;

/// Order of a torque that goes with the angle, and its size as an acceleration, rad/s^2.
pub fn wave(effect: &Effect, sizes: &[f64], law: &Law) -> Option<(f64, f64)> {
    match (effect.site, effect.carrier) {
        (Site::Torque, Carrier::Order(order)) => {
            Some((order, sizes[0].hypot(sizes[1]) / law.inertia))
        }
        _ => None,
    }
}

/// Changes of angle and speed that the size of waves leaves open where the course within an interval is not known: at a reversal, and
/// wherever the speed changes much from edge to edge.
pub fn jolts(waves: &[(f64, f64)], course: &Course, plant: &Plant) -> Vec<Jolt> {
    let law = &plant.law;
    let slow = law.undriven.then(|| near_standstills(course));
    let mut jolts = Vec::new();
    for at in 1..course.len() {
        let (v0, v1) = (course.speed[at - 1], course.speed[at]);
        let h = course.time_s[at] - course.time_s[at - 1];
        let top = v0.abs().max(v1.abs());
        // What an unknown drive does where ripples may hold the shaft is not linear in the speed, as far as edges do not show it: what a
        // speed between two edges misses of a wave.
        let missed = |order: f64| ((order * course.span).powi(2) / 6.0).min(1.0);
        let unknown = |each: fn(f64, f64) -> f64| -> f64 {
            let each = waves
                .iter()
                .map(|(order, size)| each(*order, *size) * missed(*order));
            each.sum()
        };
        let held = law.undriven && 0.5 * top.powi(2) < unknown(|order, size| 2.0 * size / order);
        let slow = slow.as_ref().is_some_and(|slow| slow[at]);
        if held || slow {
            let part = |open: bool| f64::from(u8::from(open));
            let known = part(held) * OPEN * unknown(|_, size| size) * h;
            let unseen = part(slow) * missed(MOTOR) * top;
            jolts.push(Jolt {
                at,
                known: [0.5 * known * h, known],
                unseen,
            });
            continue;
        }
        if (v1 - v0).abs() < OPEN * top {
            continue;
        }
        // How far a cubic and a straight way differ.
        let apart = (v1 - v0).abs() * h / 12.0;
        let waves: f64 = waves
            .iter()
            .map(|(order, size)| size * (order * apart).min(1.0))
            .sum();
        let friction = if v0 * v1 < 0.0 {
            OPEN * law.friction(0.5 * (v0.abs() + v1.abs())).0
        } else {
            0.0
        };
        if waves + friction > 0.0 {
            let still_s = course.reversals_s.iter().find(|still_s| {
                **still_s >= course.time_s[at - 1] && **still_s <= course.time_s[at]
            });
            let left_s = still_s.map_or(0.5 * h, |still_s| course.time_s[at] - still_s);
            let jolt = (waves + friction) * h;
            jolts.push(Jolt {
                at,
                known: [jolt * left_s, jolt],
                unseen: 0.0,
            });
        }
    }
    jolts
}

/// Intervals near a standstill, where a ripple that nobody has found yet may hold the shaft.
fn near_standstills(course: &Course) -> Vec<bool> {
    let mut near = vec![false; course.len()];
    let mut walk = |each: &mut dyn Iterator<Item = usize>| {
        let mut way = f64::INFINITY;
        for at in each {
            way += (course.angle[at] - course.angle[at - 1]).abs();
            let (v0, v1) = (course.speed[at - 1], course.speed[at]);
            if v0 * v1 < 0.0 || v0.abs().min(v1.abs()) < OPEN * v0.abs().max(v1.abs()) {
                way = 0.0;
            }
            near[at] |= way < NEAR;
        }
    };
    walk(&mut (1..course.len()));
    walk(&mut (1..course.len()).rev());
    near
}

/// What drive and friction do to angle and speed.
fn drive(twin: &Twin, looped: Option<&Unsaid>, scene: &Scene<'_>) -> Vec<Motion> {
    if let Some(looped) = twin.speed_loop() {
        let samples = speed_loop::along(&looped, scene.record, twin, 0.0).push;
        return sampled(looped.rate_hz, &samples, scene);
    }
    if let Some(looped) = looped {
        return sampled(looped.own.rate_hz, &looped.push(looped.own.gains), scene);
    }
    if twin.drive == Drive::Unknown {
        return vec![Motion::default(); scene.record.len()];
    }
    let law = &scene.plant.law;
    let torque = match &twin.drive {
        Drive::Torque(torque) => Some(Asked {
            points: torque
                .points()
                .iter()
                .map(|point| (point.t_s, point.torque_n_m / law.inertia))
                .collect(),
            drift: Vec::new(),
            follows: false,
        }),
        _ => None,
    };
    let points = &torque.as_ref().unwrap_or(scene.asked).points;
    let mut breaks: Vec<f64> = points.iter().map(|(time_s, _)| *time_s).collect();
    breaks.push(law.off_s);
    breaks.retain(|time_s| *time_s > 0.0 && time_s.is_finite());
    breaks.extend(&scene.course.reversals_s);
    breaks.sort_by(f64::total_cmp);
    let push = |here: Here| {
        let friction = scene.plant.friction(scene.course, here);
        if let Some(torque) = &torque {
            return [torque.at(here.time_s, here.inside_s).0 + friction];
        }
        if here.inside_s >= law.off_s {
            return [friction];
        }
        let (asked, rate) = scene.asked.at(here.time_s, here.inside_s);
        let towards = sign(if asked == 0.0 { rate } else { asked });
        // It balances friction at the speed asked for.
        let against = law.friction(asked).0 * towards;
        [friction + (rate + (law.viscous + law.stiffness) * asked + against)]
    };
    pushed(scene, push, &breaks)
}

/// What friction, and accelerations that are held from sample to sample, do to angle and speed.
pub fn sampled(rate_hz: f64, samples: &[f64], scene: &Scene<'_>) -> Vec<Motion> {
    let until = scene.course.time_s.last().copied().unwrap_or(0.0);
    let samples_s = (1..).map(|k| f64::from(k) / rate_hz);
    let mut breaks: Vec<f64> = samples_s.take_while(|t| *t <= until).collect();
    breaks.extend(&scene.course.reversals_s);
    breaks.sort_by(f64::total_cmp);
    let push = |here: Here| {
        let at = (here.inside_s * rate_hz).floor().max(0.0) as usize;
        let given = samples.get(at).or(samples.last()).unwrap_or(&0.0);
        [given + scene.plant.friction(scene.course, here)]
    };
    pushed(scene, push, &breaks)
}

/// What an acceleration makes of angle and speed.
fn pushed(scene: &Scene<'_>, push: impl Fn(Here) -> [f64; 1], breaks: &[f64]) -> Vec<Motion> {
    let all = 0..scene.record.len();
    let [motions] = scene
        .plant
        .responses(all, scene.course, false, push, |_| 0.0, breaks);
    motions
}
