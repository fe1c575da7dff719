//! `local_defect`: dirt, a scratch, a missing or a merged line.
//!
//! A few edges about one angle of the disc are out of line, and more so the nearer they are:
//! `e(k) = E exp(-d(k)^2 / (2 s^2)), d the way from the edge to the defect`
//! often of one channel or one kind of edge only. Place and width are searched for, by kind of edge; the size is linear. Simulated in
//! `sim/defect.rs`.
//!
//! Source: a smooth bump with one place, width and size, chosen for this tool; a part of eps(k) in eq. (1) of Yin, Guo et al.,
//! doi 10.19650/j.cnki.cjsi.J2210801.

use std::f64::consts::{PI, TAU};

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::classes::{by_edge, change_of};
use crate::diagnose::mended::{Mended, channel};
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::{Flank, LocalDefect};

/// Its card.
pub const CARD: Card = Card {
    title: "defect at one place of the disc",
    physics: "Dirt, a scratch, a missing line or one that has merged with the next puts the edges about one angle of the disc out of \
              line, often those of one channel or of one kind only.",
    equation: "e(k) = E exp(-d(k)^2 / (2 s^2)), d the way from the edge to the defect",
    source: "a smooth bump with one place, width and size, chosen for this tool; a part of eps(k) in eq. (1) of Yin, Guo et al., \
             doi 10.19650/j.cnki.cjsi.J2210801",
    twin: "local_defect",
    parameters: &[
        Quantity::new("angle_rad", "rad", [0.0, TAU], "place on the disc"),
        Quantity::new("width_rad", "rad", [1e-7, PI], "s, sigma of the bump"),
        Quantity::new(
            "error_rad",
            "rad",
            [-ERROR_RAD, ERROR_RAD],
            "E, error at the peak",
        ),
    ],
    locked_to: &[LockedTo::OneAngle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::OftenOne,
    look_alikes: &[
        Mechanism::LineError,
        Mechanism::LostEdges,
        Mechanism::ExtraEdges,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A longer recording, ten turns or more: a defect stays at its angle every turn, lost or extra edges do not come back.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Bump { .. }),
        columns,
        values,
        text: |shows| {
            let angle = shows.place.angles_deg.first().copied().unwrap_or(0.0);
            format!("{}, at {angle:.2} degrees, once a turn", shows.edges)
        },
        mends,
        ..Handling::NONE
    },
};

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::Bump {
        angle_rad,
        width_rad,
        channel,
        rises,
    } = basis
    else {
        return Vec::new();
    };
    let bump: Vec<f64> = (0..seen.edges)
        .map(|edge| {
            let class = (edge + seen.shift).rem_euclid(seen.classes);
            let change = change_of(usize::try_from(class).unwrap_or(0), seen.classes);
            if !change.on(channel) || rises.is_some_and(|rises| rises != change.rises) {
                return 0.0;
            }
            let way = edge as f64 * TAU / seen.edges as f64 - angle_rad;
            let way = way.rem_euclid(TAU);
            let widths = way.min(TAU - way) / width_rad;
            (-0.5 * widths * widths).exp()
        })
        .collect();
    by_edge(seen, |at, _| bump[seen.edge(at)])
}

fn values(numbers: &Numbers<'_>) -> Named {
    let Basis::Bump {
        angle_rad,
        width_rad,
        ..
    } = numbers.basis()
    else {
        return Named::new();
    };
    vec![
        ("angle_rad".to_owned(), numbers.turned(angle_rad, 0)),
        ("width_rad".to_owned(), numbers.scaled(width_rad, 1)),
        ("error_rad".to_owned(), Numbers::size(0)),
    ]
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    if let Basis::Bump {
        angle_rad,
        width_rad,
        channel: on,
        rises,
    } = basis
    {
        mended.twin.local_defect.push(LocalDefect {
            angle_rad: angle_rad.rem_euclid(TAU),
            width_rad,
            error_rad: sizes[0],
            channel: on.map(channel),
            edge: rises.map(|rises| if rises { Flank::Rise } else { Flank::Fall }),
        });
    }
}
