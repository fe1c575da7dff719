//! The edges that a turn really has, as a row of ranks on the grid, and what an observation may say of them.

/// One pulse or change of state, as the search sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Time, ticks.
    pub ticks: u64,
    /// Class of the sector that the levels show, 0 where they say nothing; none where no sector shows them.
    pub class: Option<u8>,
}

/// Which sectors a turn has. A rank counts the edges that are there, through all turns; the sector of a rank lies behind its edge.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Grid edges a turn.
    edges: i64,
    /// Classes that levels tell apart.
    classes: i64,
    /// Edges that are there, in order; empty where all are.
    present: Vec<i64>,
    /// Whether the levels tell the direction.
    pub reversible: bool,
}

impl Grid {
    /// A grid of `edges` that are all there, whose sectors show `classes` patterns of levels in turn.
    pub fn full(edges: u32, classes: u8) -> Self {
        Self {
            edges: edges.into(),
            classes: classes.into(),
            present: Vec::new(),
            reversible: classes > 2,
        }
    }

    /// A wheel's teeth; at least one is there.
    pub fn teeth(present: &[bool]) -> Self {
        let all = present.iter().all(|&there| there);
        let there = (0..).zip(present).filter(|(_, there)| **there);
        Self {
            edges: present.len() as i64,
            classes: 1,
            present: if all {
                Vec::new()
            } else {
                there.map(|(place, _)| place).collect()
            },
            reversible: false,
        }
    }

    /// Ranks a turn.
    pub fn ranks(&self) -> i64 {
        if self.present.is_empty() {
            self.edges
        } else {
            self.present.len() as i64
        }
    }

    /// Ranks that a start has to choose from: those of a turn where gaps tell them apart, else one for each class.
    pub fn starts(&self) -> i64 {
        if self.present.is_empty() {
            1
        } else {
            self.ranks()
        }
    }

    /// Grid place of a rank.
    #[inline]
    pub fn place(&self, rank: i64) -> i64 {
        if self.present.is_empty() {
            return rank;
        }
        let ranks = self.present.len() as i64;
        rank.div_euclid(ranks) * self.edges + self.present[rank.rem_euclid(ranks) as usize]
    }

    /// Steps forward, 0 to classes - 1, from the sector of `rank` to the next one that shows `class`.
    #[inline]
    pub fn ahead(&self, rank: i64, class: u8) -> i64 {
        (i64::from(class) - rank).rem_euclid(self.classes)
    }

    /// Classes that levels tell apart.
    #[inline]
    pub fn classes(&self) -> i64 {
        self.classes
    }
}
