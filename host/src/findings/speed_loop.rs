//! Whether the table looks as if a speed loop had run while recording that nobody spoke of.
//!
//! A disc's line errors are about as large at every order above the second, eccentricity and tilt. A loop fed by the encoder's own
//! edges chases their errors and swings the shaft about its bandwidth and below, where the shaft's inertia lets it; that repeats every
//! turn as the errors do, and looks like a broad hump of line errors. Torque ripple makes single orders stand out, wander does not
//! repeat.

/// The first order looked at, after those that a disc's mounting makes.
const FIRST: usize = 5;

/// The size of a band of orders over that of the high ones from which on it stands out. Of free runs the largest seen is 2.
const STANDS_OUT: f64 = 3.0;

/// Orders that must stand out: fewer may be a few orders' torque.
const ORDERS_LEAST: usize = 8;

/// A broad hump of low orders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopSuspicion {
    /// First order that stands out.
    pub first: usize,
    /// Last order that does, of those looked at one by one; orders above may be touched too.
    pub last: usize,
    /// Size of the band that stands out most over that of the high orders, peak amplitudes.
    pub times: f64,
}

impl LoopSuspicion {
    /// Of the peak `amplitudes` of orders 1, 2, .. that a table of `lines` lines holds, of which the first `single` are weighed one by
    /// one; none where nothing stands out.
    #[must_use]
    pub fn of(amplitudes: &[f64], single: usize, lines: usize) -> Option<Self> {
        let size = |first: usize, last: usize| {
            // Multiples of the lines are the classes' means.
            let orders = (first..=last).filter(|order| !order.is_multiple_of(lines.max(2)));
            median(orders.filter_map(|order| amplitudes.get(order - 1).copied()))
        };
        let most = amplitudes.len();
        let high = size(most / 2 + 1, most);
        let top = single.min(most / 4);
        let mut found: Option<Self> = None;
        let mut first = FIRST;
        // Octaves, so that a hump is seen wherever it is.
        while first + ORDERS_LEAST / 2 <= top + 1 {
            let last = (2 * first - 2).min(top);
            let times = size(first, last) / high;
            if high > 0.0 && times > STANDS_OUT {
                let band = Self { first, last, times };
                found = Some(found.map_or(band, |before| Self {
                    first: before.first,
                    last,
                    times: before.times.max(times),
                }));
            }
            first = last + 1;
        }
        found.filter(|hump| hump.last + 1 >= hump.first + ORDERS_LEAST)
    }
}

/// The median, of two in the middle the larger; 0 of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: usize = 500;

    /// Amplitudes of 1 at all orders of a disc of 500 lines, and more where `more` says.
    fn of(more: impl Fn(usize) -> f64) -> Option<LoopSuspicion> {
        let amplitudes: Vec<f64> = (1..=2 * LINES).map(|order| 1.0 + more(order)).collect();
        LoopSuspicion::of(&amplitudes, 240, LINES)
    }

    #[test]
    fn a_broad_hump_is_found_and_where() {
        let hump = of(|order| if (20..90).contains(&order) { 9.0 } else { 0.0 }).unwrap();
        // Whole octaves: 17 to 32, 33 to 64, 65 to 128 of which less than half is hit.
        assert_eq!((hump.first, hump.last, hump.times), (17, 64, 10.0));
    }

    #[test]
    fn a_mounting_and_lines_of_torque_are_no_hump() {
        let torque = |order: usize| order <= 2 || order.is_multiple_of(5);
        assert_eq!(of(|order| if torque(order) { 1e3 } else { 0.0 }), None);
        assert_eq!(
            of(|order| if (5..9).contains(&order) { 1e3 } else { 0.0 }),
            None
        );
        assert_eq!(of(|_| 0.0), None);
    }

    #[test]
    fn an_empty_table_is_no_hump() {
        assert_eq!(LoopSuspicion::of(&[0.0; 1000], 240, LINES), None);
        assert_eq!(LoopSuspicion::of(&[], 0, 0), None);
    }
}
