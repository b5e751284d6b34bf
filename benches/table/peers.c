/* C's side of the table: peers OUT TAPS, with 1024 doubles in TAPS. See `run`; LIQUID is defined where liquid-dsp is there. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef LIQUID
#include <complex.h>
#include <liquid/liquid.h>
#endif
#include "filt.h" /* filtSetup, filt, fracmemStep */

enum { SAMPLES = 200000, BATCH = 4096, RUNS = 5 };

static float x[SAMPLES], y[SAMPLES];

static double cpu_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void put(const char *folder, const char *name, const char *file, double ns, long bytes) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, file);
    FILE *out = fopen(path, "wb");
    for (int n = 0; n < SAMPLES; n++) {
        double value = y[n];
        fwrite(&value, sizeof value, 1, out);
    }
    fclose(out);
    snprintf(path, sizeof path, "%s/results.jsonl", folder);
    out = fopen(path, "a");
    fprintf(out, "{\"name\": \"%s\", \"build\": \"default\", \"ns\": %f, \"file\": \"%s\", \"bytes\": %ld}\n", name, ns, file, bytes);
    fclose(out);
}

static double now, least;
static void begin(void) { now = cpu_ns(); }
static void end(int count) {
    double ns = (cpu_ns() - now) / count;
    if (count == BATCH && ns < least) least = ns;
}

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    static double wide[1024];
    static float taps[1024];
    FILE *in = fopen(argv[2], "rb");
    if (!in || fread(wide, sizeof wide[0], 1024, in) != 1024) return 2;
    fclose(in);
    for (int j = 0; j < 1024; j++) taps[j] = (float)wide[j];
    for (int n = 0; n < SAMPLES; n++) x[n] = n < 1000 ? (float)(n * 1e-3) : 1.0f;

#ifdef LIQUID
    least = 1e30;
    for (int run = 0; run < RUNS; run++) {
        firfilt_rrrf q = firfilt_rrrf_create(taps, 1024);
        for (int n = 0; n < SAMPLES;) {
            int stop = n + BATCH < SAMPLES ? n + BATCH : SAMPLES, count = stop - n;
            begin();
            for (; n < stop; n++) {
                firfilt_rrrf_push(q, x[n]);
                firfilt_rrrf_execute(q, &y[n]);
            }
            end(count);
        }
        firfilt_rrrf_destroy(q);
    }
    put(argv[1], "liquid-dsp firfilt 1024, f32", "liquid.f64", least, 1024 * 4 * 3);
#endif

    least = 1e30;
    for (int run = 0; run < RUNS; run++) {
        filtSetup();
        for (int n = 0; n < SAMPLES;) {
            int stop = n + BATCH < SAMPLES ? n + BATCH : SAMPLES, count = stop - n;
            begin();
            for (; n < stop; n++) y[n] = fracmemStep(&filt, x[n]);
            end(count);
        }
    }
    put(argv[1], "fracmem C step, 64 taps, 32 modes, f32", "fracmem.f64", least, sizeof filt);
    return 0;
}
