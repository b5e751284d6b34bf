//! Histories as data (feature `serde`): arrays of any length, which serde alone does not have.

use core::fmt;
use core::marker::PhantomData;
use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A tuple of N values.
pub(crate) fn serialize<T: Serialize, S: Serializer, const N: usize>(
    array: &[T; N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(N)?;
    for value in array {
        tuple.serialize_element(value)?;
    }
    tuple.end()
}

/// Reads the tuple back; another number of values is an error.
pub(crate) fn deserialize<'de, T, D: Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<[T; N], D::Error>
where
    T: Deserialize<'de> + Copy + Default,
{
    struct Values<T, const N: usize>(PhantomData<T>);

    impl<'de, T: Deserialize<'de> + Copy + Default, const N: usize> Visitor<'de> for Values<T, N> {
        type Value = [T; N];

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "{N} values")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<[T; N], A::Error> {
            let mut array = [T::default(); N];
            for (index, slot) in array.iter_mut().enumerate() {
                let value = values.next_element()?;
                *slot = value.ok_or_else(|| A::Error::invalid_length(index, &self))?;
            }
            Ok(array)
        }
    }

    deserializer.deserialize_tuple(N, Values(PhantomData))
}

/// A place among MOST; another one is an error.
pub(crate) fn below<'de, D: Deserializer<'de>, const MOST: usize>(
    deserializer: D,
) -> Result<usize, D::Error> {
    let place = usize::deserialize(deserializer)?;
    if place < MOST.max(1) {
        Ok(place)
    } else {
        Err(D::Error::custom("a position of a history is outside it"))
    }
}
