//! The shaft as a linear system driven by white torque: dv/dt = -d v + torque, dphi/dt = v, where phi is the angle and v the speed
//! that it is off its nominal motion.

/// Damping and noise of the shaft.
#[derive(Clone, Copy, Debug)]
pub struct Shaft {
    /// Friction and drive stiffness over inertia, d, 1/s.
    pub damping: f64,
    /// Two-sided density q of the acceleration, (rad/s^2)^2/Hz.
    pub density: f64,
    /// Whether the speed at the start is as if it had run so for long; else it may be anything.
    pub settled: bool,
}

/// How the state goes on over a step of time.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// Share of the speed that is left.
    pub speed: f64,
    /// Angle that a unit of speed makes.
    pub angle: f64,
    /// Variance that comes to the angle, the covariance, and what comes to the speed.
    pub noise: [f64; 3],
}

impl Shaft {
    /// The step over a time, s, exactly.
    #[must_use]
    pub fn transition(&self, step_s: f64) -> Transition {
        let (d, q) = (self.damping, self.density);
        let x = d * step_s;
        let lost = -(-x).exp_m1();
        // x - 2 (1 - e) + (1 - e^2) / 2, whose first three terms cancel.
        let angle = if x < 1e-2 {
            x.powi(3) * (1.0 / 3.0 - x / 4.0 + 7.0 / 60.0 * x * x)
        } else {
            x - 2.0 * lost + -(-2.0 * x).exp_m1() / 2.0
        };
        Transition {
            speed: 1.0 - lost,
            angle: lost / d,
            noise: [
                q * angle / d.powi(3),
                q * lost * lost / (2.0 * d * d),
                q * -(-2.0 * x).exp_m1() / (2.0 * d),
            ],
        }
    }

    /// Variance of the speed at the start, (rad/s)^2.
    #[must_use]
    pub fn start_variance(&self) -> f64 {
        if self.settled {
            self.density / (2.0 * self.damping)
        } else {
            0.0
        }
    }

    /// Two-sided density of the angle at an angular frequency, rad^2/Hz.
    #[must_use]
    pub fn angle_density(&self, rad_s: f64) -> f64 {
        let square = rad_s * rad_s;
        self.density / (square * (square + self.damping * self.damping))
    }

    /// Angle that a unit of acceleration at an angular frequency makes: real and imaginary part.
    #[must_use]
    pub fn response(&self, rad_s: f64) -> (f64, f64) {
        // 1 / (i w (i w + d))
        let size = rad_s * (rad_s * rad_s + self.damping * self.damping);
        (-rad_s / size, -self.damping / size)
    }
}

/// Makes the noise of a series of angles white: the filter that predicts each from those before (Kalman), with gains that do not
/// depend on what is filtered.
pub struct Whitener {
    steps: Vec<Step>,
}

struct Step {
    transition: Transition,
    gain: [f64; 2],
    scale: f64,
}

impl Whitener {
    /// For angles at these times, s, the first of them with angle 0 but for a reading error; `reading` are the variances of the
    /// reading errors, rad^2, more than 0.
    #[must_use]
    pub fn new(shaft: &Shaft, times: &[f64], reading: &[f64]) -> Self {
        let mut p = [0.0, 0.0, shaft.start_variance()];
        let mut before = times[0];
        let steps = times.iter().zip(reading).map(|(&time, &reading)| {
            let t = shaft.transition(time - before);
            before = time;
            let cross = t.speed * (p[1] + t.angle * p[2]);
            p = [
                p[0] + 2.0 * t.angle * p[1] + t.angle * t.angle * p[2] + t.noise[0],
                cross + t.noise[1],
                t.speed * t.speed * p[2] + t.noise[2],
            ];
            let variance = p[0] + reading;
            let gain = [p[0] / variance, p[1] / variance];
            // In this form p[0] stays above 0 however small the reading error.
            p = [
                p[0] * reading / variance,
                p[1] * reading / variance,
                p[2] - gain[1] * p[1],
            ];
            Step {
                transition: t,
                gain,
                scale: 1.0 / variance.sqrt(),
            }
        });
        Self {
            steps: steps.collect(),
        }
    }

    /// Turns a series into its surprises over their standard errors, in place.
    pub fn whiten(&self, series: &mut [f64]) {
        let (mut angle, mut speed) = (0.0, 0.0);
        for (value, step) in series.iter_mut().zip(&self.steps) {
            angle += step.transition.angle * speed;
            speed *= step.transition.speed;
            let surprise = *value - angle;
            angle += step.gain[0] * surprise;
            speed += step.gain[1] * surprise;
            *value = surprise * step.scale;
        }
    }
}
