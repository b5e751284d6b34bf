// GCC's runtime of ThreadSanitizer has these under their plain names alone, which it watches too; rustc asks for both.
#include <cstring>

extern "C" {
void *__tsan_memcpy(void *to, const void *from, std::size_t bytes) { return std::memcpy(to, from, bytes); }
void *__tsan_memmove(void *to, const void *from, std::size_t bytes) { return std::memmove(to, from, bytes); }
void *__tsan_memset(void *to, int byte, std::size_t bytes) { return std::memset(to, byte, bytes); }
}
