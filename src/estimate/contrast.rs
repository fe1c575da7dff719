//! From closed sums to what telling geometry, torque and noise apart needs: the plain mean less the weighed one, and both
//! contrasts without what repeats.

use core::task::{Poll, ready};

use super::Parts;
use super::close::saturated;
use super::course::{Curve, place, step_of};
use super::cursor::Cursor;
use super::fold::thirds;
use super::moments::{Mean, Moments};
use super::order::OrderPlan;
use super::speeds::Speeds;

/// Blocks of a slice.
const BLOCKS: usize = 25;

/// What the contrasts of both means hold of the weighed and the plain mean, Q30.
#[derive(Clone, Copy, Default)]
pub(super) struct Leftovers {
    pub plain: [i64; 2],
    pub weighed: [i64; 2],
}

/// Leaves in the coarse sums the plain mean less the weighed one, its contrast, and the contrast of the weighed mean, with
/// what repeats taken out of the contrasts.
#[derive(Default)]
pub(super) struct Contrasting {
    of_plain: Option<[i64; 2]>,
    of_weighed: Option<[i64; 2]>,
    cursor: Cursor,
}

impl Contrasting {
    pub(super) fn slice(
        &mut self,
        parts: &mut Parts<'_>,
        plan: OrderPlan,
        moments: &Moments,
        speeds: &Speeds,
        bent: Curve,
    ) -> Poll<Leftovers> {
        let Some(of_plain) = self.of_plain else {
            self.of_plain = Some(moments.leftover(Mean::Plain, speeds));
            return Poll::Pending;
        };
        let Some(of_weighed) = self.of_weighed else {
            self.of_weighed = Some(moments.leftover(Mean::Weighed, speeds));
            return Poll::Pending;
        };
        let block = plan.edges / plan.blocks;
        let stretch = self.cursor.next(BLOCKS, plan.blocks);
        let step = step_of(plan.blocks);
        let [even, even_contrast, contrast] = thirds(parts.coarse);
        for at in stretch {
            let (weighed, plain) = (i64::from(parts.sum[at * block]), i64::from(even[at]));
            let repeats = |[a, b]: [i64; 2]| {
                let product = |share: i64, mean: i64| i128::from(share) * i128::from(mean);
                #[allow(clippy::cast_possible_truncation)]
                let repeats = ((product(a, weighed) + product(b, plain)) >> 30) as i64;
                repeats
            };
            let signed = i64::from(contrast[at]) - repeats(of_weighed);
            let plain_signed = i64::from(even_contrast[at]) - repeats(of_plain);
            even[at] = saturated(plain - weighed - bent.at(place(at, step)));
            even_contrast[at] = saturated(plain_signed - signed);
            contrast[at] = saturated(signed);
        }
        ready!(self.cursor.at_end(plan.blocks));
        Poll::Ready(Leftovers {
            plain: of_plain,
            weighed: of_weighed,
        })
    }
}
