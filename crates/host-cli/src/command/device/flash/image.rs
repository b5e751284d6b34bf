//! An image as its file has it: what will lie in the flash, and what it says of itself.

use super::board::{Board, Way};
use super::uf2;
use haptic_experiment::Failure;
use haptic_link::{Capabilities, Hello, IMAGE_MARK, image_digest};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An image for a board.
pub(super) struct Image {
    pub(super) file: PathBuf,
    /// Contents from the beginning of the flash on, 0 where nothing stands.
    pub(super) contents: Vec<u8>,
    identity: Identity,
}

impl Image {
    /// Reads the image of a board, and refuses every other file.
    pub(super) fn read(board: &Board, file: &Path) -> Result<Self, Failure> {
        let path = file.display();
        let refused = |why: std::fmt::Arguments<'_>| Err(Failure::bad_input(why));
        if !file.is_file() {
            return refused(format_args!(
                "no image `{path}`: change --image, or give --source to build it"
            ));
        }
        let bytes = match std::fs::read(file) {
            Ok(bytes) => bytes,
            Err(error) => return refused(format_args!("cannot read `{path}`: {error}")),
        };
        let contents = match (uf2::is_uf2(&bytes), &board.way) {
            (false, _) => uf2::flash_image(&bytes, &board.flash),
            (true, Way::Drive(_, family)) => uf2::contents(&bytes, &board.flash, *family),
            (true, Way::Probe(_)) => Err("it is UF2, and a probe takes ELF".to_owned()),
        };
        let contents = match contents {
            Ok(contents) => contents,
            Err(why) => {
                return refused(format_args!(
                    "`{path}` is not an image for this chip ({why}): build it again, or change --image or --board"
                ));
            }
        };
        match Identity::find(&contents, board.flash.start) {
            Some(identity) if identity.board == board.name => Ok(Self {
                file: file.to_owned(),
                contents,
                identity,
            }),
            Some(identity) => refused(format_args!(
                "`{path}` is for {identity}, not for {}: change or omit --image",
                board.name
            )),
            None => refused(format_args!(
                "`{path}` does not say which board it is for: build it from --source"
            )),
        }
    }

    /// Checks that the device that answers is the one that was programmed, and runs what was written.
    pub(super) fn compare(&self, hello: &Hello, abilities: &Capabilities) -> Result<(), Failure> {
        self.identity.compare(&Identity {
            board: abilities.board().to_owned(),
            firmware: hello.firmware,
            digest: abilities.image_digest,
        })
    }
}

/// Identity that an image or a device states.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Identity {
    board: String,
    firmware: [u8; 3],
    /// 0 if it has none.
    digest: u32,
}

impl std::fmt::Display for Identity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [major, minor, patch] = self.firmware;
        write!(
            f,
            "board {} with firmware {major}.{minor}.{patch}",
            self.board
        )
    }
}

impl Identity {
    /// Identity in a flash that begins at this address; see [`haptic_link::IMAGE_MARK`] and `haptic_board::Image`.
    fn find(flash: &[u8], begin: u32) -> Option<Self> {
        let mut marks = flash.windows(IMAGE_MARK.len()).enumerate();
        marks.find_map(|(at, window)| {
            let rest = &flash[at + window.len()..];
            let (name, firmware) = (rest.get(..16)?, rest.get(16..19)?);
            let length = name
                .iter()
                .position(|&byte| byte == 0)
                .unwrap_or(name.len());
            let board = std::str::from_utf8(&name[..length]).ok()?;
            let is_name = !board.is_empty() && board.chars().all(|c| c.is_ascii_graphic());
            (window == IMAGE_MARK && is_name).then(|| Self {
                board: board.to_owned(),
                firmware: [firmware[0], firmware[1], firmware[2]],
                digest: (rest.get(20..))
                    .and_then(|rest| digest(flash, begin, rest))
                    .unwrap_or(0),
            })
        })
    }

    fn compare(&self, device: &Self) -> Result<(), Failure> {
        if (&self.board, self.firmware) != (&device.board, device.firmware) {
            return Err(Failure::device(format_args!(
                "{device} answers, but the image is for {self}: give --device serial:PATH, or replug it"
            )));
        }
        if self.digest != device.digest {
            return Err(Failure::device(format_args!(
                "{device} answers, but runs another image: its digest is {:08x}, that of the file {:08x}; flash it again",
                device.digest, self.digest
            )));
        }
        Ok(())
    }
}

/// The digest that a board computes over its flash, by the addresses behind the image's identity.
fn digest(flash: &[u8], begin: u32, addresses: &[u8]) -> Option<u32> {
    let address = |number: usize| {
        let bytes = addresses.get(4 * number..4 * number + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let part = |Range { start, end }: Range<u32>| {
        let at = start.checked_sub(begin)? as usize;
        flash.get(at..at.checked_add(end.checked_sub(start)? as usize)?)
    };
    let [text, text_end, constants, constants_end, values] = [0, 1, 2, 3, 4].map(address);
    let variables = address(6)?.checked_sub(address(5)?)?;
    Some(image_digest([
        part(text?..text_end?)?,
        part(constants?..constants_end?)?,
        part(values?..values?.checked_add(variables)?)?,
    ]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_says_what_it_is() {
        let mut flash = b"123456789 haptic-device image haptic-device image\0".to_vec();
        assert_eq!(Identity::find(&flash, 0x100), None, "cut");
        flash.extend(b"nucleo-f446re\0\0\0\x01\x02\x03\0");
        // Four bytes of code, three of constants, first values of two bytes for variables elsewhere.
        for address in [0x100, 0x104, 0x104, 0x107, 0x107, 0x2000_0000, 0x2000_0002] {
            flash.extend(u32::to_le_bytes(address));
        }
        let found = Identity::find(&flash, 0x100).expect("is there");
        let identity = |board: &str, firmware, digest| Identity {
            board: board.to_owned(),
            firmware,
            digest,
        };
        // The published check value of this CRC.
        assert_eq!(found, identity("nucleo-f446re", [1, 2, 3], 0xCBF4_3926));
        // Where the file says it is not in the flash, or was not linked, there is no digest.
        assert_eq!(Identity::find(&flash, 0x101).expect("there").digest, 0);
        let length = flash.len();
        flash[length - 28..].fill(0);
        assert_eq!(Identity::find(&flash, 0).expect("there").digest, 0);
        assert_eq!(Identity::find(b"nothing", 0), None);
        found.compare(&found).expect("the same");
        for (other, words) in [
            (
                identity("nucleo-f446re", [1, 2, 2], found.digest),
                "with firmware 1.2.2 answers, but the image is for board nucleo-f446re with firmware 1.2.3",
            ),
            (
                identity("mps2-an386", [1, 2, 3], found.digest),
                "board mps2-an386 with firmware 1.2.3 answers, but",
            ),
            (
                identity("nucleo-f446re", [1, 2, 3], 0x12),
                "its digest is 00000012, that of the file cbf43926; flash it again",
            ),
        ] {
            let error = found.compare(&other).expect_err("another").to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
