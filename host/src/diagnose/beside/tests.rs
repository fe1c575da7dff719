//! Lost edges go into a twin as they would be declared.

use super::*;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;

#[test]
fn lost_edges_are_put_into_the_twin_by_their_numbers() {
    let rig = "[shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\n[drive.constant]\nr_min = 240\n\
               [timer]\nclock_hz = 84000000\njitter_s = 1e-7\n";
    for (encoder, kind, lines) in [
        (
            "[encoder.quadrature]\nlines = 50\n",
            SensorKind::Quadrature { index_state: None },
            50,
        ),
        ("[encoder.hall]\npole_pairs = 7\n", SensorKind::Hall, 7),
    ] {
        let text = format!("duration = {{ turns = 12 }}\n{encoder}{rig}");
        let told = Twin::parse(&text, "rig").unwrap();
        let mut truth = told.clone();
        truth.faults.lost_edges = vec![60, 201, 202, 340];
        let plan = SensorPlan { kind, lines };
        let rows = Simulation::new(&truth).unwrap();
        let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
        let track = Track::of(plan, truth.timer.clock_hz, rows).unwrap();
        let mut mended = told;
        put_lost(&mut mended, &track);
        assert_eq!(mended.faults.lost_edges, truth.faults.lost_edges);
    }
}
