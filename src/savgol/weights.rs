//! Exact weights of the least-squares fit at the window's centre, for compile time only.

use super::{MOMENTS_MAX, ORDER_MAX, SPLIT_BITS, WINDOW_MAX};

/// Weights `n(j) / D` in lowest terms, `n(j) = (c_0 + c_1 j^2 + c_2 j^4) / divisor`, `j` counted from the centre.
pub(super) struct Weights {
    coefficients: [i128; 3],
    divisor: i128,
    /// `D`, above zero.
    pub(super) denominator: i128,
    window: usize,
    /// `Σ |n(j)|` over the window.
    magnitude: i128,
}

impl Weights {
    /// Solves the normal equations of equation (10) for the value at the centre by Cramer's rule.
    pub(super) const fn new(window: usize, order: usize) -> Self {
        assert!(window % 2 == 1 && window >= 3 && window <= WINDOW_MAX);
        assert!(order <= ORDER_MAX && order < window);
        let terms = order / 2 + 1;
        // Normal matrix of the even powers, filled up with the unit matrix.
        let mut g = [[0_i128; 3]; 3];
        let mut row = 0;
        while row < 3 {
            let mut column = 0;
            while column < 3 {
                g[row][column] = if row < terms && column < terms {
                    power_sum(window, 2 * (row + column))
                } else {
                    (row == column) as i128
                };
                column += 1;
            }
            row += 1;
        }
        let coefficients = [
            g[1][1] * g[2][2] - g[1][2] * g[2][1],
            g[1][2] * g[2][0] - g[1][0] * g[2][2],
            g[1][0] * g[2][1] - g[1][1] * g[2][0],
        ];
        let determinant =
            g[0][0] * coefficients[0] + g[0][1] * coefficients[1] + g[0][2] * coefficients[2];
        assert!(determinant > 0);
        let mut weights = Self {
            coefficients,
            divisor: 1,
            denominator: determinant,
            window,
            magnitude: 0,
        };
        let mut divisor = determinant;
        let mut age = 0;
        while age < window {
            divisor = greatest_common_divisor(divisor, weights.at(age as i128));
            age += 1;
        }
        weights.divisor = divisor;
        weights.denominator = determinant / divisor;
        let mut sum = 0;
        age = 0;
        while age < window {
            let weight = weights.at(age as i128);
            sum += weight;
            weights.magnitude += weight.abs();
            age += 1;
        }
        assert!(sum == weights.denominator);
        // What the quotient and the direct form with split weights rely on.
        assert!(weights.magnitude <= 2 * weights.denominator);
        assert!(weights.denominator < 1 << 58);
        assert!((weights.magnitude >> SPLIT_BITS) + (window as i128) < 1 << 31);
        weights
    }

    /// Numerator for a sample of `age` (0 the newest), continued as a polynomial beyond the window.
    pub(super) const fn at(&self, age: i128) -> i128 {
        let j = age - (self.window / 2) as i128;
        let square = j * j;
        let [c0, c1, c2] = self.coefficients;
        (c0 + (c1 + c2 * square) * square) / self.divisor
    }

    /// Forward differences of order 0 to 4 at `age`; integers, as the weights are.
    pub(super) const fn differences(&self, age: i128) -> [i64; MOMENTS_MAX] {
        let mut values = [0_i128; MOMENTS_MAX];
        let mut k = 0;
        while k < MOMENTS_MAX {
            values[k] = self.at(age + k as i128);
            k += 1;
        }
        let mut differences = [0_i64; MOMENTS_MAX];
        k = 0;
        while k < MOMENTS_MAX {
            assert!(values[0].abs() <= i64::MAX as i128);
            differences[k] = values[0] as i64;
            let mut i = 0;
            while i + 1 < MOMENTS_MAX - k {
                values[i] = values[i + 1] - values[i];
                i += 1;
            }
            k += 1;
        }
        differences
    }

    /// Whether a sum over any `i32` samples fits 64 bits, and each weight 32.
    pub(super) const fn is_narrow(&self) -> bool {
        self.magnitude < 1 << 32 && self.largest() <= i32::MAX as i128
    }

    const fn largest(&self) -> i128 {
        let mut largest = 0;
        let mut age = 0;
        while age < self.window {
            let weight = self.at(age as i128).abs();
            if weight > largest {
                largest = weight;
            }
            age += 1;
        }
        largest
    }
}

/// `Σ j^power` over the window, `j` counted from the centre.
const fn power_sum(window: usize, power: usize) -> i128 {
    let half = (window / 2) as i128;
    let mut sum = 0;
    let mut j = -half;
    while j <= half {
        sum += j.pow(power as u32);
        j += 1;
    }
    sum
}

const fn greatest_common_divisor(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
