//! Integration of the shaft's motion by its Taylor series.
//!
//! d theta/dt = omega, d omega/dt = push + slope t - damping omega + sum of ripple sin(order theta + phase). The series of sine and
//! cosine follow from that of omega, and those of further terms (see [`super::extended`]) term by term, so any order costs one sine and cosine a ripple, and the polynomial is a dense output as
//! accurate as the step itself.

use super::extended::Extended;

/// Highest power of time kept.
pub(super) const DEGREE: usize = 16;
/// Coefficients of the powers of time.
pub(super) type Series = [f64; DEGREE];
/// Largest size, rad, of the last two terms of a step.
const TOLERANCE_RAD: f64 = 1e-16;
/// A step this small is taken whatever its terms say, so that no input can stall the integration.
const SHORTEST_S: f64 = 1e-12;

/// One ripple as an acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct RippleTerm {
    pub(super) order: f64,
    pub(super) phase_rad: f64,
    /// Amplitude, rad/s^2.
    pub(super) amplitude: f64,
}

impl RippleTerm {
    /// Acceleration at a standing angle, rad/s^2.
    pub(super) fn at(&self, theta_rad: f64) -> f64 {
        self.amplitude * libm::sin(self.order * theta_rad + self.phase_rad)
    }
}

/// Accelerations that hold over one step, friction's sign included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    /// At the step's start, rad/s^2.
    pub(super) level: f64,
    /// Its rate, rad/s^3.
    pub(super) slope: f64,
    /// Acceleration a rad/s, 1/s.
    pub(super) damping: f64,
}

/// The motion over one step: angle from the step's start, as a polynomial in the time from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Length of the step, s.
    pub(super) length_s: f64,
    /// Coefficients of the speed; that of the angle for power k + 1 is this one's for k over k + 1.
    omega: Series,
    theta: Series,
    terms: usize,
}

impl Piece {
    /// No motion for a time.
    pub(super) const fn rest(length_s: f64) -> Self {
        Self {
            length_s,
            omega: [0.0; DEGREE],
            theta: [0.0; DEGREE],
            terms: 1,
        }
    }

    /// How many coefficients are not zero.
    pub(super) const fn terms(&self) -> usize {
        self.terms
    }

    /// Angle travelled since the step's start, rad.
    pub(super) fn travel(&self, tau: f64) -> f64 {
        let sum = self.theta[..self.terms]
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * tau + c);
        sum * tau
    }

    /// Speed, rad/s.
    pub(super) fn speed(&self, tau: f64) -> f64 {
        self.omega[0] + self.speed_gain(tau)
    }

    /// Speed gained since the step's start, rad/s.
    pub(super) fn speed_gain(&self, tau: f64) -> f64 {
        let sum = self.omega[1..self.terms]
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * tau + c);
        sum * tau
    }

    /// Acceleration, rad/s^2.
    pub(super) fn acceleration(&self, tau: f64) -> f64 {
        (1..self.terms)
            .rev()
            .fold(0.0, |sum, k| sum * tau + self.omega[k] * k as f64)
    }

    /// The time at which `travel` is `target`, which lies between 0 and the whole step's travel; the motion turns nowhere in the step.
    pub(super) fn time_of(&self, target: f64) -> f64 {
        let whole = self.travel(self.length_s);
        let (mut low, mut high) = (0.0, self.length_s);
        if whole == 0.0 || target / whole <= 0.0 {
            return low;
        }
        let mut tau = (self.length_s * (target / whole)).clamp(low, high);
        for _ in 0..100 {
            let miss = self.travel(tau) - target;
            // Towards the end of the step the travel grows in its own direction.
            if (miss > 0.0) == (whole > 0.0) {
                high = tau;
            } else {
                low = tau;
            }
            let newton = tau - miss / self.speed(tau);
            let next = if newton >= low && newton <= high {
                newton
            } else {
                0.5 * (low + high)
            };
            let moved = (next - tau).abs();
            tau = next;
            // Newton's error goes with the square of its step, so this is far below rounding.
            if moved <= 1e-10 * self.length_s {
                break;
            }
        }
        tau
    }
}

/// Where `f` changes sign between `low`, where it has the sign of `sign_low`, and `high`.
pub(super) fn bisect(mut low: f64, mut high: f64, sign_low: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if f(middle) * sign_low > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// The integrator: ripples, step control and its scratch.
#[derive(Clone, Debug)]
pub(super) struct Integrator {
    ripples: Vec<RippleTerm>,
    series: Vec<(Series, Series)>,
    /// Terms beyond those of the plain equation.
    extended: Option<Extended>,
    /// Steps are this many times shorter than accuracy asks for.
    finer: f64,
}

impl Integrator {
    pub(super) fn new(ripples: Vec<RippleTerm>, extended: Option<Extended>, finer: u32) -> Self {
        let series = vec![([0.0; DEGREE], [0.0; DEGREE]); ripples.len()];
        Self {
            ripples,
            series,
            extended,
            finer: f64::from(finer.max(1)),
        }
    }

    /// The terms beyond those of the plain equation, if there are any.
    pub(super) fn extended(&mut self) -> Option<&mut Extended> {
        self.extended.as_mut()
    }

    /// Longest step within a segment of this length.
    pub(super) fn share_of(&self, segment_s: f64) -> f64 {
        segment_s / self.finer
    }

    /// Acceleration of all ripples at a standing angle, rad/s^2.
    pub(super) fn ripple_at(&self, theta_rad: f64) -> f64 {
        self.ripples.iter().map(|ripple| ripple.at(theta_rad)).sum()
    }

    /// The motion from an angle and a speed on, for `longest_s` or as long as the series is accurate.
    pub(super) fn step(&mut self, theta_rad: f64, omega: f64, push: Push, longest_s: f64) -> Piece {
        debug_assert!(longest_s > 0.0);
        for (ripple, (sine, cosine)) in self.ripples.iter().zip(&mut self.series) {
            (sine[0], cosine[0]) = libm::sincos(ripple.order * theta_rad + ripple.phase_rad);
        }
        let mut piece = Piece::rest(longest_s);
        piece.omega[0] = omega;
        piece.theta[0] = omega;
        let mut power = longest_s;
        let mut small = 0;
        for k in 1..DEGREE {
            let (n, last) = (k as f64, k - 1);
            let mut rate = -push.damping * piece.omega[last];
            match last {
                0 => rate += push.level,
                1 => rate += push.slope,
                _ => {}
            }
            for (ripple, (sine, cosine)) in self.ripples.iter().zip(&mut self.series) {
                rate += ripple.amplitude * sine[last];
                let (mut with_cosine, mut with_sine) = (0.0, 0.0);
                for j in 0..k {
                    with_cosine += piece.omega[j] * cosine[last - j];
                    with_sine += piece.omega[j] * sine[last - j];
                }
                sine[k] = ripple.order * with_cosine / n;
                cosine[k] = -ripple.order * with_sine / n;
            }
            if let Some(extended) = &mut self.extended {
                rate = extended.term(last, rate, &piece.omega);
            }
            piece.omega[k] = rate / n;
            piece.theta[k] = piece.omega[k] / (n + 1.0);
            piece.terms = k + 1;
            power *= longest_s;
            small = if (piece.theta[k] * power).abs() < 0.01 * TOLERANCE_RAD {
                small + 1
            } else {
                0
            };
            // From rest the first terms may vanish and later ones not, so never stop before the fifth.
            if small >= 3 && k >= 5 {
                return self.within_reach(piece);
            }
        }
        let accurate = accurate_length(&piece.theta, longest_s * self.finer) / self.finer;
        piece.length_s = accurate.min(longest_s);
        self.within_reach(piece)
    }

    /// A piece, shortened to what its series can show.
    fn within_reach(&self, mut piece: Piece) -> Piece {
        if let Some(extended) = &self.extended {
            let reach = extended.effects.reach_rad(piece.omega[0]);
            while piece.travel(piece.length_s).abs() > reach && piece.length_s > SHORTEST_S {
                piece.length_s *= 0.5;
            }
        }
        piece
    }
}

/// `longest_s`, halved until the last two terms are small.
fn accurate_length(theta: &Series, longest_s: f64) -> f64 {
    let mut length = longest_s;
    while length > SHORTEST_S {
        let power = (1..DEGREE).fold(1.0, |power: f64, _| power * length);
        let last = theta[DEGREE - 2].abs() * power + theta[DEGREE - 1].abs() * power * length;
        if last <= TOLERANCE_RAD {
            break;
        }
        length *= 0.5;
    }
    length
}
