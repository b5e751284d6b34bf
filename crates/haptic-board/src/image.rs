//! Identity of an image: for `host-cli device flash` in its file, and for a host that asks the board.

use haptic_link::{Capabilities, IMAGE_MARK, image_digest};

/// Board and version of an image, and where its parts lie. [`image!`](crate::image!) makes it where `cortex-m-rt` links, [`Image::new`]
/// elsewhere; keep it in a static.
#[derive(Debug)]
#[repr(C)]
pub struct Image {
    mark: [u8; 20],
    board: [u8; 16],
    version: [u8; 3],
    zero: u8,
    bounds: [&'static [u8; 0]; 7],
    sections: fn() -> [&'static [u8]; 3],
}

impl Image {
    /// An image of a board, whose name has at most 16 bytes, and a version: major, minor, patch. It
    /// reports no digest.
    ///
    /// ```
    /// static IMAGE: haptic_board::Image = haptic_board::Image::new("my-board", [0, 1, 0]);
    /// # assert_eq!(IMAGE.version(), [0, 1, 0]);
    /// ```
    #[must_use]
    pub const fn new(board: &str, version: [u8; 3]) -> Self {
        Self::linked(board, version, [&[]; 7], || [&[] as &[u8]; 3])
    }

    /// See [`image!`](crate::image!).
    #[doc(hidden)]
    #[must_use]
    pub const fn linked(
        board: &str,
        version: [u8; 3],
        bounds: [&'static [u8; 0]; 7],
        sections: fn() -> [&'static [u8]; 3],
    ) -> Self {
        Self {
            mark: IMAGE_MARK,
            board: Capabilities::board_name(board),
            version,
            zero: 0,
            bounds,
            sections,
        }
    }

    /// Address and length of text, constants and values of variables, for [`image!`](crate::image!); `None` of bounds that no linker
    /// script gives.
    #[doc(hidden)]
    #[must_use]
    pub fn parts(bounds: [usize; 7]) -> Option<[(usize, usize); 3]> {
        /// No microcontroller addresses more flash.
        const MOST: usize = 1 << 28;
        let [
            text,
            text_end,
            constants,
            constants_end,
            values,
            variables,
            variables_end,
        ] = bounds;
        let part = |begin: usize, [from, to]: [usize; 2]| {
            let length = to.checked_sub(from).filter(|length| *length <= MOST)?;
            (begin > 0).then_some((begin, length))
        };
        Some([
            part(text, [text, text_end])?,
            part(constants, [constants, constants_end])?,
            part(values, [variables, variables_end])?,
        ])
    }

    /// The version passed to `image!`: major, minor, patch.
    #[must_use]
    pub const fn version(&self) -> [u8; 3] {
        self.version
    }

    /// The [`image_digest`] of the image in the flash; 0 if its location is unknown. For
    /// [`DeviceSession::set_image_digest`](haptic_remote::DeviceSession::set_image_digest). Takes
    /// 50 to 100 cycles a byte, 14 with the feature `crc-table`.
    #[must_use]
    pub fn digest(&self) -> u32 {
        // All of it is kept, for `device flash`.
        core::hint::black_box(self);
        image_digest((self.sections)())
    }
}

/// The [`Image`] of a board and a version that the linker script of `cortex-m-rt` lays out. The word `unsafe` promises that this script
/// has laid it out: its parts are then read from the flash. Symbols out of order, or farther apart than any flash is large, give no
/// digest.
///
/// ```no_run
/// static IMAGE: haptic_board::Image = haptic_board::image!(unsafe "my-board", [0, 1, 0]);
/// ```
#[macro_export]
macro_rules! image {
    (unsafe $board:expr, $version:expr) => {{
        #[allow(non_upper_case_globals, reason = "names of the linker script")]
        mod linked {
            unsafe extern "C" {
                safe static __stext: [u8; 0];
                safe static __etext: [u8; 0];
                safe static __srodata: [u8; 0];
                safe static __erodata: [u8; 0];
                safe static __sidata: [u8; 0];
                safe static __sdata: [u8; 0];
                safe static __edata: [u8; 0];
            }
            pub(super) static BOUNDS: [&[u8; 0]; 7] =
                [&__stext, &__etext, &__srodata, &__erodata, &__sidata, &__sdata, &__edata];

            pub(super) fn sections() -> [&'static [u8]; 3] {
                let bounds = BOUNDS.map(|bound| ::core::ptr::from_ref(bound).expose_provenance());
                let parts = $crate::Image::parts(bounds).unwrap_or_default();
                parts.map(|(begin, length)| match length {
                    0 => &[],
                    // SAFETY: the linker script puts these parts of the image there, in flash, which nobody writes while it runs.
                    _ => unsafe {
                        ::core::slice::from_raw_parts(::core::ptr::with_exposed_provenance(begin), length)
                    },
                })
            }
        }
        $crate::Image::linked($board, $version, linked::BOUNDS, linked::sections)
    }};
}
