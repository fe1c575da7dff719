//! The shape of an encoder: edges a turn, edge classes, and the grid that they stand on.

use crate::units::Turn32;

/// Edge classes at the most: three Hall sensors.
pub const CLASSES_MAX: usize = 6;

/// Edges a turn at the most, so that one turn in step fractions fits 32 bits.
pub const EDGES_MAX: u32 = 1 << 16;

/// What everything is told once of an encoder: how many edges a turn has, in how many classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncoderShape {
    edges: u32,
    classes: u32,
}

/// Why an encoder's shape can't be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ShapeError {
    /// Fewer than three edges a turn, or more than [`EDGES_MAX`].
    Edges(u32),
    /// No class, more than [`CLASSES_MAX`], or not a divisor of the edges.
    Classes(u32),
    /// The buffers are of another size than the edges.
    Buffers(usize),
}

impl EncoderShape {
    /// An encoder of `edges` edges a turn (N) in `classes` edge classes (4 for quadrature, 6 for three Hall sensors, 2 or 1
    /// for one channel).
    ///
    /// # Errors
    /// [`ShapeError`] when a number is out of range.
    pub const fn new(edges: u32, classes: u32) -> Result<Self, ShapeError> {
        if edges < 3 || edges > EDGES_MAX {
            return Err(ShapeError::Edges(edges));
        }
        if classes == 0 || classes as usize > CLASSES_MAX || !edges.is_multiple_of(classes) {
            return Err(ShapeError::Classes(classes));
        }
        Ok(Self { edges, classes })
    }

    /// Edges a turn, N.
    #[must_use]
    pub const fn edges(self) -> u32 {
        self.edges
    }

    /// Edge classes, C.
    #[must_use]
    pub const fn classes(self) -> u32 {
        self.classes
    }

    /// Lines a turn, M = N / C.
    #[must_use]
    pub const fn lines(self) -> u32 {
        self.edges / self.classes
    }
}

/// Grid angles without division: edge k stands at k / N of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grid {
    /// Step in 2^-32 turn, and its fraction in 2^-48 turn.
    step: u32,
    fraction: u32,
    /// 2^32 / C, 0 where C is a power of two.
    class_multiplier: u32,
    shape: EncoderShape,
}

const fn at_least_one(number: u32) -> u32 {
    if number == 0 { 1 } else { number }
}

impl Grid {
    /// The grid of a shape. Divides, so not for the edge path.
    #[must_use]
    pub const fn new(shape: EncoderShape) -> Self {
        // None is ever 0, but the compiler can't know, and would leave a panic here.
        let edges = at_least_one(shape.edges) as u64;
        let step_q16 = ((1 << 48) + edges / 2) / edges;
        let classes = at_least_one(shape.classes);
        Self {
            step: (step_q16 >> 16) as u32,
            fraction: (step_q16 & 0xFFFF) as u32,
            class_multiplier: if classes.is_power_of_two() {
                0
            } else {
                u32::MAX / classes + 1
            },
            shape,
        }
    }

    /// The encoder's shape.
    #[must_use]
    pub const fn shape(self) -> EncoderShape {
        self.shape
    }

    /// Grid angle of an edge below [`EDGES_MAX`], to the nearest 2^-32 turn.
    #[inline]
    #[must_use]
    pub const fn angle(self, edge: u32) -> Turn32 {
        // Both factors of the fraction are below 2^16: no overflow.
        let rest = edge.wrapping_mul(self.fraction).wrapping_add(1 << 15) >> 16;
        Turn32(edge.wrapping_mul(self.step).wrapping_add(rest))
    }

    /// Class of an edge, `edge mod C`.
    #[inline]
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub const fn class(self, edge: u32) -> u32 {
        if self.class_multiplier == 0 {
            return edge & self.shape.classes.wrapping_sub(1);
        }
        let line = ((edge as u64 * self.class_multiplier as u64) >> 32) as u32;
        edge.wrapping_sub(line.wrapping_mul(self.shape.classes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_and_angles_agree_with_division() {
        for (edges, classes) in [
            (12, 6),
            (90, 6),
            (6, 1),
            (65_536, 1),
            (9, 3),
            (120, 2),
            (10_000, 4),
            (65_536, 4),
            (65_532, 6),
        ] {
            let grid = Grid::new(EncoderShape::new(edges, classes).unwrap());
            for edge in 0..edges {
                assert_eq!(grid.class(edge), edge % classes);
                let exact = f64::from(edge) * 4_294_967_296.0 / f64::from(edges);
                assert!((f64::from(grid.angle(edge).0) - exact).abs() <= 1.0);
            }
        }
    }

    #[test]
    fn shapes_out_of_range_are_refused() {
        assert_eq!(EncoderShape::new(2, 1), Err(ShapeError::Edges(2)));
        assert_eq!(EncoderShape::new(65_537, 1), Err(ShapeError::Edges(65_537)));
        assert_eq!(EncoderShape::new(10, 4), Err(ShapeError::Classes(4)));
        assert_eq!(EncoderShape::new(14, 7), Err(ShapeError::Classes(7)));
    }
}
