//! Which recording tells a mechanism from its look-alikes.

use super::Mechanism;

impl Mechanism {
    /// The recording to make next: what to change and what then shows. One or two sentences.
    #[must_use]
    pub const fn separated_by(self) -> &'static str {
        match self {
            Self::LineError => {
                "Two recordings at speeds a factor of two apart: line errors keep their size in angle, torque ripple falls with the \
                 square of the speed."
            }
            Self::WidthError => {
                "Two recordings at speeds a factor of two apart: a width error keeps its size in angle, unequal delays of rise and \
                 fall grow with the speed."
            }
            Self::QuadratureError => {
                "Two recordings at speeds a factor of two apart: a quadrature error keeps its size in angle, unequal delays of the \
                 channels grow with the speed."
            }
            Self::Eccentricity => {
                "Two recordings at speeds a factor of two apart, in torque or voltage mode: eccentricity keeps its size in angle, torque \
                 at order 1 (imbalance) falls with the square of the speed."
            }
            Self::DiscTilt => {
                "Two recordings at speeds a factor of two apart, in torque or voltage mode: a tilted disc keeps its size in angle, torque \
                 at order 2 falls with the square of the speed."
            }
            Self::LocalDefect => {
                "A longer recording, ten turns or more: a defect stays at its angle every turn, lost or extra edges do not come back."
            }
            Self::Hysteresis => {
                "The same reversals with a constant torque on the disc's side that keeps any play to one flank: backlash goes, hysteresis \
                 of the head stays. It is below half a line, and a channel may have its own."
            }
            Self::EdgeDelay => {
                "Two recordings at speeds a factor of two apart: unequal delays of rise and fall grow with the speed, width errors do not."
            }
            Self::ChannelSkew => {
                "Two recordings at speeds a factor of two apart: unequal delays of the channels grow with the speed, a quadrature error \
                 does not."
            }
            Self::ThresholdRipple => {
                "A recording at another speed: the frequency stays, and rises and falls move against each other; a torque tone moves \
                 both alike."
            }
            Self::ThresholdDrift => {
                "A recording from cold that lasts several times as long, at one speed: a drifting level settles, width errors and delays \
                 are there from the start."
            }
            Self::TimestampJitter => {
                "A longer recording: late captures are skewed or come at a task's rate, jitter is symmetric and white. Another speed \
                 tells both from noise of the angle."
            }
            Self::CaptureLatency => {
                "A recording with the other tasks of the controller off, or with a hardware capture: latency goes, jitter of the clock stays."
            }
            Self::LostEdges => {
                "A slower recording with an index, of some ten turns: lost edges become fewer, a slip of the index stays, a defect \
                 returns at its angle."
            }
            Self::ExtraEdges => {
                "A recording with the drive's power stage off, shaft turned by another motor or by hand: pick-up goes, a defect of the \
                 disc returns at its angle."
            }
            Self::IndexSlip => {
                "A recording with an index and several changes of load: a slip moves the index for good with no edge lost or added \
                 between two channels, lost edges break the order of A and B."
            }
            Self::TorqueRipple => {
                "Two recordings at speeds a factor of two apart, in torque or voltage mode: torque falls with the square of the speed, \
                 errors of the disc keep their size in angle, a torque tone keeps its frequency."
            }
            Self::GearMesh => {
                "Two recordings at speeds that differ by a tenth or more: the order stays while its frequency moves; the gear's tooth \
                 counts must give this order, or it is a bearing. One more with the gear disconnected shows it gone."
            }
            Self::Bearing => {
                "Two recordings at speeds that differ by a factor of two: the order stays; run-out keeps its size in angle, torque falls \
                 with the square of the speed. One more with the gear disconnected rules out a mesh."
            }
            Self::TorqueTone => {
                "A recording at a speed that differs by a tenth or more: the frequency stays, that of an order moves with the speed."
            }
            Self::TorsionalResonance => {
                "A slow ramp through the speeds at which an order meets the band: a resonance swells where they meet, a torque tone does \
                 not. One more with the load disconnected moves the band."
            }
            Self::Friction => {
                "A run-down from the highest speed to rest, load disconnected: friction gives the same deceleration at the same speed \
                 each time, a drift of the drive or a load step does not."
            }
            Self::StickSlip => {
                "A recording at several times the speed: stick-slip ends above a critical speed, tones and resonances stay."
            }
            Self::Backlash => {
                "The same reversals with a constant torque on the disc's side that keeps the play to one flank: backlash goes, hysteresis \
                 of the head stays."
            }
            Self::LoadStep => {
                "The same run once more: a load step comes at another time or not at all, friction and the drive's own profile do not move."
            }
            Self::SpeedDrift => {
                "A recording several times as long at one speed, load disconnected: a drift goes on or settles slowly, a load step comes \
                 at once, a drifting level moves rises against falls."
            }
            Self::ClosedLoop => {
                "A recording in torque or voltage mode, or with another bandwidth of the loop: what the loop makes goes or moves with \
                 its bandwidth, errors of the disc stay."
            }
            Self::Unknown => {
                "Recordings at another speed, in the other direction, and with the load disconnected show what it keeps step with."
            }
        }
    }
}
