/* The friction table, and calls of the slow flow. */
#include "fixtures.h"

void check_slow_flow_refusals(void);

#define INPUTS (sizeof(sm_inputs) / sizeof(double))
#define RESULTS 6 /* rate, input power, friction power */

/* All arguments of sm_slow_flow_rate and sm_slow_flow_directional, on ramps of every input. */
typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs, d_inputs;
    double elapsed, amplitude[4], d_amplitude[4], rate[RESULTS], *a, *result;
} rate_call;

static void new_call(rate_call *c, int rich) {
    *c = (rate_call){.t = rich ? new_rich_table(4, 5, 2) : new_table(2, 6, 5),
                     .inputs = {.force = {0.15, 0.25}, .force_rate = {0.01, -0.02},
                                .frequency = {0.98, 1.65}, .frequency_rate = {1e-3, -2e-3},
                                .phase = {0.3, -1.2}, .phase_rate = {0.02, 0.01},
                                .limit_scale = 1.2, .limit_scale_rate = 0.01, .angle = {0.4, 2.0}},
                     .elapsed = 2.5,
                     .amplitude = {0.9, -0.7, -0.4, 1.1}};
    c->a = c->amplitude;
    c->result = c->rate;
    c->flow = flow_over(&c->t);
    if (!rich) return;
    c->flow.combination[0] = (sm_combination){1, 5, -2};
    c->flow.combination[1] = (sm_combination){0, -4, 3};
    for (int j = 0; j < 2; j++) {
        const double ratio[2][2] = {{0.02, -0.01}, {0.03, 0.01 * j}};
        memcpy(c->flow.coupling_ratio[j], ratio, sizeof ratio);
        c->flow.off_resonance[j][0] = 0.2;
        c->flow.off_resonance[j][1] = -0.1;
    }
}

static sm_status rate(void *arguments) {
    rate_call *c = arguments;
    return sm_slow_flow_rate(&c->flow, &c->inputs, c->elapsed, c->a, c->result, c->rate + 4);
}

static sm_status directional(void *arguments) {
    rate_call *c = arguments;
    const sm_slow_point at = {c->a, &c->inputs}, along = {c->d_amplitude, &c->d_inputs};
    return sm_slow_flow_directional(&c->flow, &at, &along, c->result, c->rate + 4);
}

static sm_status look_up(void *arguments) {
    rate_call *c = arguments;
    return sm_table_lookup(&c->t.table, 1, c->a, c->result);
}

static sm_status table_check(void *arguments) {
    rate_call *c = arguments;
    return sm_table_check(&c->t.table);
}

void check_slow_flow_refusals(void) {
    rate_call c;
    const entry calls[] = {rate, directional};
    new_call(&c, 1);
    for (int k = 0; k < 2; k++) {
        REFUSES_NULL(calls[k], &c, &c.a, &c.result);
        REFUSES_INTS(&c.flow.table.modes, calls[k], &c, 0, -1, 3, INT32_MIN, INT32_MAX);
        REFUSES_INTS(&c.flow.table.combinations, calls[k], &c, INT32_MIN, -1, SM_COMBINATIONS + 1,
                     INT32_MAX);
        REFUSES_INTS(&c.flow.combination[0].mode, calls[k], &c, INT32_MIN, -1, 2, INT32_MAX);
        REFUSES_INTS(&c.flow.combination[0].n, calls[k], &c, INT32_MIN, -1001, 1001, INT32_MAX);
        REFUSES_INTS(&c.flow.combination[0].m, calls[k], &c, INT32_MIN, -1001, 1001, INT32_MAX);
        REFUSES(&c.inputs.frequency[1], calls[k], &c, 0.0);
        REFUSES(&c.inputs.limit_scale, calls[k], &c, -1.0);
        REFUSES(&c.flow.ratio, calls[k], &c, -1.0);
        CHECK_WITH(&c.amplitude[2], 7.2, calls[k](&c), SM_OUTSIDE_TABLE);
        REFUSES_NOT_FINITE(calls[k], &c, {(double *)&c.inputs, INPUT_COUNT}, {c.amplitude, 4},
                           {c.flow.natural, 2}, {&c.flow.coupling_ratio[0][0][0], 8},
                           {&c.flow.off_resonance[0][0], 4});
    }
    REFUSES_NOT_FINITE(directional, &c, {(double *)&c.d_inputs, INPUTS}, {c.d_amplitude, 4});
    REFUSES_NOT_FINITE(rate, &c, {&c.elapsed, 1});
    REFUSES(&c.inputs.frequency_rate[0], rate, &c, -1.0);
    new_call(&c, 0);
    for (int j = 0; j < 2; j++) {
        c.amplitude[j] = 1.0;
        CHECK_WITH(&c.amplitude[j], nextafter(4.0, 5.0), look_up(&c), SM_OUTSIDE_TABLE);
        CHECK_WITH(&c.amplitude[j], -1e-300, look_up(&c), SM_OUTSIDE_TABLE);
    }
    REFUSES_NOT_FINITE(look_up, &c, {c.amplitude, 2});
    REFUSES_NULL(look_up, &c, &c.a, &c.result);
    REFUSES_NULL(table_check, &c, &c.t.table.node_b, &c.t.table.values);
    REFUSES_INTS(&c.t.table.modes, table_check, &c, 0, 3, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&c.t.table.count_a, table_check, &c, 0, 1, 100001, INT32_MIN, INT32_MAX);
    REFUSES(&c.t.node_a[0], table_check, &c, 0.1);
    REFUSES(&c.t.node_b[3], table_check, &c, 4.0, -1.0);
    REFUSES_NOT_FINITE(table_check, &c, {c.t.node_b, 5}, {c.t.values, 6 * 5 * 16});
}
