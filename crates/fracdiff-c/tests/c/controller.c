/* Runs the controller of a header in a loop of 100000 samples and leaves a hash of the bits of all commands: at its limits,
 * with an actuator that does half or reports nothing, by hand, with other parameters, started beside a plant that runs, and with a
 * sensor that fails. */
#include <stdint.h>

static op_t op;

uint64_t run(uint32_t samples);

uint64_t run(uint32_t samples)
{
    uint64_t hash = 14695981039346656037ULL;
    uint32_t state = 1U;
    uint32_t n;
    REAL y = 0;
    volatile REAL zero = 0;
    op_init(&op);
    for (n = 0U; n < samples; ++n) {
        const REAL r = ((n / 5000U) % 2U == 0U) ? (REAL)1 : -(REAL)0.5;
        const uint32_t manner = (n / 3000U) % 4U;
        const int fails = (n % 1000U < 15U) && ((n / 1000U) % 7U == 3U);
        REAL read;
        REAL u;
        REAL applied;
        REAL told;
        unsigned char bytes[sizeof u];
        uint32_t i;
        if (n % 20000U == 10000U) {
            op_parameters_t to = op_parameters();
            op_parameters_t bad = to;
            if (n % 40000U == 10000U) {
                CHANGE;
            }
            bad.low = bad.high;
            if (op_change(&op, &bad, r, y) || !op_change(&op, &to, r, y)) {
                return 0U;
            }
        }
        if (n % 20000U == 15000U) {
            y += op_settle(&op, y, y, (n % 40000U == 15000U) ? (REAL)0.4 : zero / zero) / (REAL)1024;
        }
        read = fails ? zero / zero : y;
        u = (manner == 3U) ? (REAL)0.25 : op_output(&op, r, read);
        applied = (manner == 2U) ? (REAL)0.5 * u : u;
        told = (n % 100U == 49U) ? zero / zero : ((n % 100U == 99U) ? -1 / zero : applied);
        if (manner == 3U) {
            op_follow(&op, r, read, told);
        } else {
            op_advance(&op, r, read, told);
        }
        state = state * 1664525U + 1013904223U;
        y += (applied - y) / (REAL)128 + ((REAL)(int32_t)(state >> 16) - (REAL)32768) / (REAL)16777216;
        for (i = 0U; i < sizeof u; ++i) {
            bytes[i] = ((const unsigned char *)&u)[i];
            hash = (hash ^ bytes[i]) * 1099511628211ULL;
        }
    }
    return hash;
}
