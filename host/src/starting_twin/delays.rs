//! Delays of the edge classes: rise against fall, channel against channel.
//!
//! A delay that all edges have is a shift of the clock, so classes are told against the one that comes first. At one speed a delay is an
//! angle, which the disc's pattern has as well: only a recording whose speed changes tells them.

use nalgebra::{DMatrix, DVector};

use super::Estimate;
use crate::diagnose::effect::{Carrier, Effect, On, Site};
use crate::diagnose::model::{Board, Fit, Model};
use crate::diagnose::record;
use crate::diagnose::search::{self, SURE};
use crate::twin::{ChannelSkew, EdgeDelay, RiseFall};

/// The delay of an edge class against the one that comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassDelay {
    /// 0 is A.
    pub channel: u8,
    /// Whether the level rises.
    pub rises: bool,
    /// How much later it is captured, s.
    pub late_s: Estimate,
}

/// Delays as effects that are fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Delays {
    /// Effects, one number each.
    effects: Vec<Effect>,
}

/// Effect group of the delays in a model.
const GROUP: usize = 0;

fn stamp(channel: Option<u8>, rises: Option<bool>) -> Effect {
    Effect::new(Site::Stamp(On { channel, rises }), Carrier::Steady)
}

/// Channel and flank of each class.
fn classes(board: &Board) -> Vec<(u8, bool)> {
    let classes = board
        .benches
        .first()
        .map_or(0, |bench| bench.record.classes);
    let each = (0..classes as usize).map(|class| record::change(class, classes));
    each.map(|change| (change.channel, change.rises)).collect()
}

/// What delays may be: rises all alike, channels all alike, both, or each class on its own.
fn alternatives(board: &Board) -> Vec<Vec<Effect>> {
    let classes = classes(board);
    let channels = classes.iter().map(|(channel, _)| channel + 1).max();
    let flanks = classes.iter().any(|(_, rises)| !rises);
    let rise = vec![stamp(None, Some(true))];
    let skew: Vec<Effect> = (1..channels.unwrap_or(0))
        .map(|channel| stamp(Some(channel), None))
        .collect();
    let mut all = Vec::new();
    if flanks {
        all.push(rise.clone());
    }
    if !skew.is_empty() {
        all.push(skew.clone());
    }
    if flanks && !skew.is_empty() {
        all.push([rise, skew].concat());
        let each = classes.iter().skip(1);
        all.push(
            each.map(|(c, rises)| stamp(Some(*c), Some(*rises)))
                .collect(),
        );
    }
    all
}

/// The delays of most evidence beside what a board holds already; none where none is worth its numbers.
#[must_use]
pub fn find(board: &Board) -> Option<Delays> {
    let without = board.fit(&Model::default());
    let tried = alternatives(board).into_iter().map(|effects| {
        let fit = fitted(board, &effects);
        let worth = search::evidence(board, without.rss - fit.rss, effects.len());
        (worth, effects)
    });
    let (worth, effects) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (worth > SURE).then_some(Delays { effects })
}

/// Standard error of the delay of rises against falls, or of channels, where none was found, s.
#[must_use]
pub fn resolution(board: &Board) -> Option<f64> {
    let effects = alternatives(board).into_iter().next()?;
    let fit = fitted(board, &effects);
    let variance = fit.covariance[(0, 0)];
    (variance > 0.0).then(|| variance.sqrt())
}

fn fitted(board: &Board, effects: &[Effect]) -> Fit {
    let mut model = Model::default();
    model.add(effects, GROUP);
    board.fit(&model)
}

impl Delays {
    /// Delays of all classes that are not in the board's twins yet: values and covariance, s.
    #[must_use]
    pub fn fit(&self, board: &Board) -> (DVector<f64>, DMatrix<f64>) {
        let fit = fitted(board, &self.effects);
        let classes = classes(board);
        // Which of the numbers each class has.
        let of = DMatrix::from_fn(classes.len(), self.effects.len(), |class, effect| {
            let (channel, rises) = classes[class];
            let change = record::Change { channel, rises };
            match self.effects[effect].site {
                Site::Stamp(on) if on.has(change) => 1.0,
                _ => 0.0,
            }
        });
        let sizes = fit.model.terms.iter().flat_map(|term| term.sizes.clone());
        let sizes = DVector::from_iterator(self.effects.len(), sizes);
        let spread = (fit.rss / board.edges() as f64).max(1.0);
        (&of * sizes, spread * &of * fit.covariance * of.transpose())
    }

    /// Delays of all classes against the one that comes first.
    #[must_use]
    pub fn told(
        &self,
        board: &Board,
        late_s: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> Vec<ClassDelay> {
        let first = late_s.imin();
        let each = classes(board).into_iter().enumerate();
        each.map(|(class, (channel, rises))| {
            let variance = covariance[(class, class)] + covariance[(first, first)]
                - 2.0 * covariance[(class, first)];
            ClassDelay {
                channel,
                rises,
                late_s: Estimate::normal(late_s[class] - late_s[first], variance.max(0.0).sqrt()),
            }
        })
        .collect()
    }
}

/// Delays as a twin declares them: whole channels where flanks do not differ.
#[must_use]
pub fn declared(delays: &[ClassDelay]) -> (Option<EdgeDelay>, Option<ChannelSkew>) {
    let of = |channel: u8, rises: bool| {
        let mut own = delays.iter();
        own.find(|delay| delay.channel == channel && delay.rises == rises)
            .map_or(0.0, |delay| delay.late_s.value)
    };
    if delays.iter().all(|delay| delay.late_s.value == 0.0) {
        return (None, None);
    }
    let channels: Vec<u8> = (0..3).collect();
    if channels.iter().all(|&c| of(c, true) == of(c, false)) {
        let skew = ChannelSkew {
            a_s: of(0, true),
            b_s: of(1, true),
            c_s: of(2, true),
        };
        return (None, Some(skew));
    }
    let both = |channel: u8| RiseFall {
        rise_s: of(channel, true),
        fall_s: of(channel, false),
    };
    let delay = EdgeDelay {
        a: both(0),
        b: both(1),
        c: both(2),
    };
    (Some(delay), None)
}
