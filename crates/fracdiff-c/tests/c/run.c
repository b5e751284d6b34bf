/* Runs the operator of a header over 100000 samples and leaves a hash of the bits of all outputs. The header is given by
 * the build: -include, and the type and the step by name. */
#include <stdint.h>

static uint64_t hash_bytes(uint64_t hash, const unsigned char *bytes, uint32_t count)
{
    uint32_t i;
    for (i = 0U; i < count; ++i) {
        hash = (hash ^ bytes[i]) * 1099511628211ULL;
    }
    return hash;
}

static op_t op;

uint64_t run(uint32_t samples);

uint64_t run(uint32_t samples)
{
    uint64_t hash = 14695981039346656037ULL;
    uint32_t state = 1U;
    uint32_t n;
    REAL x = 0;
    op_init(&op);
    for (n = 0U; n < samples; ++n) {
        REAL y;
        state = state * 1664525U + 1013904223U;
        /* A walk, with rests of 4000 samples in which modes decay to nothing. */
        if ((n / 4000U) % 2U == 0U) {
            x += ((REAL)(int32_t)(state >> 16) - (REAL)32768) / (REAL)1048576;
        }
#ifdef LAW
        y = op_push(&op, x);
        op_advance(&op, op_depth(x));
#else
        y = op_step(&op, x);
#endif
        hash = hash_bytes(hash, (const unsigned char *)&y, (uint32_t)sizeof y);
    }
    return hash;
}
