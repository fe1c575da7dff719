//! The residual: what each edge says of the shaft's angle at its time, less the angle that the twin's shaft has then.
//!
//! The twin's course without disturbance is simulated; under a speed loop the shaft goes where the loop sends it, which hangs on every
//! edge that came before. That push is known: the loop saw the recorded edges (the direct method of closed-loop identification,
//! L. Ljung, System Identification, 2nd ed., section 13.4). The twin's torques, delays, levels and play are taken off along the way
//! that the shaft really went: a shaft that lags keeps the ripple's places, and the tone's times.

use std::f64::consts::TAU;

use quadcal::edge::Direction;

use super::basis::Basis;
use super::kalman::Reading;
use super::pushed;
use super::seen::Seen;
use super::shaft::{Leap, ShaftLaw};
use super::still::Still;
use super::swing::{Torques, swing};
use super::ties::Tie;
use super::track::{Mark, Track};
use crate::twin::{Drive, RiseFall, SeenSpeed, SpeedLoop, Twin};

/// The shaft's course at the time of each mark: angle, speed, and the variance of a jolt that nobody knows, rad, rad/s and its square;
/// none where it is not known.
pub(super) type Course = Vec<Option<(f64, f64, f64)>>;

impl Seen {
    /// Compares a recording with its twin.
    pub(super) fn compare(&mut self, track: &Track, twin: &Twin, still: &Still, law: &ShaftLaw) {
        let marks: Vec<(Mark, i64)> = track
            .stretches
            .iter()
            .flat_map(|stretch| stretch.marks.iter().map(|mark| (*mark, stretch.direction)))
            .collect();
        let step = TAU / track.edges as f64;
        let pushed = pushed::course(&marks, track, twin);
        self.pushed = pushed.is_some();
        let course = match (twin.speed_loop(), pushed) {
            (Some(model), _) => {
                let (course, ties) = looped(&marks, track, twin, &model);
                self.ties = ties;
                course
            }
            (None, Some(pushed)) => pushed,
            (None, None) => undisturbed(&marks, still, step),
        };
        let mut before: Option<(Mark, i64)> = None;
        let slow = too_slow(twin, law, &course);
        let mut anew = false;
        // What nothing holds, or something else pushes, goes at its own speed, not at the twin's.
        let measured = if law.held() && !self.pushed {
            Vec::new()
        } else {
            speeds(&marks, track)
        };
        for (at, ((mark, direction), there)) in marks.iter().zip(course).enumerate() {
            let Some((angle, speed, jolt)) = there else {
                continue;
            };
            if speed.abs() < slow {
                anew = true;
                continue;
            }
            let speed = measured.get(at).copied().flatten().unwrap_or(speed);
            // A reversal goes on from the last edge; where the count was lost, nothing does.
            let near = |last: &(Mark, i64)| {
                let apart = (mark.place - last.0.place) * direction;
                last.1 != *direction || (1..=track.classes).contains(&apart)
            };
            let lost = !before.as_ref().is_none_or(near) && !track.anchored;
            // The course starts anew with every push.
            let last = self.readings.last();
            let begins = self.pushed && jolt > 0.0 && last.is_none_or(|last| last.jolt == 0.0);
            let fresh = lost || begins;
            before = Some((*mark, *direction));
            let edge = (mark.place + still.origin - still.shift).rem_euclid(track.edges);
            let edge = usize::try_from(edge).unwrap_or(0);
            let error = still.errors.get(edge).copied().unwrap_or(0.0);
            let after_s = self.times_s.last().map_or(0.0, |last| mark.time_s - last);
            self.places.push(mark.place + still.origin);
            self.times_s.push(mark.time_s);
            self.speeds.push(speed.abs() * *direction as f64);
            self.angles.push(mark.place as f64 * step - angle - error);
            self.readings.push(Reading {
                leap: Leap {
                    after_s,
                    damping: law.damping(mark.time_s, speed.abs()),
                },
                speed: speed.abs(),
                at_s: mark.time_s,
                fresh,
                anew: std::mem::take(&mut anew),
                jolt,
            });
        }
        // The counts of recording and twin may be whole turns apart.
        let turns = (self.angles.first().copied().unwrap_or(0.0) / TAU).round() * TAU;
        self.angles.iter_mut().for_each(|angle| *angle -= turns);
    }

    /// Takes off what the twin's torques do on the disc as it is known now.
    pub(super) fn swing(&mut self) {
        let swings = swing(self, &self.torques);
        let each = swings.iter().zip(&self.swings);
        for (angle, (now, before)) in self.angles.iter_mut().zip(each) {
            *angle -= now - before;
        }
        self.swings = swings;
    }

    /// Takes off what the twin's torques, delays, levels and play do.
    pub(super) fn take_off(&mut self, twin: &Twin, law: &ShaftLaw) {
        self.torques = Torques::of(twin, law);
        self.swings = vec![0.0; self.len()];
        self.swing();
        let looped = twin.speed_loop().is_some();
        for (basis, sizes) in known(twin, looped) {
            for (column, size) in basis.columns(self, law).into_iter().zip(sizes) {
                for (angle, value) in self.angles.iter_mut().zip(column) {
                    *angle -= size * value;
                }
            }
        }
    }
}

/// What a twin has beside disc, shaft, drive, torques and loads, as patterns with sizes.
fn known(twin: &Twin, looped: bool) -> Vec<(Basis, Vec<f64>)> {
    let mut known: Vec<(Basis, Vec<f64>)> = Vec::new();
    // size sin(x + phase)
    let round = |size: f64, phase: f64| vec![size * phase.sin(), size * phase.cos()];
    for bearing in &twin.bearing {
        if let Some(runout) = bearing.runout_rad {
            let order = bearing.order;
            known.push((Basis::Round { order }, round(runout, bearing.phase_rad)));
        }
    }
    // Without a loop the simulated course has felt them.
    for load in twin.load_step.iter().filter(|_| looped) {
        let basis = Basis::Load {
            from_s: load.from_s,
            until_s: load.until_s.unwrap_or(f64::INFINITY),
        };
        known.push((basis, vec![load.torque_n_m]));
    }
    if let Some(ripple) = twin.threshold_ripple {
        let basis = Basis::LevelTone {
            f_hz: ripple.f_hz,
            channel: ripple.channel.map(|channel| channel as usize),
        };
        known.push((basis, round(ripple.angle_rad, ripple.phase_rad)));
    }
    if let Some(drift) = twin.threshold_drift {
        let basis = Basis::LevelDrift {
            from_s: drift.from_s,
            tau_s: drift.tau_s,
        };
        known.push((basis, vec![drift.angle_rad]));
    }
    let delay = twin.edge_delay.unwrap_or_default();
    let skew = twin.channel_skew.unwrap_or_default();
    let channels: [(RiseFall, f64); 3] = [
        (delay.a, skew.a_s),
        (delay.b, skew.b_s),
        (delay.c, skew.c_s),
    ];
    for (channel, (delay, skew)) in channels.into_iter().enumerate() {
        let rise = Basis::RiseLate {
            channel: Some(channel),
        };
        known.push((rise, vec![delay.rise_s - delay.fall_s]));
        known.push((Basis::Late { channel }, vec![delay.fall_s + skew]));
    }
    let play =
        twin.hysteresis.map_or(0.0, |h| h.angle_rad) + twin.backlash.map_or(0.0, |b| b.gap_rad);
    known.push((Basis::Direction, vec![play]));
    known.retain(|(_, sizes)| sizes.iter().any(|size| *size != 0.0));
    known
}

/// Speed below which the twin's ripple shapes the course itself, rad/s: a small swing about it says nothing there. A drive that turns
/// the shaft round against more than the ripple never lets it.
fn too_slow(twin: &Twin, law: &ShaftLaw, course: &Course) -> f64 {
    /// How much more energy the shaft is to have than a ripple can take.
    const OVER: f64 = 25.0;
    /// How much stronger than the drive ripple is to be to hold the shaft for a while.
    const HOLDS: f64 = 4.0;
    /// Part of the top speed that is never too slow.
    const PART: f64 = 0.3;
    let slows = match twin.drive {
        Drive::Ramp {
            from_r_min,
            to_r_min,
            over_s,
        } => (to_r_min - from_r_min).abs() * (TAU / 60.0) / over_s,
        Drive::RunDown { .. } => twin.friction_n_m(0.0).abs() / law.inertia,
        _ => return 0.0,
    };
    let ripples: Vec<(f64, f64)> = twin
        .ripple
        .iter()
        .chain(&twin.gear_mesh)
        .filter_map(|ripple| Some((ripple.order, ripple.torque_n_m?.abs() / law.inertia)))
        .collect();
    if ripples.iter().map(|(_, push)| push).sum::<f64>() < HOLDS * slows {
        return 0.0;
    }
    let thrown: f64 = ripples.iter().map(|(order, push)| push / order).sum();
    let speeds = course.iter().flatten().map(|(_, speed, _)| speed.abs());
    let top = speeds.fold(0.0, f64::max);
    (OVER * thrown).sqrt().min(PART * top)
}

/// The twin's shaft without disturbance, by the cubic through four of its edges.
fn undisturbed(marks: &[(Mark, i64)], still: &Still, step: f64) -> Course {
    let course: Vec<Mark> = still
        .pace
        .iter()
        .flat_map(|s| s.marks.iter().copied())
        .collect();
    let (Some(first), Some(last)) = (course.first(), course.last()) else {
        return vec![None; marks.len()];
    };
    if course.len() < 4 {
        return vec![None; marks.len()];
    }
    let mut near = 0;
    let each = marks.iter().map(|(mark, _)| {
        while near + 4 < course.len() && course[near + 2].time_s < mark.time_s {
            near += 1;
        }
        (first.time_s..=last.time_s)
            .contains(&mark.time_s)
            .then(|| {
                let (place, rate) = through(&course[near..near + 4], mark.time_s);
                (place * step, rate * step, 0.0)
            })
    });
    each.collect()
}

/// Error of a stamp that a tie is reckoned with where a twin does not say, s.
const JITTER_S: f64 = 3e-7;

/// The shaft as a speed loop sends it that saw these edges. The push before the first is not known: a constant one is anyone's guess.
fn looped(
    marks: &[(Mark, i64)],
    track: &Track,
    twin: &Twin,
    model: &SpeedLoop,
) -> (Course, Vec<Tie>) {
    let step = TAU / track.edges as f64;
    let clock_hz = twin.timer.clock_hz as f64;
    let shaft = &twin.shaft;
    let target = model.target_rad_s;
    let friction =
        |speed: f64| twin.friction_n_m(speed.abs()) * speed.signum() / shaft.inertia_kg_m2;
    let mut saw = SeenSpeed::new(clock_hz, step, model.timeout_s, None);
    let Some((first, _)) = marks.first() else {
        return (Course::new(), Vec::new());
    };
    let mut ties = Vec::new();
    let mut state = [first.place as f64 * step, target];
    let mut now = first.time_s;
    let mut sample = (now * model.rate_hz).ceil();
    let (mut integral, mut push) = (model.start, model.start);
    let mut before: Option<i64> = None;
    // What it saw before the first mark is not known: the course begins once it has sampled what is.
    let (mut sampled, mut begun) = (0, false);
    // A sample at the very time of an edge may have seen it or not: either way it pushes a little otherwise.
    let jitter_s = if twin.timer.jitter_s > 0.0 {
        twin.timer.jitter_s
    } else {
        JITTER_S
    };
    let stamp_s = jitter_s.hypot(track.tick_s);
    let tie_s = 5.0 * stamp_s + track.tick_s;
    let (mut last_edge, mut speed_before) = (first.time_s, target);
    let go = |state: [f64; 2], push: f64, after_s: f64| {
        let leap = Leap {
            after_s,
            damping: shaft.viscous_n_m_s / shaft.inertia_kg_m2,
        };
        let push = push - friction(state[1]);
        leap.step(state, [push; 3])
    };
    let each = marks.iter().map(|(mark, direction)| {
        while sample / model.rate_hz < mark.time_s {
            let time = sample / model.rate_hz;
            state = go(state, push, (time - now).max(0.0));
            now = now.max(time);
            let seen = saw.at((time * clock_hz).floor());
            sampled += i32::from(seen.is_some());
            let here = seen.unwrap_or(target);
            let otherwise = if mark.time_s - time < tie_s {
                let next = *direction as f64 * step / (mark.time_s - last_edge).max(track.tick_s);
                Some((next, mark.time_s - time))
            } else if time - last_edge < tie_s {
                Some((speed_before, time - last_edge))
            } else {
                None
            };
            if let Some((other, apart_s)) = otherwise.filter(|_| begun) {
                ties.push(Tie {
                    at_s: time,
                    until_s: time + 1.0 / model.rate_hz,
                    apart: apart_s / stamp_s,
                    push: model.gains.kp * (here - other),
                    after: model.gains.ki / model.rate_hz * (here - other),
                });
            }
            let miss = target - seen.unwrap_or(target);
            let asked = model.gains.kp * miss + integral;
            push = asked.clamp(-model.limit, model.limit);
            if push == asked || miss * asked < 0.0 {
                integral += model.gains.ki / model.rate_hz * miss;
            }
            sample += 1.0;
        }
        state = go(state, push, mark.time_s - now);
        now = mark.time_s;
        let steps = before.map_or(1, |place| (mark.place - place).abs().max(1));
        before = Some(mark.place);
        let way = if *direction > 0 {
            Direction::Forward
        } else {
            Direction::Reverse
        };
        let ticks = (mark.time_s / track.tick_s).round() as u64;
        speed_before = saw.at(ticks as f64).unwrap_or(target);
        saw.edge(ticks, way, u32::try_from(steps).unwrap_or(1));
        last_edge = mark.time_s;
        if !begun && sampled < 2 {
            return None;
        }
        if !begun {
            begun = true;
            state = [mark.place as f64 * step, target];
        }
        Some((state[0], target, 0.0))
    });
    let course = each.collect();
    (course, ties)
}

/// Speed at each mark over about a turn, in which the disc's errors cancel, or over some lines of a fine disc, rad/s; over a few
/// edges where the direction does not hold for so long.
pub(super) fn speeds(marks: &[(Mark, i64)], track: &Track) -> Vec<Option<f64>> {
    const FINE: i64 = 240;
    let step = TAU / track.edges as f64;
    let lines = track.edges / track.classes;
    let window = if track.edges <= FINE {
        track.edges
    } else {
        track.classes * (lines / 60).max(1)
    };
    let half = (window / 2).max(1) as usize;
    (0..marks.len())
        .map(|at| {
            let from = at.saturating_sub(half);
            let until = (at + half).min(marks.len() - 1);
            let way = (marks[until].0.place - marks[from].0.place) as f64 * step;
            let time = marks[until].0.time_s - marks[from].0.time_s;
            let straight = way.abs() > 0.9 * (until - from) as f64 * step && until > from;
            if straight && time > 0.0 {
                return Some(way / time);
            }
            // Where it turns round, as far as it gets in a few edges.
            let few = &marks[at.saturating_sub(2)..(at + 3).min(marks.len())];
            let places = few.iter().map(|(mark, _)| mark.place);
            let way = places.clone().max()? - places.min()?;
            let time = few.last()?.0.time_s - few.first()?.0.time_s;
            (time > 0.0 && way > 0).then(|| way as f64 * step / time)
        })
        .collect()
}

/// Place and its rate at a time, by the cubic through four edges.
fn through(marks: &[Mark], time_s: f64) -> (f64, f64) {
    let (mut place, mut rate) = (0.0, 0.0);
    for (i, mark) in marks.iter().enumerate() {
        let others: Vec<f64> = (0..marks.len())
            .filter(|j| *j != i)
            .map(|j| marks[j].time_s)
            .collect();
        let below: f64 = others.iter().map(|t| mark.time_s - t).product();
        let value = mark.place as f64 / below;
        let away: Vec<f64> = others.iter().map(|t| time_s - t).collect();
        place += value * away[0] * away[1] * away[2];
        rate += value * (away[0] * away[1] + away[0] * away[2] + away[1] * away[2]);
    }
    (place, rate)
}
