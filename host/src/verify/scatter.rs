//! Scatter of intervals around the mean speed of the whole turn about them, which holds no encoder error.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use quadcal::corrector::CorrectedEdge;
use quadcal::shape::EncoderShape;
use quadcal::units::TICK_FRACTION_BITS;

/// Relative scatter of the speed from edge to edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Intervals looked at.
    pub intervals: u64,
    /// RMS of (speed / mean speed of the turn around - 1) on the grid.
    pub before: f64,
    /// The same on corrected angles.
    pub after: f64,
}

/// Speeds for plots.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// Mean relative speed error at every edge before correction.
    pub mean_before: Vec<f64>,
    /// The same after correction.
    pub mean_after: Vec<f64>,
    /// Angle of the edges of one turn, rad.
    pub turn_angle_rad: Vec<f64>,
    /// Speed at them before correction, rad/s.
    pub turn_before_rad_s: Vec<f64>,
    /// Speed at them after correction, rad/s.
    pub turn_after_rad_s: Vec<f64>,
}

/// An interval, as captured on the grid and as the table has it.
#[derive(Clone, Copy)]
struct Passed {
    edge: u32,
    before: Motion,
    after: Motion,
}

/// A way, turns, in a time, ticks.
#[derive(Clone, Copy)]
struct Motion {
    way: f64,
    time: f64,
}

impl Motion {
    #[allow(clippy::cast_precision_loss)]
    fn of(edge: &CorrectedEdge) -> Self {
        Self {
            way: f64::from(edge.moved.0).abs() / 4_294_967_296.0,
            time: edge.interval_q8() as f64 / f64::from(1_u32 << TICK_FRACTION_BITS),
        }
    }

    fn speed(self) -> f64 {
        self.way / self.time
    }
}

/// Takes intervals one by one and holds each against the turn around it.
pub(super) struct ScatterMeter {
    edges: usize,
    /// Intervals in a turn: edges that there are.
    intervals: usize,
    clock_hz: f64,
    window: VecDeque<Passed>,
    duration: f64,
    squares: [f64; 2],
    count: u64,
    sums: Vec<[f64; 3]>,
    profile: Profile,
}

impl ScatterMeter {
    #[allow(clippy::cast_precision_loss)]
    pub(super) fn new(shape: EncoderShape, gap_edges: u32, clock_hz: u64) -> Self {
        let edges = shape.edges() as usize;
        Self {
            edges,
            intervals: shape.edges().saturating_sub(gap_edges).max(1) as usize,
            clock_hz: clock_hz as f64,
            window: VecDeque::with_capacity(edges + 1),
            duration: 0.0,
            squares: [0.0; 2],
            count: 0,
            sums: vec![[0.0; 3]; edges],
            profile: Profile::default(),
        }
    }

    /// The next interval does not follow the one before.
    pub(super) fn interrupt(&mut self) {
        self.window.clear();
        self.duration = 0.0;
    }

    pub(super) fn push(&mut self, edge: u32, before: &CorrectedEdge, after: &CorrectedEdge) {
        let passed = Passed {
            edge,
            before: Motion::of(before),
            after: Motion::of(after),
        };
        self.window.push_back(passed);
        // Delays and errors of the edges drop out of a whole turn.
        self.duration += passed.before.time;
        if self.window.len() > self.intervals
            && let Some(oldest) = self.window.pop_front()
        {
            self.duration -= oldest.before.time;
        }
        if self.window.len() < self.intervals || self.duration <= 0.0 {
            return;
        }
        let middle = self.window[self.intervals / 2];
        if middle.before.time <= 0.0 {
            return;
        }
        // Speeds over that of the whole turn, minus one.
        let relative = |motion: Motion| motion.speed() * self.duration - 1.0;
        let (before, after) = (relative(middle.before), relative(middle.after));
        self.squares[0] += before * before;
        self.squares[1] += after * after;
        self.count += 1;
        let sums = &mut self.sums[middle.edge as usize];
        *sums = [sums[0] + before, sums[1] + after, sums[2] + 1.0];
        if self.profile.turn_angle_rad.len() < self.intervals {
            let speed = |motion: Motion| motion.speed() * TAU * self.clock_hz;
            #[allow(clippy::cast_precision_loss)]
            let angle = f64::from(middle.edge) * TAU / self.edges as f64;
            self.profile.turn_angle_rad.push(angle);
            self.profile.turn_before_rad_s.push(speed(middle.before));
            self.profile.turn_after_rad_s.push(speed(middle.after));
        }
    }

    /// None when not even one whole turn was seen.
    #[allow(clippy::cast_precision_loss)]
    pub(super) fn finish(mut self) -> Option<(Scatter, Profile)> {
        if self.count == 0 {
            return None;
        }
        let rms = |squares: f64| (squares / self.count as f64).sqrt();
        let scatter = Scatter {
            intervals: self.count,
            before: rms(self.squares[0]),
            after: rms(self.squares[1]),
        };
        let mean = |which: usize| {
            self.sums
                .iter()
                .map(|sums| sums[which] / sums[2].max(1.0))
                .collect()
        };
        self.profile.mean_before = mean(0);
        self.profile.mean_after = mean(1);
        Some((scatter, self.profile))
    }
}
