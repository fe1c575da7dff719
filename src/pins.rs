//! The encoder's levels read from pins, for interrupt handlers whose timer captures only the time.

use embedded_hal::digital::{ErrorType, InputPin};

use crate::edge::Levels;

/// The pins of A, B and Z. A pin's own error ends the reading.
pub struct EncoderPins<A, B, Z> {
    a: A,
    b: B,
    z: Z,
}

impl<A, B, Z> EncoderPins<A, B, Z>
where
    A: InputPin,
    B: InputPin + ErrorType<Error = A::Error>,
    Z: InputPin + ErrorType<Error = A::Error>,
{
    /// Takes the pins.
    pub const fn new(a: A, b: B, z: Z) -> Self {
        Self { a, b, z }
    }

    /// Levels now. Read it first thing after an edge: a level that changes before it is read is taken for this edge.
    ///
    /// # Errors
    /// The pins'.
    #[inline]
    pub fn levels(&mut self) -> Result<Levels, A::Error> {
        let a = u8::from(self.a.is_high()?) * Levels::A;
        let b = u8::from(self.b.is_high()?) * Levels::B;
        let z = u8::from(self.z.is_high()?) * Levels::Z;
        Ok(Levels(a | b | z))
    }

    /// Gives the pins back.
    pub fn release(self) -> (A, B, Z) {
        (self.a, self.b, self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;

    struct Pin(bool);

    impl ErrorType for Pin {
        type Error = Infallible;
    }

    impl InputPin for Pin {
        fn is_high(&mut self) -> Result<bool, Infallible> {
            Ok(self.0)
        }

        fn is_low(&mut self) -> Result<bool, Infallible> {
            Ok(!self.0)
        }
    }

    #[test]
    fn each_pin_sets_its_own_bit() {
        for bits in 0..8_u8 {
            let pin = |mask| Pin(bits & mask != 0);
            let mut pins = EncoderPins::new(pin(Levels::A), pin(Levels::B), pin(Levels::Z));
            assert_eq!(pins.levels(), Ok(Levels(bits)));
        }
    }
}
