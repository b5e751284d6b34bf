/* C's side of the comparison with peers: peers_c OUT TAPS. TAPS holds 1024 doubles. See `run`. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <complex.h>
#include <liquid/liquid.h>
#include "filt.h" /* filtSetup, filt, fracmemStep */

enum { SAMPLES = 200000, BATCH = 4096, RUNS = 9 };

static float x[SAMPLES], y[SAMPLES];

static double cpu_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void put(const char *folder, const char *name, const char *file, double ns, long bytes, int no_std) {
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
    fprintf(out, "{\"name\": \"%s\", \"file\": \"%s\", \"ns\": %f, \"bytes\": %ld, \"no_std\": %s, \"takes\": \"sample\"}\n",
            name, file, ns, bytes, no_std ? "true" : "false");
    fclose(out);
    printf("%s: %.2f ns\n", name, ns);
}

static double now, least;
static void begin(void) { now = cpu_ns(); }
static void end(int count) {
    double ns = (cpu_ns() - now) / count;
    if (count == BATCH && ns < least) least = ns;
}

int main(int argc, char **argv) {
    if (argc < 4) return 2;
    static double wide[1024];
    static float taps[1024];
    FILE *in = fopen(argv[2], "rb");
    if (!in || fread(wide, sizeof wide[0], 1024, in) != 1024) return 2;
    fclose(in);
    for (int j = 0; j < 1024; j++) taps[j] = (float)wide[j];
    for (int n = 0; n < SAMPLES; n++) x[n] = n < 1000 ? (float)(n * 1e-3) : 1.0f;

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
    char name[256];
    snprintf(name, sizeof name, "liquid-dsp %s firfilt_rrrf 1024, f32", argv[3]);
    char file[256];
    snprintf(file, sizeof file, "liquid_%s.f64", argv[3]);
    for (char *c = file; *c; c++) if (*c == ' ' || *c == '/') *c = '_';
    put(argv[1], name, file, least, 1024 * 4 * 3, 0);

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
    put(argv[1], "fracmem C step, 64 taps, 32 modes, f32", "fracmem.f64", least, sizeof filt, 1);
    return 0;
}
