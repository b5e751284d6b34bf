//! Tests that say `?`.

use std::error::Error;

/// The end of a test that asks for values with `?`: an error panics at the place where it was asked, in its own words.
pub type Tested = Result<(), Never>;

/// No test returns an error.
#[derive(Debug)]
pub enum Never {}

impl<E: Error> From<E> for Never {
    #[track_caller]
    fn from(error: E) -> Self {
        panic!("{error}: {error:?}")
    }
}
