//! What a served board says of its last fault: a code says less than the board that failed knows.

use core::fmt;
use std::string::String;

/// Words of a board about its last fault, with the remedy, and where its cause lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardTrouble {
    /// In whole words.
    pub words: String,
    /// Where to look.
    pub cause: TroubleCause,
}

impl BoardTrouble {
    /// Of the board itself.
    #[must_use]
    pub const fn of_board(words: String) -> Self {
        Self {
            words,
            cause: TroubleCause::Board,
        }
    }
}

impl fmt::Display for BoardTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

/// Where the cause of a board's fault lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TroubleCause {
    /// In the board: a fault of its own, or an answer that cannot be.
    Board,
    /// Nothing comes from it any more: unplugged, switched off, or its emulator has ended. The link is lost.
    Gone,
    /// This machine let it wait for too long.
    HostLate,
}
