//! The store on the driver on the model: something fails in every operation of a commit.

use super::model::Fault;
use super::*;
use crate::shape::EncoderShape;
use crate::store::tests::table_of;
use crate::store::{Store, StoreError, place_bytes};

fn store(model: Model, supply: Supply) -> Store<Flash<Model>> {
    let flash = flash_on(model, supply);
    let layout = layout(&flash).unwrap();
    Store::new(flash, layout)
}

fn commit(store: &mut Store<Flash<Model>>, serial: u64) -> Result<(), StoreError<FlashError>> {
    let (header, entries) = table_of(60, serial);
    store.commit(&header, &entries).map(drop)
}

fn counting(store: &mut Store<Flash<Model>>) -> u64 {
    store.newest().unwrap().unwrap().header.stamp.serial
}

#[test]
fn the_largest_table_of_the_design_fits_either_place() {
    let needed = place_bytes(EncoderShape::new(10_000, 4).unwrap());
    assert_eq!(needed, 20_288);
    assert!(PLACES.iter().all(|place| place.end - place.start >= needed));
    assert_eq!(PLACES[0].start, ROOM.start);
    assert_eq!(PLACES[1].end, ROOM.end);
}

#[test]
fn a_place_that_ends_within_a_sector_is_refused() {
    let flash = flash();
    let half = ROOM.start..sector_start(4) + (16 << 10);
    assert!(Layout::on_sectors(&flash, [PLACES[1].clone(), half], 1, is_border).is_err());
}

#[test]
fn whatever_fails_in_a_commit_one_whole_table_counts() {
    let mut runs = 0;
    for supply in [Supply::From1V8, Supply::From2V7] {
        let mut prepared = store(Model::new(), supply);
        commit(&mut prepared, 1).unwrap();
        commit(&mut prepared, 2).unwrap();
        let mut flash = prepared.into_flash();
        in_order(&mut flash);
        let prepared = flash.into_interface();
        let mut whole = store(prepared.clone(), supply);
        commit(&mut whole, 3).unwrap();
        let operations = whole.into_flash().into_interface().operations;
        for operation in prepared.operations..operations {
            for fault in [
                Fault::Flags(status::WRPERR),
                Fault::Flags(status::PGSERR),
                Fault::Slow(5000),
                Fault::Weak,
                Fault::PowerFails,
            ] {
                let mut model = prepared.clone();
                model.fault = Some((operation, fault));
                let mut torn = store(model, supply);
                let result = commit(&mut torn, 3);
                let mut model = torn.into_flash().into_interface();
                assert_eq!(model.misuse, [""; 0], "{operation} {fault:?}");
                model.restart();
                let mut after = store(model, supply);
                let counts = counting(&mut after);
                match result {
                    Ok(()) => assert_eq!(counts, 3, "{operation} {fault:?}"),
                    Err(_) => assert!([2, 3].contains(&counts), "{operation} {fault:?}"),
                }
                commit(&mut after, 4).unwrap();
                assert_eq!(counting(&mut after), 4);
                runs += 1;
            }
        }
    }
    std::println!("{runs} commits with a fault");
    assert!(runs > 1500);
}
