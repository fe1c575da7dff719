//! A small chart for a terminal, in Braille dots: two columns and four rows a character.

/// Dots of a character by column and row, in the order of Unicode's Braille patterns.
const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// Values that fit into so many characters side by side.
pub(super) const fn capacity(width: usize) -> usize {
    2 * width
}

/// Lines of `width` characters, top first, with the last values at the right; `low` is the bottom and `high` the top. Values beyond are
/// drawn at the border.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) fn draw(
    values: &[f64],
    width: usize,
    height: usize,
    [low, high]: [f64; 2],
) -> Vec<String> {
    let mut cells = vec![vec![0_u32; width]; height];
    let rows = 4 * height;
    let shown = &values[values.len().saturating_sub(capacity(width))..];
    let indent = capacity(width) - shown.len();
    for (value, column) in shown.iter().zip(indent..) {
        let share = (high - value) / (high - low).max(f64::MIN_POSITIVE);
        let row = (share * rows as f64).clamp(0.0, rows.saturating_sub(1) as f64) as usize;
        if let Some(cell) = cells
            .get_mut(row / 4)
            .and_then(|line| line.get_mut(column / 2))
        {
            *cell |= DOTS[column % 2][row % 4];
        }
    }
    let line = |cells: Vec<u32>| -> String {
        let dots = cells.into_iter().map(|dots| match dots {
            0 => Some(' '),
            dots => char::from_u32(0x2800 + dots),
        });
        dots.flatten().collect()
    };
    cells.into_iter().map(line).collect()
}

/// A range that holds the values with some room, none where they are all alike.
pub(super) fn range<'a>(values: impl Iterator<Item = &'a f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(*value), high.max(*value))
    });
    if !low.is_finite() {
        return [0.0, 1.0];
    }
    let room = (0.05 * (high - low))
        .max(1e-4 * high.abs().max(low.abs()))
        .max(1e-9);
    [low - room, high + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_goes_from_the_lower_left_to_the_upper_right() {
        let ramp: Vec<f64> = (0..8).map(f64::from).collect();
        let lines = draw(&ramp, 4, 2, [0.0, 7.5]);
        assert_eq!(lines, ["  ⡠⠊", "⡠⠊  "]);
    }

    #[test]
    fn the_last_values_stand_at_the_right_and_outliers_at_the_border() {
        assert_eq!(draw(&[9.0], 2, 1, [0.0, 1.0]), [" ⠈"]);
        assert_eq!(draw(&[-9.0], 2, 1, [0.0, 1.0]), [" ⢀"]);
        let many = [0.5; 100];
        assert_eq!(draw(&many, 3, 1, [0.0, 1.0]), ["⠤⠤⠤"]);
        assert_eq!(draw(&[], 2, 1, [0.0, 1.0]), ["  "]);
    }

    #[test]
    fn a_range_is_never_empty() {
        for values in [&[][..], &[3.0, 3.0], &[0.0], &[-1.0, 2.0]] {
            let [low, high] = range(values.iter());
            assert!(low < high, "{values:?}");
            assert!(values.iter().all(|value| (low..=high).contains(value)));
        }
    }
}
