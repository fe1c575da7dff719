//! The encoder's levels read from pins, for interrupt handlers whose timer captures only the time.

use embedded_hal::digital::{ErrorType, InputPin};

use crate::edge::Levels;

/// The pins of A, B and Z. A pin's own error ends the reading.
///
/// ```
/// use core::convert::Infallible;
///
/// use embedded_hal::digital::{ErrorType, InputPin};
/// use quadcal::encoder::{Capture, Corrected, Encoder, EncoderConfig};
/// use quadcal::pins::EncoderPins;
///
/// /// The interrupt of a timer that captures any edge. `latch` is what it captured, `overflow` its flag, read after the latch.
/// fn on_edge<A, B, Z>(
///     encoder: &mut Encoder,
///     pins: &mut EncoderPins<A, B, Z>,
///     latch: u32,
///     overflow: bool,
/// ) -> Option<Corrected>
/// where
///     A: InputPin,
///     B: InputPin + ErrorType<Error = A::Error>,
///     Z: InputPin + ErrorType<Error = A::Error>,
/// {
///     let levels = pins.levels().ok()?;
///     encoder.edge(Capture { raw: latch, overflow_pending: overflow, levels })
/// }
///
/// struct Pin(bool);
/// # impl ErrorType for Pin {
/// #     type Error = Infallible;
/// # }
/// # impl InputPin for Pin {
/// #     fn is_high(&mut self) -> Result<bool, Infallible> {
/// #         Ok(self.0)
/// #     }
/// #     fn is_low(&mut self) -> Result<bool, Infallible> {
/// #         Ok(!self.0)
/// #     }
/// # }
///
/// let mut encoder = Encoder::new(EncoderConfig::new(250, 100_000), None).unwrap();
/// // A rises, then B, 1000 ticks later.
/// let mut pins = EncoderPins::new(Pin(true), Pin(false), Pin(false));
/// assert!(on_edge(&mut encoder, &mut pins, 5000, false).is_none());
/// let mut pins = EncoderPins::new(Pin(true), Pin(true), Pin(false));
/// let seen = on_edge(&mut encoder, &mut pins, 6000, false).unwrap();
/// assert_eq!((seen.edge.ticks, seen.edge.moved.0), (6000, 4_294_967));
/// ```
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
