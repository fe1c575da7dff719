//! One step of the motion: Dormand and Prince's pair of orders 5 and 4, with a quintic between its ends.
//!
//! Coefficients from J. R. Dormand, P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980).

/// State of the shaft: angle and speed at the encoder, angle and speed of a second mass; rad and rad/s.
pub type State = [f64; 4];

const NODES: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    // The last stage is the step's end: these are the weights of order 5.
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
/// Weights of order 5 less those of order 4.
const DIFFERENCE: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// A step taken.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Its length, s.
    pub length_s: f64,
    /// State at its end.
    pub end: State,
    /// Estimated error of the angle at its end, rad.
    pub error_rad: f64,
    start: [f64; 3],
    finish: [f64; 3],
    /// Angle travelled, rad.
    travel: f64,
}

impl Step {
    /// Takes a step of `length_s` from `state` with the derivative that `slope` gives at a time within the step and a state.
    pub fn take(state: State, length_s: f64, slope: impl Fn(f64, &State) -> State) -> Self {
        let mut slopes = [[0.0; 4]; 7];
        slopes[0] = slope(0.0, &state);
        let mut moved = [0.0; 4];
        for (stage, weights) in STAGES.iter().enumerate() {
            for (i, moved) in moved.iter_mut().enumerate() {
                let sum: f64 = (0..=stage).map(|s| weights[s] * slopes[s][i]).sum();
                *moved = length_s * sum;
            }
            let at = std::array::from_fn(|i| state[i] + moved[i]);
            slopes[stage + 1] = slope(NODES[stage] * length_s, &at);
        }
        let end: State = std::array::from_fn(|i| state[i] + moved[i]);
        let error: f64 = (0..7).map(|s| DIFFERENCE[s] * slopes[s][0]).sum();
        let speed_error: f64 = (0..7).map(|s| DIFFERENCE[s] * slopes[s][1]).sum();
        Self {
            length_s,
            end,
            error_rad: length_s * error.abs() + length_s * length_s * speed_error.abs(),
            start: [state[0], state[1], slopes[0][1]],
            finish: [end[0], end[1], slopes[6][1]],
            travel: moved[0],
        }
    }

    /// A step of standing still.
    #[must_use]
    pub fn rest(state: State, length_s: f64) -> Self {
        Self {
            length_s,
            end: state,
            error_rad: 0.0,
            start: [state[0], 0.0, 0.0],
            finish: [state[0], 0.0, 0.0],
            travel: 0.0,
        }
    }

    /// Angle travelled and speed at a time within the step, by the quintic through angle, speed and acceleration at both ends.
    #[must_use]
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        let h = self.length_s;
        if h == 0.0 {
            return (0.0, self.start[1]);
        }
        let (v0, a0) = (self.start[1] * h, self.start[2] * h * h);
        let (v1, a1) = (self.finish[1] * h, self.finish[2] * h * h);
        // Without the straight part, so that little cancels.
        let bend = self.travel - v0;
        let gain = v1 - v0;
        let c3 = 10.0 * bend - 4.0 * gain - 1.5 * a0 + 0.5 * a1;
        let c4 = -15.0 * bend + 7.0 * gain + 1.5 * a0 - a1;
        let c5 = 6.0 * bend - 3.0 * gain - 0.5 * a0 + 0.5 * a1;
        let s = time_s / h;
        let angle = s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))));
        let speed = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)));
        (angle, speed / h)
    }

    /// Acceleration at the step's start and end, rad/s^2.
    #[must_use]
    pub fn accelerations(&self) -> (f64, f64) {
        (self.start[2], self.finish[2])
    }
}
