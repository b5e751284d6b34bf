//! A message as bytes, in postcard's encoding.

use postcard::ser_flavors::Flavor;
use serde::Serialize;

/// Writes a message to the start of `room` and returns its bytes; `None` if they do not fit.
pub(crate) fn written<'a, M: Serialize>(message: &M, room: &'a mut [u8]) -> Option<&'a [u8]> {
    let bytes = Bytes { room, length: 0 };
    postcard::serialize_with_flavor(message, bytes).ok()?
}

/// Bytes into a buffer. Too many are counted, not written, and told at the end: a check after each number of a message
/// would cost a microcontroller half a kilobyte.
struct Bytes<'a> {
    room: &'a mut [u8],
    /// May be beyond the room.
    length: usize,
}

impl Bytes<'_> {
    #[inline(never)]
    fn put(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        if let Some(place) = self.room.get_mut(self.length..end) {
            place.copy_from_slice(bytes);
        }
        self.length = end;
    }
}

impl<'a> Flavor for Bytes<'a> {
    type Output = Option<&'a [u8]>;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.put(&[byte]);
        Ok(())
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.put(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<Self::Output> {
        let room: &'a [u8] = self.room;
        Ok(room.get(..self.length))
    }
}

#[cfg(test)]
mod tests {
    use super::written;
    use crate::{Limits, Request};

    #[test]
    fn bytes_are_those_of_postcard_and_fit_or_are_none() {
        let (mut room, mut own) = ([0; 256], [0; 256]);
        for request in [
            Request::Stop,
            Request::Hello { nonce: 70_000 },
            Request::Configure(crate::Configuration {
                limits: Limits::DEFAULT,
                ..crate::Configuration::PASSIVE
            }),
        ] {
            let want = postcard::to_slice(&request, &mut room).expect("fits");
            assert_eq!(written(&request, &mut own), Some(&*want));
            for short in 0..want.len() {
                assert_eq!(written(&request, &mut own[..short]), None, "{short}");
            }
            let length = want.len();
            assert_eq!(written(&request, &mut own[..length]), Some(&*want));
        }
    }
}
