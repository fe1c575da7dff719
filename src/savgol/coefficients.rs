//! The smoother's integers, worked out when compiling, and the division by their common denominator.

use super::MAX_ORDER;

/// Integers of one window and order.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    /// b_i: c(u) = sum b_i C(u, i).
    pub binomials: [i64; MAX_ORDER + 1],
    /// D.
    pub denominator: u64,
    pub input_max: i32,
    /// Multiple of D, in units of D, that makes every numerator positive.
    offset: u64,
    /// floor((2^64 2^shift - 1) / D), with 2^shift <= D.
    inverse: u64,
    shift: u32,
}

/// C(n, k).
pub(super) const fn binomial(n: usize, k: usize) -> i128 {
    let mut value = 1;
    let mut i = 0;
    while i < k {
        value = value * (n as i128 - i as i128) / (i as i128 + 1);
        i += 1;
    }
    value
}

const fn gcd(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Coefficients of C(u, i) in the Gram polynomial of degree `n` over `window` points.
const fn gram(window: usize, n: usize) -> [i128; MAX_ORDER + 1] {
    let mut terms = [0; MAX_ORDER + 1];
    let mut i = 0;
    while i <= n {
        let size = binomial(window - 1 - i, n - i) * binomial(n + i, n);
        terms[i] = if (n - i).is_multiple_of(2) {
            size
        } else {
            -size
        };
        i += 1;
    }
    terms
}

const fn evaluate(terms: &[i128; MAX_ORDER + 1], u: usize) -> i128 {
    let mut sum = 0;
    let mut i = 0;
    while i <= MAX_ORDER {
        sum += terms[i] * binomial(u, i);
        i += 1;
    }
    sum
}

/// Works out the integers. Does not compile for an even window, an order that the window cannot carry, or one whose numerators
/// leave fewer than 24 bits for the input.
pub(super) const fn plan(window: usize, order: usize) -> Plan {
    assert!(window % 2 == 1, "the window must be odd");
    assert!(
        order <= MAX_ORDER && order < window,
        "the order is too high"
    );
    let mut sum = [0i128; MAX_ORDER + 1];
    let mut denominator = 1i128;
    // Odd polynomials are 0 in the middle.
    let mut n = 0;
    while n <= order {
        let terms = gram(window, n);
        let middle = evaluate(&terms, window / 2);
        let mut norm = 0;
        let mut u = 0;
        while u < window {
            let value = evaluate(&terms, u);
            norm += value * value;
            u += 1;
        }
        let mut common = norm;
        let mut i = 0;
        while i <= MAX_ORDER {
            common = gcd(common, terms[i] * middle);
            i += 1;
        }
        let norm = norm / common;
        let multiple = denominator / gcd(denominator, norm) * norm;
        let mut i = 0;
        while i <= MAX_ORDER {
            sum[i] =
                sum[i] * (multiple / denominator) + terms[i] * middle / common * (multiple / norm);
            i += 1;
        }
        denominator = multiple;
        n += 2;
    }
    let mut common = denominator;
    let mut i = 0;
    while i <= MAX_ORDER {
        common = gcd(common, sum[i]);
        i += 1;
    }
    let mut binomials = [0; MAX_ORDER + 1];
    let mut i = 0;
    while i <= MAX_ORDER {
        binomials[i] = narrow(sum[i] / common);
        i += 1;
    }
    bound(window, binomials, denominator / common)
}

const fn narrow(value: i128) -> i64 {
    assert!(value.abs() < 1 << 62, "a coefficient does not fit");
    value as i64
}

/// Range of the input and the constants of the division.
const fn bound(window: usize, binomials: [i64; MAX_ORDER + 1], denominator: i128) -> Plan {
    let denominator = narrow(denominator) as u64;
    let mut plan = Plan {
        binomials,
        denominator,
        input_max: 0,
        offset: 0,
        inverse: 0,
        shift: denominator.ilog2(),
    };
    let mut size = 0i128;
    let mut u = 0;
    while u < window {
        size += (plan.coefficient(u) as i128).abs();
        u += 1;
    }
    // Numerator, offset and rounding together stay below 2^63.
    let most = ((1i128 << 61) - 1) / size;
    plan.input_max = if most > i32::MAX as i128 {
        i32::MAX
    } else {
        most as i32
    };
    assert!(
        plan.input_max >= 1 << 24,
        "window and order leave too little range"
    );
    plan.offset = (size * plan.input_max as i128 / denominator as i128) as u64 + 1;
    plan.inverse = (((1u128 << (64 + plan.shift)) - 1) / denominator as u128) as u64;
    plan
}

impl Plan {
    /// c(u).
    pub const fn coefficient(&self, u: usize) -> i64 {
        let mut sum = 0;
        let mut i = 0;
        while i <= MAX_ORDER {
            sum += self.binomials[i] as i128 * binomial(u, i);
            i += 1;
        }
        narrow(sum)
    }

    /// `numerator` / D to the nearest, halves up, saturated. Two multiplications, no division.
    #[inline]
    pub const fn divide(&self, numerator: i64) -> i32 {
        let bias = self.offset * self.denominator + self.denominator / 2;
        let positive = bias.wrapping_add_signed(numerator);
        // At most one too small: inverse is short by less than 2^-64 of 2^shift <= D.
        let mut quotient = upper(positive, self.inverse) >> self.shift;
        if positive.wrapping_sub(quotient.wrapping_mul(self.denominator)) >= self.denominator {
            quotient += 1;
        }
        let value = quotient.wrapping_sub(self.offset).cast_signed();
        if value > i32::MAX as i64 {
            i32::MAX
        } else if value < i32::MIN as i64 {
            i32::MIN
        } else {
            value as i32
        }
    }
}

/// Upper half of the 128-bit product.
#[inline]
const fn upper(a: u64, b: u64) -> u64 {
    let (a1, a0) = (a >> 32, a & 0xFFFF_FFFF);
    let (b1, b0) = (b >> 32, b & 0xFFFF_FFFF);
    let middle = a1 * b0 + ((a0 * b0) >> 32);
    let low = a0 * b1 + (middle & 0xFFFF_FFFF);
    a1 * b1 + (middle >> 32) + (low >> 32)
}
