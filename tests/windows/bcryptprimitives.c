/* Wine of Debian 12 lacks this library, of which Rust's random numbers need one function. The test puts it beside the program. */
#include <stddef.h>

unsigned char __stdcall SystemFunction036(void *bytes, unsigned long count);

__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *bytes, size_t count) {
  while (count > 0) {
    unsigned long part = count < 1u << 30 ? (unsigned long)count : 1ul << 30;
    if (!SystemFunction036(bytes, part))
      return 0;
    bytes += part;
    count -= part;
  }
  return 1;
}
