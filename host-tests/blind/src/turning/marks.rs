//! Marks of the disc and when each is crossed within a step.

use std::f64::consts::TAU;

use crate::encoder::Class;
use crate::rig::Rig;
use crate::step::Step;

/// One mark crossed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Time, s.
    pub time_s: f64,
    /// Speed of the shaft, rad/s.
    pub speed: f64,
    /// Edge through all turns, counted from grid angle 0; for an index mark its own count.
    pub place: i64,
    /// Class of the edge; none for an index mark.
    pub class: Option<Class>,
    /// Whether the shaft moves forward.
    pub forward: bool,
    /// Bit of the channel: 1, 2, 4 for A, B, C or 8 for the index.
    pub bit: u8,
    /// Whether the channel goes high.
    pub high: bool,
    /// White error of its stamp, s.
    pub error_s: f64,
}

/// The motion over a step.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// The step.
    pub step: &'a Step,
    /// Shaft angle at its start, rad.
    pub from_rad: f64,
    /// Time at its start, s.
    pub time_s: f64,
    /// Whether it goes forward.
    pub forward: bool,
    /// How much further along marks lie forward than in reverse, rad.
    pub play: f64,
}

/// Marks of one turn by angle, and which is next.
#[derive(Clone, Debug)]
pub struct Track {
    angles: Vec<f64>,
    marks: Vec<(u8, bool, Option<Class>)>,
    next: i64,
    /// Levels of its channels at the start, as bits.
    pub levels: u8,
}

impl Track {
    /// The edges of a disc.
    #[must_use]
    pub fn edges(rig: &Rig, disc: &[f64]) -> Self {
        let angles = (0..disc.len()).map(|k| rig.grid_rad(k) - disc[k]).collect();
        let mark = |k| {
            let class = rig.encoder.class(k);
            (1 << class.channel, class.rises, Some(class))
        };
        Self::new(angles, (0..disc.len()).map(mark).collect(), rig.start_rad)
    }

    /// The index: high for one grid step around edge 0.
    #[must_use]
    pub fn index(rig: &Rig, disc: &[f64]) -> Self {
        let half = 0.5 * rig.encoder.step_rad();
        let angles = vec![-disc[0] - half, -disc[0] + half];
        Self::new(
            angles,
            vec![(8, true, None), (8, false, None)],
            rig.start_rad,
        )
    }

    fn new(angles: Vec<f64>, marks: Vec<(u8, bool, Option<Class>)>, start: f64) -> Self {
        let mut track = Self {
            angles,
            marks,
            next: 0,
            levels: 0,
        };
        let count = track.marks.len() as i64;
        track.next = ((start / TAU).floor() as i64 - 1) * count;
        while track.angle(track.next) <= start {
            track.next += 1;
        }
        // Every channel has changed once a turn.
        for place in track.next - count..track.next {
            let (bit, rises, _) = track.mark(place);
            track.levels = if rises {
                track.levels | bit
            } else {
                track.levels & !bit
            };
        }
        track
    }

    fn angle(&self, place: i64) -> f64 {
        let count = self.marks.len() as i64;
        let turn = place.div_euclid(count);
        turn as f64 * TAU + self.angles[place.rem_euclid(count) as usize]
    }

    fn mark(&self, place: i64) -> (u8, bool, Option<Class>) {
        self.marks[place.rem_euclid(self.marks.len() as i64) as usize]
    }

    /// Adds every mark crossed. `late` says how much further along a mark of a class lies at a time within the step, at the angle
    /// travelled and speed there.
    pub fn collect(
        &mut self,
        way: &Way<'_>,
        late: &impl Fn(f64, Option<Class>, f64, f64) -> f64,
        crossings: &mut Vec<Crossing>,
    ) {
        let side = if way.forward { 1.0 } else { -1.0 };
        loop {
            let place = if way.forward {
                self.next
            } else {
                self.next - 1
            };
            let (bit, rises, class) = self.mark(place);
            let goal = self.angle(place) - way.from_rad + 0.5 * side * way.play;
            let past = |within: f64| {
                let (travel, speed) = way.step.at(within);
                let over = travel - goal - late(within, class, travel, speed);
                (side * over, side * speed)
            };
            if past(way.step.length_s).0 < 0.0 {
                return;
            }
            let within = root(past, way.step.length_s);
            crossings.push(Crossing {
                time_s: way.time_s + within,
                speed: way.step.at(within).1,
                place,
                class,
                forward: way.forward,
                bit,
                high: rises == way.forward,
                error_s: 0.0,
            });
            self.next += if way.forward { 1 } else { -1 };
        }
    }
}

/// Where a value passes zero upward between 0 and `end`, by Newton's steps held within a bracket; 0 where it is past already.
fn root(past: impl Fn(f64) -> (f64, f64), end: f64) -> f64 {
    let (start_value, _) = past(0.0);
    if start_value >= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, end);
    let (end_value, _) = past(end);
    let mut at = end * (start_value / (start_value - end_value));
    for _ in 0..60 {
        let (value, slope) = past(at);
        if value < 0.0 {
            low = at;
        } else {
            high = at;
        }
        let newton = at - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - at).abs() <= 1e-16 * end || high - low <= 1e-16 * end {
            return next;
        }
        at = next;
    }
    at
}
