/* The smallest embedding in C: an analytic picture through the wavefront door. Writes the energy it found. */
#include "pmcip.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 64
#define HEIGHT 48
#define PIXELS (WIDTH * HEIGHT)
#define SPP 16

static void expect(pmcip_status status, const char *what) {
    if (status != PMCIP_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", what, pmcip_message(status));
        exit(1);
    }
}

/* A noisy disc, of mean radiance 1, on a black ground. */
static void radiance(size_t n, const float *x, const float *y, const float *u, float *rgb) {
    for (size_t i = 0; i < n; i++) {
        float dx = x[i] - WIDTH / 2, dy = y[i] - HEIGHT / 2;
        float value = dx * dx + dy * dy < 256 ? 2 * u[i] : 0;
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = value;
    }
}

/* One iteration: plan, sample, deliver, in waves of 1000 samples. */
static void iterate(pmcip_film *film, uint64_t samples) {
    static float x[1000], y[1000], u[1000], v[1000], rgb[3000];
    static uint32_t index[1000], key[1000];
    pmcip_piece piece = {0, 0, 0};
    expect(pmcip_film_begin(film, samples), "begin");
    while (piece.end < PIXELS) {
        expect(pmcip_film_plan(film, piece.end, 1000, x, y, index, key, &piece), "plan");
        expect(pmcip_points(1, piece.samples, index, key, u, v), "points");
        radiance(piece.samples, x, y, u, rgb);
        expect(pmcip_film_deliver(film, &piece, rgb, piece.samples), "deliver");
    }
    pmcip_tally tally;
    expect(pmcip_film_end(film, &tally), "end");
}

/* What is done wrong is refused. */
static void misuse(pmcip_film *film, float *rgb) {
    pmcip_piece none = {0, 1, 7};
    if (pmcip_film_end(film, NULL) != PMCIP_STATUS_ORDER || pmcip_film_begin(NULL, 9) != PMCIP_STATUS_POINTER ||
        pmcip_film_begin(film, 0) != PMCIP_STATUS_SAMPLES || pmcip_film_deliver(film, &none, rgb, 7) == PMCIP_STATUS_OK ||
        pmcip_film_resolve(film, 99, rgb, 0, rgb) != PMCIP_STATUS_ESTIMATOR ||
        pmcip_film_resolve(film, PMCIP_ESTIMATOR_BALANCED, NULL, 0, rgb) != PMCIP_STATUS_MEMORY) {
        fprintf(stderr, "misuse was not refused\n");
        exit(1);
    }
}

int main(void) {
    static float rgb[3 * PIXELS];
    pmcip_settings settings;
    expect(pmcip_settings_new(WIDTH, HEIGHT, 2, SPP, &settings), "settings");
    size_t size = pmcip_film_size(WIDTH, HEIGHT, 0), floats = pmcip_scratch_size(WIDTH, HEIGHT);
    void *memory = malloc(size);
    float *scratch = malloc(floats * sizeof(float));
    pmcip_film *film;
    expect(pmcip_film_create(memory, size, &settings, NULL, &film), "create");
    for (int i = 0; i < SPP / 2; i++)
        iterate(film, 2 * PIXELS);
    misuse(film, rgb);

    /* Save, forget, load: the same film. */
    size_t length = pmcip_film_saved_size(film), needed;
    unsigned char *bytes = malloc(length);
    expect(pmcip_film_save(film, bytes, length), "save");
    expect(pmcip_film_load(bytes, length, NULL, 0, &needed, NULL), "ask");
    if (needed != size)
        return 1;
    expect(pmcip_film_load(bytes, length, memory, size, NULL, &film), "load");

    expect(pmcip_film_resolve(film, PMCIP_ESTIMATOR_BALANCED, scratch, floats, rgb), "resolve");
    double energy = 0, exact = 256 * 3.14159265358979;
    for (int i = 0; i < PIXELS; i++)
        energy += rgb[3 * i];
    printf("energy %.1f, exact %.1f\n", energy, exact);
    free(bytes), free(scratch), free(memory);
    return fabs(energy / exact - 1) < 0.03 ? 0 : 1;
}
