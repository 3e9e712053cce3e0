/* Motion of the contacts along a slow trajectory. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

#define SAMPLES 57
#define SEGMENTS 2

/* All arguments of sm_contact_motion: amplitudes that rise, then fall, in a straight line, and
 * frequencies that sweep. */
typedef struct {
    problem p;
    size_t segments, samples;
    sm_segment *segment;
    double *start_x, *times, *x, *v, *f;
    int32_t steps_per_period;
} motion_call;

static void fill_segments(sm_segment *g) {
    const double rise[2][4] = {{0.05, -0.02, 0.03, 0.01}, {-0.04, 0.01, 0.02, -0.03}};
    for (int k = 0; k < SEGMENTS; k++) {
        g[k].start = k == 0 ? 3.0 : g[0].start + g[0].duration;
        g[k].duration = k == 0 ? 11.0 : 17.0;
        for (int p = 0; p < 4; p++) {
            g[k].amplitude_start[p] = k == 0 ? 0.3 * p + 0.5 : g[0].amplitude_end[p];
            g[k].rate_start[p] = g[k].rate_end[p] = rise[k][p];
            g[k].amplitude_end[p] = g[k].amplitude_start[p] + rise[k][p] * g[k].duration;
        }
        for (int j = 0; j < SM_MODES; j++) {
            const double h = g[0].duration;
            g[k].frequency_rate[j] = 0.002 * (j + 1);
            g[k].frequency[j] = (j == 0 ? 1.0 : 1.7) + (k == 0 ? 0.0 : g[0].frequency_rate[j] * h);
            g[k].angle[j] = 0.4 * j;
            if (k > 0)
                g[k].angle[j] += h * (g[0].frequency[j] + 0.5 * g[0].frequency_rate[j] * h);
        }
    }
}

static motion_call new_call(int contacts, int modes, int law) {
    const size_t n = (size_t)contacts;
    motion_call c = {.p = new_problem(contacts, modes, law),
                     .segments = SEGMENTS,
                     .samples = SAMPLES,
                     .segment = calloc(SEGMENTS, sizeof(sm_segment)),
                     .start_x = new_doubles(n),
                     .times = new_doubles(SAMPLES),
                     .x = new_doubles(SAMPLES * n),
                     .v = new_doubles(SAMPLES * n),
                     .f = new_doubles(SAMPLES * n),
                     .steps_per_period = 64};
    if (!c.segment) abort();
    fill_segments(c.segment);
    for (int k = 0; k < SAMPLES; k++) c.times[k] = 3.0 + 28.0 * (k + 1) / SAMPLES;
    for (size_t i = 0; i < n; i++) c.start_x[i] = 0.01 * (double)i;
    return c;
}

static void free_call(motion_call *c) {
    free_problem(&c->p);
    free(c->segment);
    free(c->start_x);
    free(c->times);
    free(c->x);
    free(c->v);
    free(c->f);
}

static sm_status march(void *arguments) {
    motion_call *c = arguments;
    const sm_contact_samples samples = {c->samples, c->times, c->x, c->v, c->f};
    return sm_contact_motion(&c->p.contact, c->segments, c->segment, c->start_x,
                             c->steps_per_period, &samples);
}

/* -2 Re(L_j a_j exp(i theta_j)) summed over the modes, straight from the definition. */
static double forcing(const motion_call *c, int i, double time) {
    const sm_segment *g = &c->segment[time > c->segment[0].start + c->segment[0].duration];
    const double t = time - g->start;
    double u = 0.0;
    for (int j = 0; j < c->p.contact.modes; j++) {
        const double *L = c->p.coupling + 2 * (j * c->p.contact.contacts + i);
        const double re = g->amplitude_start[2 * j] + t * g->rate_start[2 * j];
        const double im = g->amplitude_start[2 * j + 1] + t * g->rate_start[2 * j + 1];
        const double theta = g->angle[j] + t * (g->frequency[j] + 0.5 * g->frequency_rate[j] * t);
        u -= 2.0 * hypot(L[0], L[1]) * hypot(re, im)
             * cos(theta + atan2(L[1], L[0]) + atan2(im, re));
    }
    return u;
}

/* D v + K x + f = u at every sample; the force within the limit, and no creep of a stuck Coulomb
 * contact. */
static void check_equilibrium(int contacts, int modes, int law, double alpha) {
    motion_call c = new_call(contacts, modes, law);
    c.p.contact.alpha = alpha;
    CHECK_STATUS(march(&c), SM_OK);
    for (int k = 0; k < SAMPLES; k++)
        for (int i = 0; i < contacts; i++) {
            const double v = c.v[k * contacts + i], f = c.f[k * contacts + i];
            const double limit = c.p.limit[i];
            double left = f;
            for (int j = 0; j < contacts; j++)
                left += c.p.damping[i * contacts + j] * c.v[k * contacts + j]
                        + c.p.stiffness[i * contacts + j] * c.x[k * contacts + j];
            CHECK_NEAR(left, forcing(&c, i, c.times[k]), 1e-9);
            CHECK(fabs(f) <= limit);
            if (law == SM_TANH)
                CHECK_NEAR(f, limit * tanh(v / alpha), 1e-9 * limit);
            else
                CHECK(fabs(f) < limit * (1.0 - 1e-9) ? v == 0.0 : v * f >= 0.0);
        }
    free_call(&c);
}

/* A single Coulomb contact without damping is the play operator: x stays unless the band
 * (u +- limit) / K around it moves past. */
static void check_play_operator(void) {
    motion_call c = new_call(1, 1, SM_COULOMB);
    double x = c.start_x[0] = 0.03;
    c.p.damping[0] = 0.0;
    c.steps_per_period = 2048;
    CHECK_STATUS(march(&c), SM_OK);
    int k = 0;
    for (int step = 1; k < SAMPLES; step++) { /* far finer than the core marches */
        const double time = 3.0 + 28.0 * step / (SAMPLES * 2000.0);
        const double u = forcing(&c, 0, time), limit = c.p.limit[0], K = c.p.stiffness[0];
        x = fmax((u - limit) / K, fmin(x, (u + limit) / K));
        if (step % 2000 == 0) CHECK_NEAR(c.x[k++], x, 1e-6);
    }
    free_call(&c);
}

static void check_stuck(void) {
    motion_call c = new_call(3, 2, SM_COULOMB);
    for (int i = 0; i < 3; i++) c.p.limit[i] = 1e6;
    CHECK_STATUS(march(&c), SM_OK);
    for (int k = 0; k < 3 * SAMPLES; k++) CHECK(c.x[k] == c.start_x[k % 3] && c.v[k] == 0.0);
    free_call(&c);
}

/* Outputs that are not wanted, a start at rest, no samples, a sample at the very start. */
static void check_optional_arguments(void) {
    motion_call c = new_call(2, 2, SM_TANH), bare = new_call(2, 2, SM_TANH);
    c.start_x[1] = 0.0;
    c.times[0] = bare.times[0] = 3.0;
    CHECK_STATUS(march(&c), SM_OK);
    CHECK(c.x[0] == 0.0 && c.v[1] == 0.0 && c.f[0] == 0.0);
    const sm_contact_samples velocities = {SAMPLES, bare.times, NULL, bare.v, NULL};
    CHECK_STATUS(
        sm_contact_motion(&bare.p.contact, SEGMENTS, bare.segment, NULL, 64, &velocities), SM_OK);
    CHECK(memcmp(c.v, bare.v, 2 * SAMPLES * sizeof(double)) == 0);
    const sm_contact_samples none = {.count = 0};
    CHECK_STATUS(sm_contact_motion(&bare.p.contact, SEGMENTS, bare.segment, NULL, 64, &none),
                 SM_OK);
    CHECK_STATUS(sm_contact_motion(&bare.p.contact, SEGMENTS, bare.segment, NULL, 64, NULL),
                 SM_BAD_ARGUMENT);
    free_call(&c);
    free_call(&bare);
}

static void check_refusals(void) {
    motion_call c = new_call(2, 2, SM_TANH);
    CHECK_REFUSES(size_t, c.segments, 0, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(sm_segment *, c.segment, NULL, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c.times, NULL, march(&c), SM_BAD_ARGUMENT);
    const int32_t wrong[] = {3, 0, -1, 65537, INT32_MAX, INT32_MIN};
    for (int k = 0; k < 6; k++)
        CHECK_REFUSES(int32_t, c.steps_per_period, wrong[k], march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.times[4], c.times[5], march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.times[0], 2.999, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.times[SAMPLES - 1], 31.1, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[1].duration, 0.0, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[0].duration, -11.0, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[0].duration, 10.9, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[1].start, 2.0, march(&c), SM_BAD_ARGUMENT);
    /* more steps than anybody can wait for, or than an integer counts */
    CHECK_REFUSES(double, c.segment[0].frequency[0], 1e15, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[0].frequency[0], -1e300, march(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.segment[0].amplitude_start[0], 1e308, march(&c), SM_NOT_FINITE);
    for (int k = 0; k < SEGMENTS; k++)
        CHECK_REFUSES_NOT_FINITE((double *)&c.segment[k], SEGMENT_COUNT, march, &c);
    CHECK_REFUSES_NOT_FINITE(c.times, SAMPLES, march, &c);
    CHECK_REFUSES_NOT_FINITE(c.start_x, 2, march, &c);
    CHECK_REFUSES_NOT_FINITE(c.p.limit, 2, march, &c);
    allocations_left = 0;
    CHECK_STATUS(march(&c), SM_NO_MEMORY);
    allocations_left = -1;
    CHECK_STATUS(march(&c), SM_OK);
    free_call(&c);
}

void check_motion(void) {
    const int contacts[] = {1, 2, 3, 7};
    for (int n = 0; n < 4; n++)
        for (int modes = 1; modes <= 2; modes++) {
            check_equilibrium(contacts[n], modes, SM_TANH, 0.02);
            check_equilibrium(contacts[n], modes, SM_TANH, 1e-6);
            check_equilibrium(contacts[n], modes, SM_COULOMB, 0.0);
        }
    check_play_operator();
    check_stuck();
    check_optional_arguments();
    check_refusals();
}
