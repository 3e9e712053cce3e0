/* Directional derivatives of the slow flow against differences of its rates. */
#include <math.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

#define INPUTS (sizeof(sm_inputs) / sizeof(double))
#define RESULTS 6 /* rate, input power, friction power */

typedef struct {
    table t;
    sm_slow_flow flow;
    double amplitude[4], d_amplitude[4];
    sm_inputs inputs, d_inputs;
    double change[RESULTS];
} directional_call;

/* Everything that a slow flow can have, on ramps of every input. */
static directional_call new_call(int modes, int paper) {
    directional_call c = {.t = modes == 2 ? new_rich_table(5, 4, 2) : new_table(1, 5, 1),
                          .amplitude = {0.9, -0.7, -0.4, 1.1},
                          .inputs = {.force = {0.15, 0.25},
                                     .force_rate = {0.01, -0.02},
                                     .frequency = {0.98, 1.65},
                                     .frequency_rate = {1e-3, -2e-3},
                                     .phase = {0.3, -1.2},
                                     .phase_rate = {0.02, 0.01},
                                     .limit_scale = 1.3,
                                     .limit_scale_rate = -0.01,
                                     .angle = {0.4, 2.0}}};
    c.flow = flow_over(&c.t);
    c.flow.paper = paper;
    c.flow.combination[0] = (sm_combination){1, 5, -2};
    c.flow.combination[1] = (sm_combination){0, -4, 3};
    for (int j = 0; j < modes; j++) {
        const double ratio[2][2] = {{0.02, -0.01}, {0.03, 0.01 * j}};
        memcpy(c.flow.coupling_ratio[j], ratio, sizeof ratio);
        c.flow.off_resonance[j][0] = 0.2;
        c.flow.off_resonance[j][1] = -0.1;
    }
    return c;
}

static sm_status evaluate(void *arguments) {
    directional_call *c = arguments;
    const sm_slow_point at = {c->amplitude, &c->inputs}, along = {c->d_amplitude, &c->d_inputs};
    return sm_slow_flow_directional(&c->flow, &at, &along, c->change, c->change + 4);
}

static void rate_at(const directional_call *c, double distance, double *result) {
    double amplitude[4];
    sm_inputs inputs = c->inputs;
    for (int k = 0; k < 4; k++) amplitude[k] = c->amplitude[k] + distance * c->d_amplitude[k];
    for (size_t k = 0; k < INPUTS; k++)
        ((double *)&inputs)[k] += distance * ((const double *)&c->d_inputs)[k];
    memset(result, 0, RESULTS * sizeof *result);
    CHECK_STATUS(sm_slow_flow_rate(&c->flow, &inputs, 0.0, amplitude, result, result + 4), SM_OK);
}

/* Along a direction, against a difference of fourth order. */
static void check_direction(directional_call *c) {
    const double h = 1e-3;
    double at[4][RESULTS];
    for (int k = 0; k < 4; k++) rate_at(c, h * (k < 2 ? k - 2 : k - 1), at[k]);
    memset(c->change, 0, sizeof c->change);
    CHECK_STATUS(evaluate(c), SM_OK);
    for (int r = 0; r < RESULTS; r++) {
        const double difference =
            (8.0 * (at[2][r] - at[1][r]) - (at[3][r] - at[0][r])) / (12.0 * h);
        CHECK_NEAR(c->change[r], difference, 1e-9 * (1.0 + fabs(difference)));
    }
}

/* Along each amplitude and each input alone, and along all of them. */
static void check_directions(int modes, int paper) {
    directional_call c = new_call(modes, paper);
    double *const inputs = (double *)&c.d_inputs;
    for (size_t k = 0; k < 4 + INPUTS; k++) {
        double *const one = k < 4 ? &c.d_amplitude[k] : &inputs[k - 4];
        *one = 1.0;
        check_direction(&c);
        *one = 0.0;
    }
    for (size_t k = 0; k < 4 + INPUTS; k++)
        *(k < 4 ? &c.d_amplitude[k] : &inputs[k - 4]) = 0.1 * (random_number() - 0.5);
    check_direction(&c);
    free_table(&c.t);
}

/* At rest, where the direction of the amplitude has no meaning, and at the edge of the table. */
static void check_ends(void) {
    directional_call c = new_call(2, 0);
    memset(c.amplitude, 0, sizeof c.amplitude);
    memset(c.flow.off_resonance, 0, sizeof c.flow.off_resonance);
    c.d_amplitude[1] = 1.0;
    CHECK_STATUS(evaluate(&c), SM_OK);
    CHECK_FINITE(c.change, RESULTS);
    CHECK(fabs(c.change[1]) > 1e-3);
    memset(c.flow.coupling_ratio, 0, sizeof c.flow.coupling_ratio);
    c.amplitude[1] = 4.0 * c.inputs.limit_scale;
    double inside[RESULTS];
    CHECK_STATUS(evaluate(&c), SM_OK);
    memcpy(inside, c.change, sizeof inside);
    c.amplitude[1] -= 1e-3;
    CHECK_STATUS(evaluate(&c), SM_OK);
    for (int r = 0; r < RESULTS; r++) CHECK_NEAR(c.change[r], inside[r], 1e-2);
    free_table(&c.t);
}

static void check_refusals(void) {
    directional_call c = new_call(2, 0);
    double r[4];
    const sm_slow_point at = {c.amplitude, &c.inputs}, along = {c.d_amplitude, &c.d_inputs};
    const sm_slow_point wrong[] = {{NULL, &c.inputs}, {c.amplitude, NULL}};
    for (int k = 0; k < 2; k++) {
        CHECK_STATUS(sm_slow_flow_directional(&c.flow, &wrong[k], &along, r, r), SM_BAD_ARGUMENT);
        CHECK_STATUS(sm_slow_flow_directional(&c.flow, &at, &wrong[k], r, r), SM_BAD_ARGUMENT);
    }
    CHECK_STATUS(sm_slow_flow_directional(NULL, &at, &along, r, r), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_directional(&c.flow, &at, &along, NULL, r), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_directional(&c.flow, &at, &along, r, NULL), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.amplitude[2], 7.0, evaluate(&c), SM_OUTSIDE_TABLE);
    CHECK_REFUSES(double, c.inputs.limit_scale, 0.0, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.flow.table.modes, 3, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(c.amplitude, 4, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE((double *)&c.inputs, INPUTS, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE(c.d_amplitude, 4, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE((double *)&c.d_inputs, INPUTS, evaluate, &c);
    CHECK_STATUS(evaluate(&c), SM_OK);
    free_table(&c.t);
}

void check_directional(void) {
    for (int modes = 1; modes <= 2; modes++)
        for (int paper = 0; paper <= 1; paper++) check_directions(modes, paper);
    check_ends();
    check_refusals();
}
