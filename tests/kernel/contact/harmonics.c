/* Signals as sums of harmonics along a slow trajectory. */
#include "motion.h"

void check_harmonics(int times);
void check_harmonics_refusals(void);

#define SIGNALS 3
#define ORDERS 3
#define COEFFICIENTS ((SEGMENTS + 1) * SIGNALS * 2 * ORDERS)

typedef struct {
    sm_harmonic_sum sum;
    problem p;
    motion_call along;
    double *shape, *coefficient, *motion;
} harmonics_call;

static const int32_t orders[2 * ORDERS] = {1, 0, -2, 3, 4, -1};

static void new_call(harmonics_call *c) {
    c->p = new_problem(SIGNALS, 2, SM_TANH);
    new_motion(&c->along, &c->p.contact, SAMPLES);
    c->shape = new_doubles(SM_MODES * SIGNALS);
    c->coefficient = new_doubles(COEFFICIENTS);
    c->motion = new_doubles(SAMPLES * SIGNALS);
    memset(c->p.coupling, 0, 4 * SIGNALS * sizeof(double));
    for (int k = 0; k < SM_MODES * SIGNALS; k++) /* so that -forcing is that part of a signal */
        c->p.coupling[2 * k] = c->shape[k] = 0.1 * k;
    for (int k = 0; k < COEFFICIENTS; k++) c->coefficient[k] = cos(0.7 * k);
    c->sum = (sm_harmonic_sum){SM_MODES, ORDERS, orders, SIGNALS, c->shape, c->coefficient};
}

static sm_status add_up(void *arguments) {
    harmonics_call *c = arguments;
    return sm_harmonic_motion(&c->sum, c->along.segments, c->along.segment, SAMPLES,
                              c->along.times, c->motion);
}

/* Coefficients straight in time. */
static double expected(const harmonics_call *c, double time, int s) {
    const int g = time > 14.0;
    const sm_segment *segment = &c->along.two[g];
    const double t = time - segment->start, r = t / segment->duration;
    double theta[2], value = -forcing(&c->along, s, time);
    for (int j = 0; j < 2; j++)
        theta[j] = segment->angle[j] + t * (segment->frequency[j] + 0.5 * segment->frequency_rate[j] * t);
    for (int q = 0; q < ORDERS; q++) {
        const double *row = c->coefficient + (g * SIGNALS + s) * 2 * ORDERS + q;
        const double *next = row + SIGNALS * 2 * ORDERS;
        const double complex now = (1.0 - r) * (row[0] + I * row[ORDERS]) + r * (next[0] + I * next[ORDERS]);
        value += 2.0 * creal(now * cexp(I * (orders[2 * q] * theta[0] + orders[2 * q + 1] * theta[1])));
    }
    return value;
}

void check_harmonics(int times) {
    harmonics_call c;
    (void)times;
    new_call(&c);
    CHECK_STATUS(add_up(&c), SM_OK);
    for (int k = 0; k < SAMPLES * SIGNALS; k++)
        CHECK_NEAR(c.motion[k], expected(&c, c.along.times[k / SIGNALS], k % SIGNALS), 1e-12);
}

void check_harmonics_refusals(void) {
    harmonics_call c;
    const int32_t too_high[2 * ORDERS] = {129, 0};
    new_call(&c);
    REFUSES_NULL(add_up, &c, &c.along.segment, &c.along.times, &c.motion, &c.sum.shape,
                 &c.sum.coefficient, &c.sum.orders, &c.sum.signals);
    REFUSES_INTS(&c.sum.modes, add_up, &c, 0, 3);
    REFUSES_INTS(&c.sum.orders_count, add_up, &c, -1, INT32_MAX);
    REFUSES(&c.along.times[SAMPLES - 1], add_up, &c, 31.1);
    REFUSES_NOT_FINITE(add_up, &c, {c.shape, SM_MODES * SIGNALS}, {c.coefficient, COEFFICIENTS},
                       {c.along.times, SAMPLES});
    c.sum.orders = too_high;
    CHECK_STATUS(add_up(&c), SM_BAD_ARGUMENT);
}
