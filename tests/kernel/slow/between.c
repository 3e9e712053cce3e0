/* Amplitudes between two points of a trajectory. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

#define MODES 2
#define COUNT (2 * MODES)
#define STEPS 2 /* both the same */

/* All arguments of sm_trajectory_divide and of sm_trajectory_bend. */
typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs[STEPS];
    double duration[STEPS], start[STEPS * COUNT], end[STEPS * COUNT], bend[STEPS];
    int32_t parts;
    double *between;
} call;

static sm_status divide(void *arguments) {
    call *c = arguments;
    const sm_trajectory_steps steps = {STEPS, c->inputs, c->duration, c->start, c->end};
    return sm_trajectory_divide(&c->flow, &steps, c->parts, c->between);
}

static sm_status bend(void *arguments) {
    call *c = arguments;
    const sm_trajectory_steps steps = {STEPS, c->inputs, c->duration, c->start, c->end};
    return sm_trajectory_bend(&c->flow, &steps, c->bend);
}

/* Amplitudes y so many seconds after the start of the inputs, by midpoint steps that are short. */
static void flow_along(const call *c, double seconds, double *y) {
    const int steps = 100000;
    const double h = seconds / steps;
    double rate[COUNT], half[COUNT], power[2];
    for (int k = 0; k < steps; k++) {
        CHECK_STATUS(sm_slow_flow_rate(&c->flow, c->inputs, h * k, y, rate, power), SM_OK);
        for (int u = 0; u < COUNT; u++) half[u] = y[u] + 0.5 * h * rate[u];
        CHECK_STATUS(
            sm_slow_flow_rate(&c->flow, c->inputs, h * (k + 0.5), half, rate, power),
            SM_OK);
        for (int u = 0; u < COUNT; u++) y[u] += h * rate[u];
    }
}

static void set_parts(call *c, int32_t parts) {
    free(c->between);
    c->parts = parts;
    c->between = new_doubles(STEPS * (size_t)(parts - 1) * COUNT);
}

static call new_call(double duration) {
    const double start[COUNT] = {0.9, -0.7, -0.4, 1.1};
    call c = {.t = new_table(MODES, 2, 2)};
    double end[COUNT];
    c.flow = flow_over(&c.t);
    memcpy(end, start, sizeof start);
    for (int k = 0; k < STEPS; k++) {
        c.inputs[k] = resonant_inputs();
        c.inputs[k].frequency_rate[0] = 1e-3;
        c.inputs[k].limit_scale = 1.2;
        c.duration[k] = duration;
        memcpy(c.start + k * COUNT, start, sizeof start);
    }
    flow_along(&c, duration, end);
    for (int k = 0; k < STEPS; k++) memcpy(c.end + k * COUNT, end, sizeof end);
    return c;
}

static void free_call(call *c) {
    free(c->between);
    free_table(&c->t);
}

/* The middle of a step, of fourth order; all steps alike. */
static void check_order(void) {
    call c = new_call(8.0);
    double middle[COUNT], off[2] = {0.0, 0.0};
    memcpy(middle, c.start, sizeof middle);
    flow_along(&c, 4.0, middle);
    for (int k = 0; k < 2; k++) {
        set_parts(&c, k == 0 ? 8 : 16);
        CHECK_STATUS(divide(&c), SM_OK);
        const size_t inner = (size_t)(c.parts - 1) * COUNT;
        const double *found = c.between + (size_t)(c.parts / 2 - 1) * COUNT;
        CHECK(memcmp(c.between, c.between + inner, inner * sizeof(double)) == 0);
        for (int u = 0; u < COUNT; u++) off[k] = fmax(off[k], fabs(found[u] - middle[u]));
    }
    CHECK_NEAR(log2(off[0] / off[1]), 4.0, 0.3);
    free_call(&c);
}

/* What its end is off is taken off along the step. */
static void check_end(void) {
    call c = new_call(1.0);
    set_parts(&c, 64);
    CHECK_STATUS(divide(&c), SM_OK);
    const double before = c.between[15 * COUNT], after = c.between[47 * COUNT];
    c.end[0] += 1e-3;
    CHECK_STATUS(divide(&c), SM_OK);
    CHECK_NEAR(c.between[15 * COUNT] - before, 0.25e-3, 1e-15);
    CHECK_NEAR(c.between[47 * COUNT] - after, 0.75e-3, 1e-15);
    free_call(&c);
}

/* Half a step bends by a sixteenth: the slope of a cubic is of third order. */
static void check_bend(void) {
    double found[2];
    for (int k = 0; k < 2; k++) {
        call c = new_call(k == 0 ? 2.0 : 1.0);
        CHECK_STATUS(bend(&c), SM_OK);
        CHECK(c.bend[0] == c.bend[1]);
        found[k] = c.bend[0];
        free_call(&c);
    }
    CHECK_NEAR(log2(found[0] / found[1]), 4.0, 0.3);
}

static void check_refusals(void) {
    call c = new_call(1.0);
    set_parts(&c, 2);
    const sm_slow_flow *const f = &c.flow;
    const sm_trajectory_steps steps = {1, c.inputs, c.duration, c.start, c.end};
    const sm_trajectory_steps wrong[] = {{1, NULL, c.duration, c.start, c.end},
                                         {1, c.inputs, NULL, c.start, c.end},
                                         {1, c.inputs, c.duration, NULL, c.end},
                                         {1, c.inputs, c.duration, c.start, NULL}};
    for (int k = 0; k < 4; k++) {
        CHECK_STATUS(sm_trajectory_divide(f, &wrong[k], 2, c.between), SM_BAD_ARGUMENT);
        CHECK_STATUS(sm_trajectory_bend(f, &wrong[k], c.bend), SM_BAD_ARGUMENT);
    }
    CHECK_STATUS(sm_trajectory_divide(NULL, &steps, 2, c.between), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_trajectory_divide(f, NULL, 2, c.between), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_trajectory_divide(f, &steps, 2, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_trajectory_divide(f, &steps, 1, c.between), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_trajectory_bend(f, &steps, NULL), SM_BAD_ARGUMENT);
    const entry both[] = {divide, bend};
    for (int k = 0; k < 2; k++) {
        CHECK_REFUSES(double, c.duration[1], 0.0, both[k](&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(double, c.inputs[1].frequency_rate[0], -1.0, both[k](&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c.flow.table.modes, 3, both[k](&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES_NOT_FINITE((double *)&c.inputs[1], INPUT_COUNT, both[k], &c);
        CHECK_REFUSES_NOT_FINITE(c.duration, STEPS, both[k], &c);
        CHECK_REFUSES_NOT_FINITE(c.start, STEPS * COUNT, both[k], &c);
        CHECK_REFUSES_NOT_FINITE(c.end, STEPS * COUNT, both[k], &c);
    }
    /* a cubic that leaves the table is no cubic of the flow */
    c.end[COUNT] = 6.0;
    CHECK_STATUS(bend(&c), SM_OK);
    CHECK(isfinite(c.bend[0]) && isinf(c.bend[1]));
    c.start[0] = 6.0;
    CHECK_STATUS(divide(&c), SM_OUTSIDE_TABLE);
    free_call(&c);
}

void check_between(void) {
    check_order();
    check_end();
    check_bend();
    check_refusals();
}
