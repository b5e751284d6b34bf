//! UF2: an image as a boot loader's drive takes it, in blocks that each say where they belong.
//!
//! ```text
//! 0 0x0A324655 │ 4 0x9E5D5157 │ 8 flags │ 12 address │ 16 bytes │ 20 block │ 24 of blocks │ 28 family │ 32 data │ 508 0x0AB16F30
//! ```
//! Numbers have 32 bits, the lowest byte first. Source: Microsoft, *USB Flashing Format (UF2)*.

use elf::abi::PT_LOAD;
use elf::endian::LittleEndian;
use elf::{ElfBytes, ParseError};
use std::ops::Range;

const MAGIC: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
/// The family stands in the block.
const HAS_FAMILY: u32 = 0x2000;
const BLOCK: usize = 512;
/// Bytes of a block: what the chips write to their flash at once.
const PAGE: usize = 256;
/// Bytes that the chips erase at once. Whole ones are sent, as the RP2040 may leave others unwritten (erratum E14).
const SECTOR: usize = 4096;

/// The flash as an ELF file fills it, up to the end of a sector; 0 where nothing stands.
pub(super) fn flash_image(file: &[u8], flash: &Range<u32>) -> Result<Vec<u8>, String> {
    let refused = |error| {
        if matches!(error, ParseError::SliceReadError(_)) {
            "it is cut short".to_owned()
        } else if matches!(error, ParseError::BadMagic(_)) {
            "it is neither ELF nor UF2".to_owned()
        } else {
            error.to_string()
        }
    };
    let elf = ElfBytes::<LittleEndian>::minimal_parse(file).map_err(refused)?;
    let mut image = Vec::new();
    let segments = elf.segments().into_iter().flatten();
    for segment in segments.filter(|segment| segment.p_type == PT_LOAD && segment.p_filesz > 0) {
        let data = elf.segment_data(&segment).map_err(refused)?;
        put(&mut image, flash, segment.p_paddr, data)?;
    }
    whole(image)
}

/// Puts data at its address.
fn put(image: &mut Vec<u8>, flash: &Range<u32>, address: u64, data: &[u8]) -> Result<(), String> {
    let (begin, end) = (u64::from(flash.start), u64::from(flash.end));
    let fits = address >= begin && address.saturating_add(data.len() as u64) <= end;
    if !fits {
        return Err(format!(
            "{} bytes at {address:#x} lie outside its flash, {begin:#x} to {end:#x}",
            data.len()
        ));
    }
    let at = (address - begin) as usize;
    image.resize(image.len().max(at + data.len()), 0);
    image[at..at + data.len()].copy_from_slice(data);
    Ok(())
}

/// Up to the end of a sector.
fn whole(mut image: Vec<u8>) -> Result<Vec<u8>, String> {
    if image.is_empty() {
        return Err("it has nothing to load".to_owned());
    }
    image.resize(image.len().next_multiple_of(SECTOR), 0);
    Ok(image)
}

/// True for a file of blocks.
pub(super) fn is_uf2(file: &[u8]) -> bool {
    file.starts_with(&MAGIC[0].to_le_bytes())
}

/// The flash as the blocks for this family fill it; those for others are skipped, as the boot loader does.
pub(super) fn contents(file: &[u8], flash: &Range<u32>, family: u32) -> Result<Vec<u8>, String> {
    let (mut image, mut found, mut stated, mut in_order) = (Vec::new(), 0, 0, true);
    let (blocks, rest) = file.as_chunks::<BLOCK>();
    for block in blocks {
        let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| block[at + byte]));
        let marks = [word(0), word(4), word(BLOCK - 4)];
        let data = block[32..BLOCK - 4].get(..word(16) as usize);
        let Some(data) = data.filter(|_| marks == [MAGIC[0], MAGIC[1], MAGIC_END]) else {
            return Err("it has a block that is damaged".to_owned());
        };
        if word(8) == HAS_FAMILY && word(28) == family {
            put(&mut image, flash, word(12).into(), data)?;
            in_order &= word(20) == found;
            (found, stated) = (found + 1, word(24));
        }
    }
    if found != stated || !rest.is_empty() {
        return Err(format!("{found} of {stated} blocks are there"));
    }
    if !in_order {
        return Err("a block is missing, and another is there twice".to_owned());
    }
    whole(image)
}

/// The blocks of an image of whole pages that begins at this address.
pub(super) fn blocks(image: &[u8], address: u32, family: u32) -> Vec<u8> {
    let count = (image.len() / PAGE) as u32;
    let mut file = Vec::with_capacity(count as usize * BLOCK);
    for (number, page) in (0..).zip(image.chunks_exact(PAGE)) {
        let [first, second] = MAGIC;
        let address = address + number * PAGE as u32;
        let end = file.len() + BLOCK;
        let what = [first, second, HAS_FAMILY, address];
        for word in [what, [PAGE as u32, number, count, family]].concat() {
            file.extend(word.to_le_bytes());
        }
        file.extend(page);
        file.resize(end - 4, 0);
        file.extend(MAGIC_END.to_le_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLASH: Range<u32> = 0x1000_0000..0x1020_0000;

    /// An ELF file of an Arm with segments at these addresses: header of 52 bytes, program headers of 32, data.
    fn elf(segments: &[(u32, &[u8])]) -> Vec<u8> {
        let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0\x28\0\x01\0\0\0".to_vec();
        let words = |file: &mut Vec<u8>, words: &[u32]| {
            file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        };
        words(&mut file, &[0, 52, 0, 0]);
        let count = segments.len() as u16;
        for half in [52, 32, count, 40, 0, 0] {
            file.extend(half.to_le_bytes());
        }
        let mut at = 52 + 32 * segments.len() as u32;
        for (address, data) in segments {
            let length = data.len() as u32;
            // It runs elsewhere than where it is kept, as variables do.
            let runs_at = 0x2000_0000;
            let header = [PT_LOAD, at, runs_at, *address, length, length, 4, 4];
            words(&mut file, &header);
            at += length;
        }
        let data = segments.iter().flat_map(|(_, data)| data.iter());
        file.extend(data);
        file
    }

    #[test]
    fn blocks_cover_whole_sectors_and_say_where_they_belong() {
        let file = elf(&[(FLASH.start, b"boot"), (FLASH.start + 0x1100, b"code")]);
        let image = flash_image(&file, &FLASH).expect("an image");
        assert_eq!(image.len(), 2 * SECTOR);
        let uf2 = blocks(&image, FLASH.start, 0xe48b_ff56);
        assert_eq!(uf2.len(), 32 * BLOCK);
        for (number, block) in uf2.chunks(BLOCK).enumerate() {
            let word = |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().expect("four"));
            let number = number as u32;
            assert_eq!(&block[..4], b"UF2\n");
            assert_eq!([word(4), word(508)], [0x9E5D_5157, 0x0AB1_6F30]);
            assert_eq!(
                [word(8), word(12)],
                [0x2000, 0x1000_0000 + 256 * number],
                "{number}"
            );
            assert_eq!(
                [word(16), word(20), word(24), word(28)],
                [256, number, 32, 0xe48b_ff56]
            );
            let data = match number {
                0 => &b"boot"[..],
                17 => b"code",
                _ => b"",
            };
            assert_eq!(&block[32..32 + data.len()], data, "{number}");
            let rest = &block[32 + data.len()..508];
            assert!(rest.iter().all(|&byte| byte == 0), "{number}");
        }
        // And back, whatever there is for other chips.
        let both = [uf2.clone(), blocks(&[1; SECTOR], 0, 0)].concat();
        assert_eq!(contents(&both, &FLASH, 0xe48b_ff56), Ok(image));
        let refused = |file: &[u8], family| contents(file, &FLASH, family).expect_err("refused");
        assert!(is_uf2(&uf2) && !is_uf2(&file));
        assert_eq!(refused(&uf2, 1), "it has nothing to load");
        assert_eq!(
            refused(&uf2[BLOCK..], 0xe48b_ff56),
            "31 of 32 blocks are there"
        );
        assert_eq!(
            refused(&uf2[..uf2.len() - 1], 0xe48b_ff56),
            "31 of 32 blocks are there"
        );
        assert!(refused(&both, 0).contains("0x0 lie outside"));
        let mut doubled = uf2.clone();
        doubled.copy_within(4 * BLOCK..5 * BLOCK, 5 * BLOCK);
        assert!(refused(&doubled, 0xe48b_ff56).ends_with("there twice"));
        let mut damaged = uf2;
        damaged[BLOCK + 17] = 2;
        assert_eq!(
            refused(&damaged, 0xe48b_ff56),
            "it has a block that is damaged"
        );
    }

    #[test]
    fn what_is_not_for_this_flash_is_refused() {
        let refused = |file: &[u8]| flash_image(file, &FLASH).expect_err("refused");
        let other = refused(&elf(&[(0x0800_0000, b"STM32")]));
        assert!(
            other.starts_with("5 bytes at 0x8000000 lie outside"),
            "{other}"
        );
        let end = refused(&elf(&[(FLASH.end - 2, b"end")]));
        assert!(end.contains("0x101ffffe"), "{end}");
        refused(&elf(&[]));
        assert_eq!(refused(&[b'x'; 100]), "it is neither ELF nor UF2");
        let file = elf(&[(FLASH.start, b"boot")]);
        for length in 0..file.len() {
            assert_eq!(refused(&file[..length]), "it is cut short", "{length}");
        }
    }
}
