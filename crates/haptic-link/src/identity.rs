//! The device that answers, and what it can do.

use crate::status::Status;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The first answer of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Hello {
    /// From the request.
    #[serde(with = "postcard::fixint::le")]
    pub nonce: u32,
    /// The number of the connection, which every frame of the host carries from now on; another one for each nonce,
    /// never 0.
    #[serde(with = "postcard::fixint::le")]
    pub connection: u32,
    /// Firmware version: major, minor, patch.
    pub firmware: [u8; 3],
    /// Another number after each power-up or reset, as far as the board can tell.
    #[serde(with = "postcard::fixint::le")]
    pub boot: u32,
    /// State and fault.
    pub status: Status,
}

/// A device and its abilities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Capabilities {
    /// Name of the board, UTF-8, filled up with zeros.
    pub board: [u8; 16],
    /// Degrees of freedom, 1 to 3.
    pub axes: u8,
    /// The plant is simulated on the device: no actuator, no sensor.
    pub simulated: bool,
    /// Shortest period of a tick, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_min_us: u32,
    /// Longest, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_max_us: u32,
    /// Largest force that the actuator can make, N.
    pub force_max_n: f32,
    /// Largest rate of force, N/s.
    pub force_rate_max_n_per_s: f32,
    /// Position of one count of the sensor, m; 0 for none.
    pub position_resolution_m: f32,
    /// Room for coefficients.
    #[serde(with = "postcard::fixint::le")]
    pub coefficients_max: u16,
    /// Room for modes of a full memory.
    #[serde(with = "postcard::fixint::le")]
    pub modes_max: u16,
    /// Largest degree of a recursion and number of sections.
    #[serde(with = "postcard::fixint::le")]
    pub degree_max: u16,
    /// Samples that the flight recorder keeps.
    #[serde(with = "postcard::fixint::le")]
    pub flight_samples: u16,
}

impl Capabilities {
    /// The board's name.
    #[must_use]
    pub fn board(&self) -> &str {
        let end = self.board.iter().position(|&byte| byte == 0);
        let name = &self.board[..end.unwrap_or(self.board.len())];
        core::str::from_utf8(name).unwrap_or("?")
    }

    /// A name of at most 16 bytes, cut after them, as the field wants it.
    #[must_use]
    pub const fn board_name(name: &str) -> [u8; 16] {
        let (bytes, mut board, mut i) = (name.as_bytes(), [0; 16], 0);
        while i < bytes.len() && i < board.len() {
            board[i] = bytes[i];
            i += 1;
        }
        board
    }
}
