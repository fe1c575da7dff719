//! Whole numbers, which a file may also write as `16e6` or `16.0`.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};

/// An integer type that a twin has.
pub(super) trait Integer: TryFrom<i128> {
    /// Smallest and largest value that a file can hold.
    const RANGE: (i128, i128);
}

impl Integer for u32 {
    const RANGE: (i128, i128) = (0, u32::MAX as i128);
}

impl Integer for i32 {
    const RANGE: (i128, i128) = (i32::MIN as i128, i32::MAX as i128);
}

impl Integer for u64 {
    const RANGE: (i128, i128) = (0, i64::MAX as i128);
}

/// One of them, or several, as a file writes it.
pub(super) trait Whole<'de>: Sized {
    fn read<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

/// For `deserialize_with`.
pub(super) fn whole<'de, D: Deserializer<'de>, T: Whole<'de>>(d: D) -> Result<T, D::Error> {
    T::read(d)
}

impl<'de, T: Integer> Whole<'de> for T {
    fn read<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Number(PhantomData))
    }
}

impl<'de, T: Integer> Whole<'de> for Option<T> {
    fn read<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::read(deserializer).map(Some)
    }
}

impl<'de, T: Integer> Whole<'de> for Vec<T> {
    fn read<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let items = Vec::<Item<T>>::deserialize(deserializer)?;
        Ok(items.into_iter().map(|item| item.0).collect())
    }
}

struct Item<T>(T);

impl<'de, T: Integer> Deserialize<'de> for Item<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::read(deserializer).map(Item)
    }
}

struct Number<T>(PhantomData<T>);

impl<T: Integer> Visitor<'_> for Number<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least, most) = T::RANGE;
        write!(f, "a whole number from {least} to {most}")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        T::try_from(i128::from(value))
            .map_err(|_| E::invalid_value(Unexpected::Signed(value), &self))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        T::try_from(i128::from(value))
            .map_err(|_| E::invalid_value(Unexpected::Unsigned(value), &self))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        let (least, most) = T::RANGE;
        // `as` holds what is beyond the type's range at its ends, far outside any that is allowed.
        let whole = value as i128;
        let ok = value.fract() == 0.0 && (least..=most).contains(&whole);
        match T::try_from(whole) {
            Ok(number) if ok => Ok(number),
            _ => Err(E::invalid_value(Unexpected::Float(value), &self)),
        }
    }
}
