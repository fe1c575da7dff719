//! What every image for QEMU (`-M netduinoplus2`, an STM32F405) needs: files and exit code of the host, and an end to
//! every fault.

// Not every image uses all of them.
#[allow(dead_code)]
pub mod output;
#[allow(dead_code)]
pub mod semihost;

use core::fmt;

// Brings the critical section that printing needs.
use cortex_m as _;
use cortex_m_rt::{ExceptionFrame, exception};
use cortex_m_semihosting::heprintln;

/// Ends the run: exit code 0, or 1 with the reason on the error output.
pub fn finish<E: fmt::Display>(result: Result<(), E>) -> ! {
    if let Err(error) = &result {
        heprintln!("error: {}", error);
    }
    semihost::exit(result.is_ok())
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    semihost::exit(false)
}

// SAFETY: cortex-m-rt asks for `unsafe` because a hard fault handler may run with any state broken; this one only reads
// its frame and ends the run.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    heprintln!("hard fault at {:#010x}", frame.pc());
    semihost::exit(false)
}
