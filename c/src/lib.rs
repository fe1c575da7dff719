//! quadcal for C. `include/quadcal.h` is made from this crate, and `docs/c-api.md` tells how to use it.
//!
//! Memory is the caller's: opaque structures of a fixed size, no allocation. Every function but the plain questions returns a
//! [`quadcal_status`]. `unsafe` is at this boundary alone: pointers come from C, and what must hold of them is in the header.
// On a host the standard library brings the panic handler.
#![cfg_attr(target_os = "none", no_std)]
// The names are C's.
#![allow(non_camel_case_types)]

mod encoder;
mod learner;
mod memory;
mod status;

pub use encoder::{
    quadcal_angle, quadcal_capture, quadcal_capture_time, quadcal_clear_table, quadcal_config,
    quadcal_corrected, quadcal_edge, quadcal_edges, quadcal_encoder, quadcal_init,
    quadcal_overflow, quadcal_set_table, quadcal_speed, quadcal_state, quadcal_time,
    quadcal_usual_config, quadcal_view,
};
pub use learner::{
    quadcal_learn_bytes, quadcal_learn_samples, quadcal_learn_slice, quadcal_learn_start,
    quadcal_learn_table, quadcal_learner, quadcal_sample,
};
pub use status::{quadcal_error_name, quadcal_status};

/// A panic calls a function that nobody defines: a program in which one can be reached does not link.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn quadcal_a_panic_can_be_reached() -> !;
    }
    // SAFETY: never runs, as no program with this call can be linked, or runs what the program defines for it.
    unsafe { quadcal_a_panic_can_be_reached() }
}
