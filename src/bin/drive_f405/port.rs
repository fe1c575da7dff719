//! The port as the main loop sees it: what it writes is sent by the control loop, a byte a round, so that it never waits for the line while
//! edges come in.

use core::convert::Infallible;

use cortex_m::interrupt;
use embedded_io::{ErrorType, Read, ReadReady, Write};

use crate::DRIVE;
use crate::usart::Usart;

pub struct Port(pub Usart);

impl ErrorType for Port {
    type Error = Infallible;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        self.0.read_ready()
    }
}

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        self.0.read(buffer)
    }
}

impl Write for Port {
    /// Queues what there is room for, at least one byte: waits for it where there is none.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let mut queued = 0;
        while queued == 0 && !bytes.is_empty() {
            interrupt::free(|cs| {
                if let Some(drive) = DRIVE.borrow(cs).borrow_mut().as_mut() {
                    queued = bytes
                        .iter()
                        .take_while(|byte| drive.replies.push_back(**byte).is_ok())
                        .count();
                }
            });
        }
        Ok(queued)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
