//! How sure the errors of a disc's edges are: white noise, and slow waves on top, as torque that nobody knows blurs what comes back every
//! turn with 1 / order^2.

/// Orders of a disc's spread that are said by themselves at the most, and how many times the mean variance others may have.
const WAVES: usize = 48;
const EVEN: f64 = 2.0;

/// How sure the errors of a disc are: white, with waves of the first orders that are less so.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spread {
    /// Standard error of each edge by itself, rad; 0 where the errors count as exact.
    pub edge_rad: f64,
    /// Standard errors of cosine and sine of the orders 1, 2, .. beside it, rad.
    pub waves_rad: Vec<f64>,
}

impl Spread {
    /// Of a disc with so many edges, from the variances of a wave of unit size of each order, rad^2.
    #[must_use]
    pub fn of(variances: &[f64], edges: usize) -> Self {
        let orders = variances.len();
        let waves = (0..orders.min(WAVES + 1).saturating_sub(1)).find(|&waves| {
            let rest = &variances[waves + 1..];
            let most = rest.iter().copied().fold(0.0, f64::max);
            most <= EVEN * mean(rest)
        });
        let waves = waves.unwrap_or_else(|| orders.min(WAVES + 1).saturating_sub(2));
        let edge2 = mean(variances.get(waves + 1..).unwrap_or_default());
        let of_unit = 2.0 / edges.max(1) as f64;
        let each = variances.iter().skip(1).take(waves);
        Self {
            edge_rad: edge2.sqrt(),
            waves_rad: each
                .map(|variance| (of_unit * (variance - edge2).max(0.0)).sqrt())
                .collect(),
        }
    }

    /// Standard error of an edge with all its waves, rad.
    #[must_use]
    pub fn whole_rad(&self) -> f64 {
        let waves = self.waves_rad.iter().map(|wave| wave * wave);
        (self.edge_rad.powi(2) + waves.sum::<f64>()).sqrt()
    }

    /// Variances of a wave of unit size of orders 0, 1, .. of a disc with so many edges, rad^2.
    #[must_use]
    pub fn variances(&self, edges: usize) -> Vec<f64> {
        let mut variances = vec![self.edge_rad.powi(2); edges / 2 + 1];
        let unit = 0.5 * edges as f64;
        for (variance, wave) in variances.iter_mut().skip(1).zip(&self.waves_rad) {
            *variance += unit * wave * wave;
        }
        variances
    }

    /// The waves' to two digits, as files have them.
    #[must_use]
    pub fn rounded_waves_rad(&self) -> Vec<f64> {
        let each = self.waves_rad.iter();
        each.map(|wave| format!("{wave:.1e}").parse().unwrap_or(*wave))
            .collect()
    }

    /// The less sure of two.
    #[must_use]
    pub fn widest(&self, other: &Self) -> Self {
        let wave = |of: &Self, at: usize| of.waves_rad.get(at).copied().unwrap_or(0.0);
        let waves = 0..self.waves_rad.len().max(other.waves_rad.len());
        Self {
            edge_rad: self.edge_rad.max(other.edge_rad),
            waves_rad: waves
                .map(|at| wave(self, at).max(wave(other, at)))
                .collect(),
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
