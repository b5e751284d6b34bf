//! `device monitor`.
