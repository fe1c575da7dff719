//! What a kill left is told apart.

use super::*;

fn place(slot: &[u8]) -> Vec<u8> {
    let mut place = vec![0xFF; (PLACES[0].end - PLACES[0].start) as usize];
    place[SLOT_AT..SLOT_AT + slot.len()].copy_from_slice(slot);
    place
}

#[test]
fn what_a_kill_left_is_told_apart() {
    let (old, new) = (slot_of(5).unwrap(), slot_of(7).unwrap());
    let half = |torn: &[u8]| {
        let mut slot = vec![0xFF; new.len()];
        slot[..8000].copy_from_slice(&new[..8000]);
        slot[8000..8000 + torn.len()].copy_from_slice(torn);
        left(&place(&slot), 7).unwrap()
    };
    assert_eq!(left(&place(&old), 7).unwrap(), Left::Whole);
    assert_eq!(left(&place(&[]), 7).unwrap(), Left::Whole);
    assert_eq!(half(&[]), Left::HalfWritten { torn: false });
    assert_eq!(half(&new[8000..8002]), Left::HalfWritten { torn: true });
    let mut erased = old;
    erased[..6400].fill(0xFF);
    assert_eq!(left(&place(&erased), 7).unwrap(), Left::HalfErased);
}
