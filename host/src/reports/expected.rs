//! What a table is expected to do, and what that leaves out, in words.

use crate::calibrate::Calibration;
use crate::findings::Findings;
use crate::report::si;

use super::words::{arc_seconds, reduction_percent};

/// What an expected error does not count: orders left alone, of which nobody knows how much is the encoder's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// Orders left alone as torque or the disc may make them.
    orders: Vec<u16>,
    /// RMS of these orders as they show, rad: the encoder's error is up to this.
    pub up_to_rad: f64,
    /// Orders from 1 up to this are left alone as a speed loop may hide them; 0 for none. Their size is not known.
    hidden_up_to: u16,
}

impl LeftOut {
    /// Of a calibration.
    #[must_use]
    pub fn of(calibration: &Calibration, findings: &Findings) -> Self {
        let left = &findings.left_alone;
        // A peak is the RMS times root 2.
        let squares = left.iter().map(|left| 0.5 * left.amplitude_rad.powi(2));
        Self {
            orders: left.iter().map(|left| left.order).collect(),
            up_to_rad: squares.sum::<f64>().sqrt(),
            hidden_up_to: calibration.left_alone_for_loop(),
        }
    }

    /// Whether nothing was left out.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.orders.is_empty() && self.hidden_up_to == 0
    }

    /// As the end of a sentence on the expected error: empty, or from a comma on.
    #[must_use]
    pub fn besides(&self) -> String {
        let mut parts = Vec::new();
        let orders: Vec<String> = self.orders.iter().map(u16::to_string).collect();
        if !orders.is_empty() {
            let many = if orders.len() == 1 { "order" } else { "orders" };
            parts.push(format!(
                "{many} {}: up to {}",
                orders.join(", "),
                si(self.up_to_rad, "rad")
            ));
        }
        match self.hidden_up_to {
            0 => {}
            1 => parts.push("order 1, which a speed loop may hide".to_owned()),
            last => parts.push(format!("orders 1 to {last}, which a speed loop may hide")),
        }
        match parts.is_empty() {
            true => String::new(),
            false => format!(", besides {}", parts.join(" and ")),
        }
    }
}

/// On what an expected error depends, as the end of a sentence.
#[must_use]
pub fn proviso(findings: &Findings) -> &'static str {
    match findings.loop_suspicion {
        Some(_) => ", if no speed loop ran",
        None => "",
    }
}

/// What the table is expected to do.
#[must_use]
pub fn outlook(findings: &Findings, left_out: &LeftOut) -> String {
    let (before_rad, after_rad) = (findings.before_rad, findings.after_rad);
    let gain = reduction_percent(before_rad, after_rad);
    if let Some(hump) = &findings.loop_suspicion {
        format!(
            "what the table will do is not known: orders {} to {} look as if a speed loop had swung the shaft",
            hump.first, hump.last
        )
    } else if gain < 5.0 {
        "little was found that could be corrected: the turns differ by more than they have in common".to_owned()
    } else {
        format!(
            "at the speeds it was learned from, the table is expected to take {gain:.1} % off the angle error: {} are left of {}{}",
            arc_seconds(after_rad),
            arc_seconds(before_rad),
            left_out.besides()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_named_with_its_size() {
        assert!(LeftOut::default().is_nothing() && LeftOut::default().besides().is_empty());
        let mut left = LeftOut {
            orders: vec![1],
            up_to_rad: 2.3e-4,
            hidden_up_to: 0,
        };
        let plain = |left: &LeftOut| left.besides().replace('\u{a0}', " ");
        assert_eq!(plain(&left), ", besides order 1: up to 230 µrad");
        left.orders.push(5);
        left.hidden_up_to = 3;
        assert_eq!(
            plain(&left),
            ", besides orders 1, 5: up to 230 µrad and orders 1 to 3, which a speed loop may hide"
        );
        assert!(!left.is_nothing());
    }
}
