//! Operators as lists of single-precision numbers at 1 kHz, from `lists.txt`, which the host writes:
//! `UPDATE_FIRMWARE_TABLES=1 cargo test --test firmware`.

/// An operator, see `fracdiff::portable`.
pub(crate) struct List {
    pub(crate) name: &'static str,
    pub(crate) form: &'static str,
    pub(crate) integer: i8,
    bits: &'static str,
}

/// One from each line `name | form | integer | bits of each value`.
pub(crate) fn all() -> impl Iterator<Item = List> {
    include_str!("lists.txt").lines().map(|line| {
        let mut cells = line.split(" | ");
        let mut next = || cells.next().expect("four cells");
        List {
            name: next(),
            form: next(),
            integer: next().parse().expect("a number"),
            bits: next(),
        }
    })
}

impl List {
    /// Its values, so many as it has.
    pub(crate) fn values(&self) -> ([f32; 256], usize) {
        let mut values = [0.0; 256];
        for (value, bits) in values.iter_mut().zip(self.bits.split(' ')) {
            *value = f32::from_bits(u32::from_str_radix(bits, 16).expect("eight digits"));
        }
        (values, self.bits.split(' ').count())
    }
}
