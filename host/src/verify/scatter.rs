//! Scatter of intervals around the mean speed of the whole turn about them, which holds no encoder error.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use quadcal::shape::EncoderShape;
use quadcal::units::TurnDelta32;

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

#[derive(Clone, Copy)]
struct Passed {
    edge: u32,
    interval: f64,
    before: f64,
    after: f64,
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

    pub(super) fn push(
        &mut self,
        edge: u32,
        interval: u32,
        before: TurnDelta32,
        after: TurnDelta32,
    ) {
        let turns = |moved: TurnDelta32| f64::from(moved.0).abs() / 4_294_967_296.0;
        let passed = Passed {
            edge,
            interval: f64::from(interval),
            before: turns(before),
            after: turns(after),
        };
        self.window.push_back(passed);
        self.duration += passed.interval;
        if self.window.len() > self.intervals
            && let Some(oldest) = self.window.pop_front()
        {
            self.duration -= oldest.interval;
        }
        if self.window.len() < self.intervals || self.duration <= 0.0 {
            return;
        }
        let middle = self.window[self.intervals / 2];
        if middle.interval <= 0.0 {
            return;
        }
        // Speeds over that of the whole turn, minus one.
        let relative = |moved: f64| moved * self.duration / middle.interval - 1.0;
        let (before, after) = (relative(middle.before), relative(middle.after));
        self.squares[0] += before * before;
        self.squares[1] += after * after;
        self.count += 1;
        let sums = &mut self.sums[middle.edge as usize];
        *sums = [sums[0] + before, sums[1] + after, sums[2] + 1.0];
        if self.profile.turn_angle_rad.len() < self.intervals {
            let speed = |moved: f64| moved * TAU * self.clock_hz / middle.interval;
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
