/* Signals as sums of harmonics along a slow trajectory. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>

#include "driver.h"
#include "fixtures.h"

#define SAMPLES 9
#define SEGMENTS 2
#define SIGNALS 3
#define ORDERS 3

/* All arguments of sm_harmonic_motion. */
typedef struct {
    sm_harmonic_sum sum;
    size_t segments, samples;
    sm_segment segment[SEGMENTS];
    sm_segment *first;
    double *shape, *coefficient, *times, *motion;
} harmonics_call;

static const int32_t orders[2 * ORDERS] = {1, 0, -2, 3, 4, -1};

static harmonics_call new_call(void) {
    harmonics_call c = {.segments = SEGMENTS,
                        .samples = SAMPLES,
                        .shape = new_doubles(SM_MODES * SIGNALS),
                        .coefficient = new_doubles((SEGMENTS + 1) * SIGNALS * 2 * ORDERS),
                        .times = new_doubles(SAMPLES),
                        .motion = new_doubles(SAMPLES * SIGNALS)};
    for (int k = 0; k < SEGMENTS; k++) {
        const sm_segment g = {.start = 1.0 + 2.0 * k,
                              .duration = 2.0,
                              .amplitude_start = {1.0, 0.5, -0.2, 0.3},
                              .amplitude_end = {1.0, 0.5, -0.2, 0.3},
                              .angle = {0.3 + 2.0 * k, 0.1 + 3.4 * k},
                              .frequency = {1.0, 1.7}};
        c.segment[k] = g;
    }
    for (int k = 0; k < SM_MODES * SIGNALS; k++) c.shape[k] = 0.1 * k;
    for (int k = 0; k < (SEGMENTS + 1) * SIGNALS * 2 * ORDERS; k++)
        c.coefficient[k] = cos(0.7 * k);
    for (int k = 0; k < SAMPLES; k++) c.times[k] = 1.0 + 0.5 * k;
    c.sum = (sm_harmonic_sum){SM_MODES, ORDERS, orders, SIGNALS, c.shape, c.coefficient};
    return c;
}

static void free_call(harmonics_call *c) {
    free(c->shape);
    free(c->coefficient);
    free(c->times);
    free(c->motion);
}

static sm_status add_up(void *arguments) {
    harmonics_call *c = arguments;
    return sm_harmonic_motion(&c->sum, c->segments, c->first, c->samples, c->times, c->motion);
}

/* Constant amplitudes, coefficients straight in time: written out at one sample. */
static double expected(const harmonics_call *c, double time, int s) {
    const int g = time < 3.0 ? 0 : 1;
    const double r = (time - c->segment[g].start) / 2.0;
    const double theta[] = {0.3 + (time - 1.0), 0.1 + 1.7 * (time - 1.0)};
    double value = 0.0;
    for (int j = 0; j < SM_MODES; j++) {
        const double *a = c->segment[0].amplitude_start + 2 * j;
        value += c->shape[j * SIGNALS + s] * creal((a[0] + I * a[1]) * cexp(I * theta[j]));
    }
    for (int q = 0; q < ORDERS; q++) {
        double complex part[2];
        for (int end = 0; end < 2; end++) {
            const double *row = c->coefficient + ((g + end) * SIGNALS + s) * 2 * ORDERS;
            part[end] = row[q] + I * row[ORDERS + q];
        }
        const double angle = orders[2 * q] * theta[0] + orders[2 * q + 1] * theta[1];
        value += creal(((1.0 - r) * part[0] + r * part[1]) * cexp(I * angle));
    }
    return 2.0 * value;
}

static void check_refusals(harmonics_call *c) {
    CHECK_REFUSES(sm_segment *, c->first, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c->times, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c->motion, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, c->sum.shape, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, c->sum.coefficient, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const int32_t *, c->sum.orders, NULL, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->sum.modes, 3, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->sum.orders_count, -1, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->sum.orders_count, INT32_MAX, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c->sum.signals, 0, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c->sum.signals, SIZE_MAX, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->times[SAMPLES - 1], 5.1, add_up(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(c->shape, SM_MODES * SIGNALS, add_up, c);
    CHECK_REFUSES_NOT_FINITE(c->coefficient, (SEGMENTS + 1) * SIGNALS * 2 * ORDERS, add_up, c);
    CHECK_REFUSES_NOT_FINITE(c->times, SAMPLES, add_up, c);
    const int32_t too_high[] = {129, 0};
    c->sum.orders_count = 1;
    CHECK_REFUSES(const int32_t *, c->sum.orders, too_high, add_up(c), SM_BAD_ARGUMENT);
    c->sum.orders_count = ORDERS;
    CHECK_STATUS(sm_harmonic_motion(NULL, 1, c->first, 0, NULL, NULL), SM_BAD_ARGUMENT);
}

void check_harmonics(void) {
    harmonics_call c = new_call();
    c.first = c.segment;
    CHECK_STATUS(add_up(&c), SM_OK);
    for (int k = 0; k < SAMPLES; k++)
        for (int s = 0; s < SIGNALS; s++)
            CHECK_NEAR(c.motion[k * SIGNALS + s], expected(&c, c.times[k], s), 1e-13);
    check_refusals(&c);
    free_call(&c);
}
