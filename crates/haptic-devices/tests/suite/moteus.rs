//! A moteus axis behind the device's side of the link, on an emulated servo, in virtual time.

mod corrupted;
mod servo;
pub(crate) mod world;
