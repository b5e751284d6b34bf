//! `Deserialize` for structures of many numbers and for long arrays, small on a microcontroller: the derived one has
//! a way out after each field, 28 B of code; this one reads all, and reports an error at the end. Fields in order only, as
//! postcard has them.

use core::{fmt, marker::PhantomData};
use serde::{
    Deserialize,
    de::{Deserializer, Error, SeqAccess, Visitor},
};

/// A value in place of one that is missing; nobody sees it.
pub(crate) trait Blank {
    const BLANK: Self;
}

macro_rules! blank {
    ($($number:ty: $blank:expr),+) => {
        $(impl Blank for $number {
            const BLANK: Self = $blank;
        })+
    };
}
pub(crate) use blank;

blank!(f32: 0.0, u8: 0, Fixed: Fixed(0));

/// A number of two bytes, whatever its value.
#[derive(Deserialize)]
pub(crate) struct Fixed(#[serde(with = "postcard::fixint::le")] u16);

impl From<Fixed> for u16 {
    fn from(fixed: Fixed) -> Self {
        fixed.0
    }
}

/// The values of a sequence, one after another.
pub(crate) struct Values<A> {
    sequence: A,
    whole: bool,
}

impl<'de, A: SeqAccess<'de>> Values<A> {
    pub(crate) fn new(sequence: A) -> Self {
        Self {
            sequence,
            whole: true,
        }
    }

    #[inline(never)]
    pub(crate) fn next<T: Deserialize<'de> + Blank>(&mut self) -> T {
        if let Ok(Some(value)) = self.sequence.next_element() {
            return value;
        }
        self.whole = false;
        T::BLANK
    }

    /// `value`, if nothing was missing.
    pub(crate) fn done<T>(self, value: T) -> Result<T, A::Error> {
        if self.whole {
            Ok(value)
        } else {
            Err(A::Error::custom("a value is missing"))
        }
    }
}

/// The next value of its field's type, or read as another and converted.
macro_rules! next {
    ($values:ident) => {
        $values.next()
    };
    ($values:ident as $other:ty) => {
        $values.next::<$other>().into()
    };
}
pub(crate) use next;

/// A structure with its `Deserialize`; fields with `as TYPE` are read as that and converted.
macro_rules! in_order {
    ($(#[$about:meta])* pub struct $structure:ident {
        $($(#[$meta:meta])* pub $field:ident: $number:ty $(as $other:ty)?,)+
    }) => {
        $(#[$about])*
        pub struct $structure {
            $($(#[$meta])* pub $field: $number,)+
        }

        impl<'de> serde::Deserialize<'de> for $structure {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                struct Fields;

                impl<'de> serde::de::Visitor<'de> for Fields {
                    type Value = $structure;

                    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                        f.write_str(concat!("the fields of ", stringify!($structure)))
                    }

                    fn visit_seq<A: serde::de::SeqAccess<'de>>(
                        self,
                        sequence: A,
                    ) -> Result<$structure, A::Error> {
                        let mut values = $crate::in_order::Values::new(sequence);
                        let fields = $structure {
                            $($field: $crate::in_order::next!(values $(as $other)?)),+
                        };
                        values.done(fields)
                    }
                }

                from.deserialize_struct(stringify!($structure), &[$(stringify!($field)),+], Fields)
            }
        }
    };
}
pub(crate) use in_order;

/// Reads an array as serde does it, each number in its own place.
pub(crate) fn array<'de, D: Deserializer<'de>, const N: usize>(
    from: D,
) -> Result<[f32; N], D::Error> {
    from.deserialize_tuple(N, Numbers(PhantomData))
}

struct Numbers<const N: usize>(PhantomData<[f32; N]>);

impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
    type Value = [f32; N];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{N} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<[f32; N], A::Error> {
        let mut values = Values::new(sequence);
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = values.next();
        }
        values.done(numbers)
    }
}
