//! Long loops in stretches: solving is cut into slices, and every loop of it remembers how far it came.

use core::ops::Range;
use core::task::Poll;

/// How far a loop over `0..end` has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cursor(usize);

impl Cursor {
    pub(super) const START: Self = Self(0);

    /// The next stretch, at most `most` long; empty at the end.
    pub(super) fn next(&mut self, most: usize, end: usize) -> Range<usize> {
        let start = self.0.min(end);
        self.0 = end.min(start + most);
        start..self.0
    }

    /// Steps done.
    pub(super) const fn count(self) -> usize {
        self.0
    }

    /// Whether the end is reached.
    pub(super) fn at_end(self, end: usize) -> Poll<()> {
        if self.0 >= end {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }
}

/// Does all slices at once.
pub(super) fn whole<T>(mut slice: impl FnMut() -> Poll<T>) -> T {
    loop {
        if let Poll::Ready(result) = slice() {
            return result;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_join_and_end() {
        let mut cursor = Cursor::START;
        let mut next = 0;
        whole(|| {
            let stretch = cursor.next(4, 10);
            assert_eq!(stretch.start, next);
            next = stretch.end;
            cursor.at_end(10)
        });
        assert_eq!(next, 10);
        assert!(cursor.next(4, 10).is_empty() && Cursor::START.at_end(0).is_ready());
    }
}
