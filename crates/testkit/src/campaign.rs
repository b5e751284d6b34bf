//! Tests that try so many cases in a landing, and more where somebody asks for a campaign.

use std::fmt::Debug;
use std::str::FromStr;

/// Cases to try: `CAMPAIGN_CASES`, or so many.
///
/// # Panics
/// If `CAMPAIGN_CASES` is no number.
#[must_use]
pub fn cases<T: FromStr<Err: Debug>>(usual: T) -> T {
    std::env::var("CAMPAIGN_CASES").map_or(usual, |cases| cases.parse().expect("CAMPAIGN_CASES"))
}
