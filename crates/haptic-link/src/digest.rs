//! The digest by which both ends know a configuration.

use crate::bytes::written;
use crate::configuration::Configuration;
use crate::frame::CRC;

/// Digest of what two hands must share: CRC-32 (as zlib's) over numbers of eight little-endian bytes each, then a text.
///
/// ```
/// use haptic_link::hand_digest;
///
/// assert_eq!(hand_digest(&[300.0, 10.0, 0.5], "full"), hand_digest(&[300.0, 10.0, 0.5], "full"));
/// assert_ne!(hand_digest(&[300.0, 10.0, 0.5], "full"), hand_digest(&[300.0, 11.0, 0.5], "full"));
/// ```
#[must_use]
pub fn hand_digest(numbers: &[f64], text: &str) -> u32 {
    let mut digest = CRC.digest();
    for number in numbers {
        digest.update(&number.to_le_bytes());
    }
    digest.update(text.as_bytes());
    digest.finalize()
}

/// Digest of a configuration and its coefficients: CRC-32 (as zlib's) over the bytes of the
/// [`Configuration`] as they are on the wire, then each coefficient as four little-endian bytes.
///
/// ```
/// use haptic_link::{Configuration, DigestBuilder};
///
/// let configuration = Configuration { stiffness_n_per_m: 500.0, ..Configuration::PASSIVE };
/// let digest = DigestBuilder::new(&configuration).coefficients(&[1.0, -0.5]).finish();
/// let other = DigestBuilder::new(&configuration).coefficients(&[1.0, -0.25]).finish();
/// assert_ne!(digest, other);
/// ```
#[derive(Clone)]
pub struct DigestBuilder(crc::Digest<'static, u32, crc::NoTable>);

impl core::fmt::Debug for DigestBuilder {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DigestBuilder").finish_non_exhaustive()
    }
}

impl DigestBuilder {
    /// Over the configuration; the coefficients follow.
    #[must_use]
    pub fn new(configuration: &Configuration) -> Self {
        let mut digest = CRC.digest();
        // Longer than any configuration can be on the wire.
        let mut bytes = [0; 192];
        // A message of fixed size into a buffer that is longer cannot fail.
        digest.update(written(configuration, &mut bytes).unwrap_or_default());
        Self(digest)
    }

    /// Adds coefficients.
    #[must_use]
    pub fn coefficients(mut self, values: &[f32]) -> Self {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
        self
    }

    /// Adds the workspace of each axis, behind the coefficients: as they are on the wire, without their number.
    #[cfg(feature = "several-axes")]
    #[must_use]
    pub fn workspace(mut self, workspace: &crate::WorkspaceBox) -> Self {
        for axis in &workspace.axes {
            self = self.coefficients(&[axis.low_m, axis.high_m, axis.soft_m]);
        }
        self
    }

    /// The digest.
    #[must_use]
    pub fn finish(self) -> u32 {
        self.0.finalize()
    }
}
