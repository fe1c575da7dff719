//! Calibration where the running is disturbed: strong ripple, strong wander, load steps; on seeds that nothing was tuned to. `--bin
//! anywhere` sweeps many.
#![allow(clippy::cast_precision_loss, missing_docs)]

use quadcal::estimate::Rejection;
use quadcal_host_tests::accuracy::rms;
use quadcal_host_tests::anywhere::{Disturbance, Disturbed, Judged, Verdicts};

const SEEDS: std::ops::Range<u64> = 9_100..9_112;

/// RMS over the runs of what is left, over that of the encoder; and the mean share of edges within 1.96 standard errors.
struct Left {
    of_raw: f64,
    covered: f64,
    verdicts: Verdicts,
}

fn left(by: Disturbance, lines: u32) -> Left {
    let disturbed = Disturbed { by, lines };
    let mut verdicts = Verdicts::default();
    let judged: Vec<Judged> = SEEDS
        .map(|seed| {
            let run = disturbed.run(seed).unwrap();
            let calibration = disturbed.calibrate(&run, seed).unwrap();
            verdicts.add(&calibration, &disturbed.hit(&run, seed));
            Judged::of(&calibration, &run)
        })
        .collect();
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    Left {
        of_raw: over(|run| run.left) / over(|run| run.raw),
        covered: judged.iter().map(|run| run.covered).sum::<f64>() / judged.len() as f64,
        verdicts,
    }
}
