//! What a table does to each order of the encoder's error.

use quadcal_host::calibrate::Calibration;
use realfft::RealFftPlanner;

use super::Run;
use crate::accuracy::table_rad;

/// Orders looked at one by one: as many as the core weighs so.
const ORDERS: usize = 240;

/// Power of every order before and after correction, over runs.
#[derive(Clone, Debug, Default)]
pub struct ByOrder {
    before: Vec<f64>,
    after: Vec<f64>,
}

/// The order that comes off worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstOrder {
    /// Cycles a turn.
    pub order: usize,
    /// RMS of the error at the order after correction over that before.
    pub ratio: f64,
}

impl ByOrder {
    /// Adds a run.
    ///
    /// # Panics
    /// When a table has another number of edges than the disc: a fault of the test.
    pub fn add(&mut self, calibration: &Calibration, run: &Run) {
        let table = table_rad(&calibration.solution);
        let rest: Vec<f64> = run.truth.iter().zip(&table).map(|(e, c)| e - c).collect();
        for (sums, x) in [(&mut self.before, &run.truth), (&mut self.after, &rest)] {
            let powers = powers(x);
            sums.resize(powers.len(), 0.0);
            for (sum, power) in sums.iter_mut().zip(powers) {
                *sum += power;
            }
        }
    }

    /// The order that comes off worst; none before a run was added.
    #[must_use]
    pub fn worst(&self) -> Option<WorstOrder> {
        let ratios = self.after.iter().zip(&self.before);
        let orders = ratios.zip(1..).map(|((after, before), order)| WorstOrder {
            order,
            ratio: (after / before).sqrt(),
        });
        orders.max_by(|one, other| one.ratio.total_cmp(&other.ratio))
    }
}

/// Powers of orders 1, 2, ..., those of the edge classes left out at the end.
fn powers(x: &[f64]) -> Vec<f64> {
    let mut input = x.to_vec();
    let plan = RealFftPlanner::new().plan_fft_forward(x.len());
    let mut output = plan.make_output_vec();
    plan.process(&mut input, &mut output).expect("sizes fit");
    // The lines' own order belongs to the classes.
    let last = ORDERS.min(x.len() / 4 - 1);
    output[1..=last].iter().map(|c| c.norm_sqr()).collect()
}
