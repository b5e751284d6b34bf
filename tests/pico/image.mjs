/**
 * What would be flashed: the loadable segments of an ELF file, by their physical addresses.
 *
 * The chip's ROM starts an image only if the last four bytes of its first 256 are the CRC-32 of the others, so that is
 * checked here too. Source: Raspberry Pi, *RP2040 Datasheet*, 2.8.1.3.1 (checksum); *Executable and Linking Format*.
 */
import { readFileSync } from 'node:fs';

const FLASH = 0x10000000;
const FLASH_BYTES = 2 * 1024 * 1024;
const PT_LOAD = 1;
const EM_ARM = 40;

/** The content of the flash from its beginning on, erased (0xff) where the file says nothing. */
export function flashOf(path) {
  const file = readFileSync(path);
  const elf = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (file.length < 52 || elf.getUint32(0) !== 0x7f454c46 || elf.getUint16(18, true) !== EM_ARM) {
    throw new Error(`${path} is not an ELF file for Arm: build firmware/examples/rp2040`);
  }
  const [table, size, count] = [elf.getUint32(28, true), elf.getUint16(42, true), elf.getUint16(44, true)];
  let end = 0;
  const flash = new Uint8Array(FLASH_BYTES).fill(0xff);
  for (let header = table; header < table + count * size; header += size) {
    const [kind, offset, , address, length] = [0, 4, 8, 12, 16].map((field) => elf.getUint32(header + field, true));
    if (kind !== PT_LOAD || length === 0) continue;
    const at = address - FLASH;
    if (at < 0 || at + length > FLASH_BYTES) {
      throw new Error(`${path} has a segment at 0x${address.toString(16)}, outside the flash of a Pico`);
    }
    flash.set(file.subarray(offset, offset + length), at);
    end = Math.max(end, at + length);
  }
  const sum = new DataView(flash.buffer).getUint32(252, true);
  if (sum !== crc32(flash.subarray(0, 252))) {
    throw new Error(`${path} would not start: the checksum of its second boot stage is wrong`);
  }
  return flash.slice(0, end);
}

/** CRC-32 of the boot ROM: polynomial 0x04c11db7, from all ones, highest bit first, not inverted. */
function crc32(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum ^= byte << 24;
    for (let bit = 0; bit < 8; bit++) sum = sum << 1 ^ (sum < 0 ? 0x04c11db7 : 0);
  }
  return sum >>> 0;
}
