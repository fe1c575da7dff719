//! Effects: what the recording has and the twin has not. Angles in rad, times in s, torques in N m.

mod angle;
mod cell;
mod names;
mod scale;
#[cfg(test)]
mod tests;
mod torque;

pub use angle::Place;
pub use cell::{Carrier, Cell, Growth, Site};

/// One effect. Each names itself by [`Effect::id`]; those that no catalogue has give `unknown`.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Disc centre off the axis: e(k) = amplitude sin(grid - phase).
    Eccentricity {
        /// Amplitude.
        amplitude_rad: f64,
        /// Phase.
        phase_rad: f64,
    },
    /// Tilted or oval disc: e(k) = amplitude sin(2 grid - phase).
    DiscTilt {
        /// Amplitude.
        amplitude_rad: f64,
        /// Phase.
        phase_rad: f64,
    },
    /// Dirt or a scratch: a Gaussian bump of e(k).
    LocalDefect {
        /// Its middle on the disc.
        angle_rad: f64,
        /// Its standard deviation.
        width_rad: f64,
        /// Its peak.
        error_rad: f64,
        /// The one channel it touches; all where none.
        channel: Option<usize>,
        /// Whether rises only or falls only; both where none.
        rises: Option<bool>,
    },
    /// Pattern of the lines, normal and white.
    LineError {
        /// RMS.
        rms_rad: f64,
        /// Seed of the pattern.
        seed: u64,
    },
    /// Falls early by this, one size for each channel.
    WidthError {
        /// xi of A, B and C.
        rad: [f64; 3],
    },
    /// Both edges of B early.
    QuadratureError {
        /// p.
        rad: f64,
    },
    /// Rises and falls arrive late by different times.
    EdgeDelay {
        /// Delay of a rise of A, B and C.
        rise_s: [f64; 3],
        /// Delay of a fall of A, B and C.
        fall_s: [f64; 3],
    },
    /// Channels arrive late by different times.
    ChannelSkew {
        /// Delay of both edges of A, B and C.
        channel_s: [f64; 3],
    },
    /// Pick-up on the comparator's level: rises late and falls early by angle sin(2 pi f t + phase).
    ThresholdRipple {
        /// Frequency.
        f_hz: f64,
        /// Phase.
        phase_rad: f64,
        /// Amplitude.
        angle_rad: f64,
        /// The one channel it touches; all where none.
        channel: Option<usize>,
    },
    /// Drift of the level: rises late and falls early by angle (1 - exp(-(t - from) / tau)).
    ThresholdDrift {
        /// Final size.
        angle_rad: f64,
        /// Time constant.
        tau_s: f64,
        /// When it begins.
        from_s: f64,
    },
    /// Torque at an integer order: torque sin(order theta + phase).
    TorqueRipple(crate::rig::Order),
    /// The same at the order of a gear, no integer.
    GearMesh(crate::rig::Order),
    /// The same at an order tied to nothing declared.
    BearingTorque(crate::rig::Order),
    /// Run-out at such an order: an error of the angle that does not repeat each turn.
    BearingRunout {
        /// Cycles a turn.
        order: f64,
        /// Phase.
        phase_rad: f64,
        /// Amplitude.
        runout_rad: f64,
    },
    /// Torque sin(2 pi f t + phase).
    TorqueTone {
        /// Frequency.
        f_hz: f64,
        /// Phase.
        phase_rad: f64,
        /// Amplitude.
        torque_n_m: f64,
    },
    /// A torque that comes and goes.
    LoadStep {
        /// The torque; a brake is negative.
        torque_n_m: f64,
        /// When it comes.
        from_s: f64,
        /// When it goes.
        until_s: f64,
    },
    /// Speed asked for changes as 1 + fraction t.
    SpeedDrift {
        /// Fraction a second.
        fraction_per_s: f64,
    },
    /// Friction that the twin has not.
    Friction {
        /// Coulomb torque.
        coulomb_n_m: f64,
        /// Torque a rad/s.
        viscous_n_m_s: f64,
        /// Torque a (rad/s)^2.
        drag_n_m_s2: f64,
        /// Stribeck torque, that falls as exp(-(w / scale)^2).
        stribeck_n_m: f64,
        /// Its scale, rad/s.
        stribeck_rad_s: f64,
    },
    /// The drive pulls through a spring whose far end goes at the speed asked for, against friction that falls with speed.
    StickSlip {
        /// Stiffness of the spring, N m/rad.
        stiffness_n_m_rad: f64,
        /// Coulomb torque.
        coulomb_n_m: f64,
        /// Stribeck torque on top at standstill.
        stribeck_n_m: f64,
        /// Its scale, rad/s.
        stribeck_rad_s: f64,
    },
    /// Lightly damped mode: a share of the inertia sits behind a spring.
    TorsionalResonance {
        /// Frequency of the free, undamped mode.
        f_hz: f64,
        /// Damping ratio.
        damping_ratio: f64,
        /// Share of the inertia that is on the far side.
        inertia_share: f64,
    },
    /// White time noise of the stamps, on top of what the twin has.
    TimestampJitter {
        /// RMS.
        jitter_s: f64,
    },
    /// One-sided exponential latency of every stamp.
    CaptureLatency {
        /// Mean.
        mean_s: f64,
    },
    /// A task that blocks captures: what falls into its time is stamped at its end.
    CaptureTask {
        /// Times a second.
        task_hz: f64,
        /// How long each blocks.
        busy_s: f64,
        /// When the first begins.
        phase_s: f64,
    },
    /// Edges whose capture is lost.
    LostEdges {
        /// How many.
        count: u32,
        /// Seed of their places.
        seed: u64,
    },
    /// Glitches: a channel changes and changes back.
    ExtraEdges {
        /// How many glitches; each makes two edges.
        count: u32,
        /// Seed of their places.
        seed: u64,
    },
    /// The index moves against the disc.
    IndexSlip {
        /// When.
        at_s: f64,
        /// Grid edges it moves along the disc.
        edges: i32,
    },
    /// Every edge is late by half of this in its direction of motion.
    Hysteresis {
        /// Width.
        angle_rad: f64,
    },
    /// The disc follows the shaft through a play.
    Backlash {
        /// Play.
        gap_rad: f64,
    },
    /// The drive is a speed loop where the twin holds the speed asked for.
    ClosedLoop {
        /// Proportional gain, N m s.
        kp_n_m_s: f64,
        /// Integral gain, N m.
        ki_n_m: f64,
        /// Samples a second.
        f_hz: f64,
    },
    /// No catalogue: eccentricity by whirl, amplitude and phase change with speed.
    Whirl {
        /// Amplitude at the critical speed.
        amplitude_rad: f64,
        /// Phase well below it.
        phase_rad: f64,
        /// Critical speed, rad/s.
        critical_rad_s: f64,
        /// Damping ratio of the whirl.
        damping_ratio: f64,
    },
    /// No catalogue: torque whose frequency sweeps with time.
    Chirp {
        /// Frequency at time 0.
        f_hz: f64,
        /// Hz a second.
        rate_hz_s: f64,
        /// Amplitude.
        torque_n_m: f64,
    },
    /// No catalogue: torque whose order sweeps with angle.
    OrderChirp {
        /// Order at angle 0.
        order: f64,
        /// Change of order a rad.
        rate_per_rad: f64,
        /// Amplitude.
        torque_n_m: f64,
    },
    /// No catalogue: a non-integer order whose amplitude swings ever faster.
    ModulatedOrder {
        /// Carrier's order.
        order: f64,
        /// Modulation at time 0.
        f_hz: f64,
        /// Hz a second.
        rate_hz_s: f64,
        /// Amplitude.
        torque_n_m: f64,
    },
    /// No catalogue: all edges noisy in bursts that come at random.
    BurstNoise {
        /// RMS within a burst.
        angle_rad: f64,
        /// Share of the time.
        share: f64,
        /// Bursts a second.
        rate_hz: f64,
        /// Seed.
        seed: u64,
    },
    /// No catalogue: the level jumps between two values at random.
    Telegraph {
        /// Half the jump.
        angle_rad: f64,
        /// Jumps a second.
        rate_hz: f64,
        /// Seed.
        seed: u64,
    },
    /// No catalogue: the disc creeps on its shaft with angle and snaps back at random.
    Creep {
        /// Creep a turn.
        per_turn_rad: f64,
        /// Snaps a turn.
        snaps: f64,
        /// Seed.
        seed: u64,
    },
    /// No catalogue: put together of site, carrier and growth.
    Cell(Cell),
}
