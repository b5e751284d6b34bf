//! The serial number tells a device from every other of its kind.

/// Serial number of a device: 6 to 32 letters, digits and any of `-_.:+`. [`Hello`](crate::Hello) has it.
///
/// A number that a factory gives to all, such as `000001` or `12345678`, does not count.
///
/// ```
/// use haptic_link::SerialNumber;
///
/// let flash = SerialNumber::of_chip(&[0xe6, 0x61, 0x24, 0x83, 0xcb, 0x1b, 0x92, 0x21]);
/// assert_eq!(flash.text(), Some("E6612483CB1B9221"));
/// assert_eq!(SerialNumber::of_chip(&[0xff; 8]), SerialNumber::NONE);
/// assert_eq!(SerialNumber::named("12345678"), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialNumber([u8; Self::MOST]);

impl SerialNumber {
    /// Fewest characters of a serial number.
    pub const LEAST: usize = 6;
    /// Most characters of a serial number, and its bytes in a message.
    pub const MOST: usize = 32;
    /// The device knows no number of its own.
    pub const NONE: Self = Self([0; Self::MOST]);

    /// The unique number of a chip or its flash, at most 16 bytes, as hexadecimal digits. None if all bits are equal, as in a memory
    /// that was never written.
    #[must_use]
    pub fn of_chip(unique: &[u8]) -> Self {
        let mut text = [0; Self::MOST];
        for (pair, byte) in text.chunks_exact_mut(2).zip(unique) {
            pair.copy_from_slice(&[byte >> 4, byte & 0xf].map(|digit| DIGITS[usize::from(digit)]));
        }
        Self::of_wire(text)
    }

    /// The number as a maker or an operating system writes it; `None` for any other text.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        let mut padded = [0; Self::MOST];
        (padded.get_mut(..text.len())?).copy_from_slice(text.as_bytes());
        Some(Self::of_wire(padded)).filter(|number| *number != Self::NONE)
    }

    /// The number in a message, which may hold anything; none if it is not one.
    #[must_use]
    pub fn of_wire(bytes: [u8; Self::MOST]) -> Self {
        let number = Self(bytes);
        let text = number.written();
        let allowed = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.:+".contains(byte);
        let is_one = text.len() >= Self::LEAST
            && text.iter().all(allowed)
            && !text.windows(2).all(|pair| follows(pair[0], pair[1]))
            && bytes[text.len()..].iter().all(|&byte| byte == 0);
        if is_one { number } else { Self::NONE }
    }

    /// Filled up with zeros, as the message has it.
    #[must_use]
    pub const fn bytes(self) -> [u8; Self::MOST] {
        self.0
    }

    /// The number as text; `None` without one.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        let text = core::str::from_utf8(self.written()).ok();
        text.filter(|text| !text.is_empty())
    }

    fn written(&self) -> &[u8] {
        let mut parts = self.0.split(|&byte| byte == 0);
        parts.next().unwrap_or_default()
    }
}

const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// True of characters that follow each other where somebody counted or filled up: 0001, 12345678, 0123456789ABCDEF.
fn follows(before: u8, next: u8) -> bool {
    next.wrapping_sub(before) <= 1 || before == b'9' && b"0Aa".contains(&next)
}
