//! The power failing at every operation of a commit, of rolling back and of erasing, after one another too.

use super::*;

/// What a store went through before the power fails.
#[derive(Clone, Copy)]
enum Before {
    Commit(u64),
    RollBack,
}
use Before::{Commit, RollBack};

/// Lets the power fail at every operation of `act`, in several ways, on what `prepare` left; after each, one of the tables that
/// `may_count` must count, and committing must work. Returns the number of cuts.
fn every_cut<const W: usize>(
    prepare: &[Before],
    act: impl Fn(&mut Store<Flash<W, 1024>>) -> Result<(), StoreError<Fault>>,
    may_count: &[Option<u64>],
) -> u32 {
    let mut prepared = store::<W>();
    for before in prepare {
        match before {
            Commit(serial) => drop(commit(&mut prepared, *serial).unwrap()),
            RollBack => drop(prepared.roll_back().unwrap()),
        }
    }
    let prepared = prepared.into_flash();
    let mut whole = store_on(prepared.clone());
    act(&mut whole).unwrap();
    let operations = whole.flash.operations - prepared.operations;
    assert!(may_count.contains(&counting(&mut whole)));
    let mut cuts = 0;
    for operation in 0..operations {
        for seed in 0..12 {
            let mut flash = prepared.clone();
            flash.cut_at(operation, seed * 977 + operation * 4 + seed);
            let mut store = store_on(flash);
            assert!(act(&mut store).is_err());
            store.flash.restore();
            let found = counting(&mut store);
            assert!(
                may_count.contains(&found),
                "cut {operation}, {seed}: {found:?}"
            );
            commit(&mut store, 99).unwrap();
            assert_eq!(counting(&mut store), Some(99));
            cuts += 1;
        }
    }
    cuts
}

fn every_cut_of_everything<const W: usize>() -> u32 {
    let first = |store: &mut Store<_>| commit(store, 1).map(drop);
    let second = |store: &mut Store<_>| commit(store, 2).map(drop);
    let third = |store: &mut Store<_>| commit(store, 3).map(drop);
    let back = |store: &mut Store<_>| store.roll_back().map(drop);
    let [one, two] = [Commit(1), Commit(2)];
    let both = &[one, two];
    // A commit that follows a roll back goes to the place of the table that was withdrawn.
    let rolled_back = &[one, two, RollBack];
    let anew = &[one, two, RollBack, Commit(3)];
    every_cut::<W>(&[], first, &[None, Some(1)])
        + every_cut::<W>(&[one], second, &[Some(1), Some(2)])
        + every_cut::<W>(both, third, &[Some(2), Some(3)])
        + every_cut::<W>(both, back, &[Some(2), Some(1)])
        + every_cut::<W>(rolled_back, third, &[Some(1), Some(3)])
        + every_cut::<W>(anew, back, &[Some(3), Some(1)])
        + every_cut::<W>(both, Store::erase, &[Some(2), None])
        + every_cut::<W>(&[one], Store::erase, &[Some(1), None])
        + every_cut::<W>(rolled_back, Store::erase, &[Some(1), None])
}

#[test]
fn wherever_the_power_fails_one_whole_table_counts() {
    let cuts = every_cut_of_everything::<4>()
        + every_cut_of_everything::<1>() / 8
        + every_cut_of_everything::<32>();
    std::println!("{cuts} cuts");
    assert!(cuts > 10_000);
}
