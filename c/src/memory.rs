//! What stands behind an opaque structure of the caller's, and the checks of pointers.

use core::slice;

use crate::quadcal_status;
use crate::quadcal_status::{QUADCAL_ERROR_NOT_INITIALISED, QUADCAL_ERROR_POINTER};

/// What an opaque structure holds once it is initialised.
#[repr(C)]
pub(crate) struct Held<T> {
    mark: u32,
    value: T,
}

/// In the first word of every initialised structure: tells it from memory that is all zeros.
const MARK: u32 = 0x5143_4c31;

/// Checks that `T` fits an opaque structure `O`; for a `const`.
pub(crate) const fn fits<T, O>() {
    assert!(
        size_of::<Held<T>>() <= size_of::<O>() && align_of::<Held<T>>() <= align_of::<O>(),
        "the opaque structure is too small"
    );
}

/// Puts `value` into an opaque structure.
///
/// # Safety
/// `place` is null or points to an `O` that is the caller's for the time of the call; `T` [`fits`] it.
pub(crate) unsafe fn hold<T, O>(place: *mut O, value: T) -> Result<(), quadcal_status> {
    // SAFETY: the caller's word, passed on; `write` leaves a whole value.
    unsafe { hold_filled(place, |place: *mut T| place.write(value)) }
}

/// As [`hold`], of a value that `fill` writes where it shall be.
///
/// # Safety
/// As [`hold`]; `fill` leaves a whole value.
pub(crate) unsafe fn hold_filled<T, O>(
    place: *mut O,
    fill: impl FnOnce(*mut T),
) -> Result<(), quadcal_status> {
    if place.is_null() || !place.is_aligned() {
        return Err(QUADCAL_ERROR_POINTER);
    }
    let held = place.cast::<Held<T>>();
    // SAFETY: not null, aligned and large enough, and the caller's. Nothing is read, and what was there needs no drop.
    unsafe {
        fill(&raw mut (*held).value);
        (&raw mut (*held).mark).write(MARK);
    }
    Ok(())
}

/// What an opaque structure holds.
///
/// # Safety
/// `place` is null or points to an `O`, all zeros or one that [`hold`] put a `T` in, which nobody else uses for the time of the call.
#[inline]
pub(crate) unsafe fn held<'a, T, O>(place: *mut O) -> Result<&'a mut T, quadcal_status> {
    if place.is_null() || !place.is_aligned() {
        return Err(QUADCAL_ERROR_POINTER);
    }
    // SAFETY: not null, aligned, and its first word was written, as zero or by `hold`.
    if unsafe { place.cast::<u32>().read() } != MARK {
        return Err(QUADCAL_ERROR_NOT_INITIALISED);
    }
    // SAFETY: the mark says that `hold` wrote all of it, and nobody else uses it meanwhile.
    Ok(unsafe { &mut (*place.cast::<Held<T>>()).value })
}

/// Writes a result.
///
/// # Safety
/// `place` is null or the caller's to write.
#[inline]
pub(crate) unsafe fn give<T>(place: *mut T, value: T) -> Result<(), quadcal_status> {
    if place.is_null() || !place.is_aligned() {
        return Err(QUADCAL_ERROR_POINTER);
    }
    // SAFETY: not null, aligned, and the caller's to write.
    unsafe { place.write(value) };
    Ok(())
}

/// `length` items to read; null is right where there are none.
///
/// # Safety
/// `items` is null or points to so many, which nobody writes to for the time of `'a`.
#[inline]
pub(crate) unsafe fn items<'a, T>(
    items: *const T,
    length: usize,
) -> Result<&'a [T], quadcal_status> {
    match length {
        0 => Ok(&[]),
        _ if items.is_null() || !items.is_aligned() => Err(QUADCAL_ERROR_POINTER),
        // SAFETY: not null, aligned, and so many, which nobody writes to.
        _ => Ok(unsafe { slice::from_raw_parts(items, length) }),
    }
}

/// `length` items to write; null is right where there are none.
///
/// # Safety
/// `items` is null or points to so many, which are initialised and nobody else uses for the time of `'a`.
#[inline]
pub(crate) unsafe fn items_mut<'a, T>(
    items: *mut T,
    length: usize,
) -> Result<&'a mut [T], quadcal_status> {
    match length {
        0 => Ok(&mut []),
        _ if items.is_null() || !items.is_aligned() => Err(QUADCAL_ERROR_POINTER),
        // SAFETY: not null, aligned, and so many, which nobody else uses.
        _ => Ok(unsafe { slice::from_raw_parts_mut(items, length) }),
    }
}

/// The status of a result.
#[inline]
pub(crate) fn status(result: Result<quadcal_status, quadcal_status>) -> quadcal_status {
    match result {
        Ok(status) | Err(status) => status,
    }
}
