//! A recording's motion in two parts: what the loop did to the shaft, and what a free shaft could have done.

use super::command::Shares;
use super::fit::Data;
use super::push::Push;
use super::trend::TrendFit;

/// Both parts at each edge. They are taken at the edge's own time: together they are the whole motion, however it settled at the
/// start.
pub(super) struct Course {
    /// The displacement, without what a free shaft could have done.
    pub made: Vec<Shares>,
    /// What a free shaft could have done of the angle that the grid shows, rad.
    pub free: Vec<f64>,
}

impl Course {
    /// Of the edges in `data`, `step_rad` a step of the grid.
    #[allow(clippy::cast_precision_loss)]
    pub fn of(data: Data<'_>, push: &Push, step_rad: f64) -> Self {
        let first = data.crossings.first().map_or(0, |c| c.ticks);
        let mark = data.crossings.iter().find(|c| c.sure).map(|c| c.edge);
        let seconds = |ticks: u64| (ticks - first) as f64 / data.clock_hz as f64;
        let mut pushed = push.start(data.clock_hz, step_rad, first);
        let mut fit = TrendFit::new(push.viscous());
        let mut steps = 0;
        let mut made: Vec<Shares> = Vec::with_capacity(data.crossings.len());
        for crossing in data.crossings {
            let [kp, ki, neither] = pushed.reach(crossing.ticks);
            pushed.edge(crossing);
            steps += crossing.way();
            // Always at one edge of the disc: the encoder's errors are the same there.
            if crossing.sure && Some(crossing.edge) == mark {
                let shown = steps as f64 * step_rad;
                fit.add(seconds(crossing.ticks), &[kp, ki, neither, shown]);
            }
            made.push([kp, ki, neither]);
        }
        let trend = fit.trend();
        let mut free = Vec::with_capacity(made.len());
        for (made, crossing) in made.iter_mut().zip(data.crossings) {
            let [kp, ki, neither, shown] = trend.at(seconds(crossing.ticks));
            *made = [made[0] - kp, made[1] - ki, made[2] - neither];
            free.push(shown);
        }
        Self { made, free }
    }
}
