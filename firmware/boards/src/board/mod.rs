//! Pins and constants of the boards, and nothing else.

#[cfg(feature = "board-mps2")]
pub(crate) mod mps2;
#[cfg(feature = "board-nucleo-f446re")]
pub(crate) mod nucleo_f446re;
