//! What the driver does when the controller does not do what it should.

use super::model::Fault;
use super::*;

#[test]
fn flags_left_by_others_do_not_count() {
    let mut model = Model::new();
    model.sr = status::PGSERR | status::PGPERR;
    let mut flash = flash_on(model, Supply::From2V7);
    flash.write(ROOM.start, &[0; 4]).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_wrong_key_shuts_the_controller_until_reset() {
    let mut model = Model::new();
    model.write(Register::Key, 1);
    model.misuse.clear();
    let mut flash = flash_on(model, Supply::From2V7);
    let write = |flash: &mut Flash<Model>| flash.write(ROOM.start, &[0; 4]);
    assert_eq!(write(&mut flash), Err(FlashError::Locked));
    // Each further key would be a bus error.
    let errors = flash.interface().misuse.len();
    assert_eq!(write(&mut flash), Err(FlashError::Locked));
    assert_eq!(flash.interface().misuse.len(), errors);
    assert_eq!(read(&mut flash, ROOM.start), [0xFF; 4]);
    let mut model = flash.into_interface();
    model.restart();
    let mut flash = flash_on(model, Supply::From2V7);
    write(&mut flash).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_controller_that_keeps_no_command_is_not_started() {
    let mut model = Model::new();
    model.deaf = true;
    let mut flash = flash_on(model, Supply::From2V7);
    assert_eq!(
        flash.erase(ROOM.start, ROOM.end),
        Err(FlashError::Deaf),
        "erase"
    );
    assert_eq!(flash.write(ROOM.start, &[0; 4]), Err(FlashError::Deaf));
    assert_eq!(flash.interface().operations, 0);
}

#[test]
fn every_error_flag_has_its_name_and_ends_the_operation() {
    for (flag, why) in [
        (status::WRPERR, Refusal::WriteProtected),
        (status::PGSERR, Refusal::Sequence),
        (status::PGPERR, Refusal::Parallelism),
        (status::PGAERR, Refusal::Alignment),
        (status::OPERR, Refusal::Operation),
    ] {
        let mut flash = flash();
        flash.interface().fault = Some((1, Fault::Flags(flag)));
        let at = ROOM.start + 4;
        assert_eq!(
            flash.write(ROOM.start, &[0x55; 12]),
            Err(FlashError::Refused { at, why })
        );
        assert_eq!(read(&mut flash, at), [0xFF; 8]);
        in_order(&mut flash);

        flash.interface().fault = Some((3, Fault::Flags(flag)));
        let at = sector_start(3);
        assert_eq!(
            flash.erase(ROOM.start, ROOM.end),
            Err(FlashError::Refused { at, why })
        );
        // What was erased before is read as it is now, and the flag does not outlive the operation.
        assert_eq!(read(&mut flash, ROOM.start), [0xFF; 4]);
        in_order(&mut flash);
        flash.write(ROOM.start, &[1; 4]).unwrap();
        in_order(&mut flash);
    }
}

#[test]
fn a_protected_sector_is_named() {
    let mut flash = flash();
    flash.interface().protected = 1 << 4;
    let at = sector_start(4);
    let refused = Err(FlashError::Refused {
        at,
        why: Refusal::WriteProtected,
    });
    assert_eq!(flash.erase(ROOM.start, ROOM.end), refused);
    assert_eq!(flash.write(at, &[0; 4]), refused);
    in_order(&mut flash);
}

#[test]
fn a_word_that_does_not_take_is_found() {
    let mut flash = flash();
    flash.interface().fault = Some((1, Fault::Weak));
    assert_eq!(
        flash.write(ROOM.start, &[0; 12]),
        Err(FlashError::Mismatch(ROOM.start + 4))
    );
    in_order(&mut flash);
}

#[test]
fn a_slow_operation_is_waited_for_up_to_its_limit_and_not_beyond() {
    let erase = |flash: &mut Flash<Model>| flash.erase(sector_start(2), sector_start(3));
    let mut patient = flash();
    patient.interface().fault = Some((0, Fault::Slow(500)));
    erase(&mut patient).unwrap();
    in_order(&mut patient);

    let mut flash = flash();
    flash.interface().memory.fill(0);
    assert_eq!(read(&mut flash, sector_start(2)), [0; 4]);
    flash.interface().fault = Some((0, Fault::Slow(501 + 1000)));
    assert_eq!(erase(&mut flash), Err(FlashError::Timeout));
    // The operation is still running: the bus must not be stalled, and what is read next is what the erasure left.
    assert_eq!(read(&mut flash, sector_start(2)), [0xFF; 4]);
    assert_eq!(flash.interface().misuse, [""; 0]);
    erase(&mut flash).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_controller_that_is_busy_for_ever_stalls_nothing() {
    let mut flash = flash();
    flash.interface().fault = Some((0, Fault::Slow(u32::MAX)));
    assert_eq!(
        flash.write(ROOM.start, &[0; 8]),
        Err(FlashError::Timeout),
        "write"
    );
    let mut four = [0; 4];
    assert_eq!(flash.read(ROOM.start, &mut four), Err(FlashError::Timeout));
    assert_eq!(
        flash.erase(ROOM.start, ROOM.end),
        Err(FlashError::Timeout),
        "erase"
    );
    assert_eq!(flash.write(ROOM.start, &[0; 4]), Err(FlashError::Timeout));
    assert_eq!(flash.interface().misuse, [""; 0]);
}

#[test]
fn limits_are_the_data_sheet_s_on_a_fast_core_at_a_low_supply() {
    // 800 ms of a small sector, at four cycles a look and 168 MHz.
    let limit = 800 * 42_000;
    for (looks, result) in [(limit, Ok(())), (limit + 1, Err(FlashError::Timeout))] {
        let mut model = Model::new();
        model.fault = Some((0, Fault::Slow(looks)));
        let mut flash = Flash::new(model, ROOM, Supply::From1V8, 168_000_000);
        assert_eq!(flash.erase(sector_start(2), sector_start(3)), result);
        assert_eq!(flash.interface().misuse, [""; 0]);
    }
}
