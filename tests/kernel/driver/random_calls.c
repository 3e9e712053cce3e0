/* Random calls with a fixed seed: whatever the arguments, an answer without a NaN or a status. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "component.h"

/* Numbers that break naive code. None drives an honest computation into millions of steps. */
static double hostile_number(void) {
    const double numbers[] = {0.0,    -0.0,   -1.0,  NAN,    INFINITY, -INFINITY, 1e308,
                              -1e308, 1e-308, 1e-12, -1e-12, 5e-324,   1e-3,      3.999999};
    return numbers[random_below((int)(sizeof numbers / sizeof *numbers))];
}

/* One of the values hostile, every other time. */
static void spoil(double *values, size_t count) {
    if (random_below(2)) values[random_below((int)count)] = hostile_number();
}

static void check_response(sm_status status, const double *values, size_t count) {
    CHECK(status >= SM_OK && status <= SM_STEP_TOO_SMALL);
    if (status == SM_OK) CHECK_FINITE(values, count);
}

static void spoil_problem(problem *p) {
    const size_t n = (size_t)p->contact.contacts;
    double *const arrays[] = {p->limit, p->stiffness, p->damping, p->coupling};
    const size_t counts[] = {n, n * n, n * n, 2 * n * (size_t)p->contact.modes};
    const int which = random_below(5);
    if (which < 4)
        spoil(arrays[which], counts[which]);
    else
        spoil(&p->contact.alpha, 1);
    for (size_t i = 0; i < n; i++) /* or no coupled matrix that was spoilt would get through */
        for (size_t j = 0; j < i; j++) {
            p->stiffness[i * n + j] = p->stiffness[j * n + i];
            p->damping[i * n + j] = p->damping[j * n + i];
        }
}

static void random_torus(void) {
    const int contacts = 1 + random_below(4), modes = 1 + random_below(2);
    problem p = new_problem(contacts, modes, random_below(2));
    const size_t points = (size_t)random_below(4), n = (size_t)contacts;
    const int32_t orders[] = {1, 0, random_below(9) - 4, random_below(9) - 4};
    double rates[] = {1.0, 1.7}, smallest[] = {0.0, 0.1}, tolerance = 1e-4;
    double *amplitudes = new_doubles(points * 2 + 1), *P = new_doubles(points * 2 * n * 2);
    double *residual = new_doubles(points), *mean_square = new_doubles(points * n);
    int32_t *marched = malloc((points + 1) * sizeof *marched);
    for (size_t k = 0; k < points * 2; k++) amplitudes[k] = 3.0 * random_number();
    spoil_problem(&p);
    spoil(rates, 2);
    if (random_below(4) == 0) spoil(smallest, 2);
    if (random_below(4) == 0) spoil(amplitudes, points * 2 + 1);
    if (random_below(8) == 0) spoil(&tolerance, 1);
    const int32_t steps = 4 + random_below(5), lines = 1 << random_below(6);
    const sm_discretisation grid = {rates,  steps,     lines,    2,
                                    orders, tolerance, smallest, 1 + random_below(3)};
    const sm_torus_points where = {.count = points, .amplitudes = amplitudes};
    const sm_torus_motion motion = {P, mean_square, residual, marched};
    const sm_status status = sm_torus_harmonics(&p.contact, &grid, &where, &motion);
    check_response(status, P, points * 2 * n * 2);
    check_response(status, mean_square, points * n);
    for (size_t k = 0; k < points && status == SM_OK; k++) CHECK(residual[k] >= 0.0);
    free_problem(&p);
    free(amplitudes);
    free(P);
    free(residual);
    free(mean_square);
    free(marched);
}

static void random_motion(void) {
    const int contacts = 1 + random_below(4);
    const size_t n = (size_t)contacts;
    problem p = new_problem(contacts, 1 + random_below(2), random_below(2));
    sm_segment g = {.start = 1.0,
                    .duration = 2.0,
                    .amplitude_start = {1.0, 0.0, 0.0, 1.0},
                    .amplitude_end = {0.5, 2.0, 0.3, 0.0},
                    .angle = {0.1, 0.2},
                    .frequency = {1.0, 1.7}};
    double times[] = {1.5, 2.0, 3.0}, *x = new_doubles(9 * n), *start = new_doubles(n);
    spoil_problem(&p);
    spoil((double *)&g, SEGMENT_COUNT);
    if (random_below(4) == 0) spoil(times, 3);
    if (random_below(4) == 0) spoil(start, n);
    const sm_contact_samples samples = {3, times, x, x + 3 * n, x + 6 * n};
    const sm_status status =
        sm_contact_motion(&p.contact, 1, &g, start, 4 + random_below(9), &samples);
    check_response(status, x, 9 * n);
    free_problem(&p);
    free(x);
    free(start);
}

static void random_lookup(table *t) {
    double at[] = {5.0 * random_number(), 5.0 * random_number()}, s[4], rate[4], powers[2];
    double amplitude[] = {random_number(), random_number(), random_number(), random_number()};
    const size_t terms = 2 * (size_t)t->table.modes;
    sm_slow_flow flow = flow_over(t);
    sm_inputs inputs = resonant_inputs();
    double *const value = &t->values[random_below(100)], kept = *value;
    spoil(value, 1);
    spoil(at, 2);
    check_response(sm_table_lookup(&t->table, 1, at, s), s, terms);
    spoil((double *)&inputs, INPUT_COUNT);
    spoil(amplitude, 4);
    spoil(flow.natural, 2);
    const sm_status status =
        sm_slow_flow_rate(&flow, &inputs, random_number(), amplitude, rate, powers);
    check_response(status, rate, terms);
    check_response(status, powers, 2);
    *value = kept;
}

/* A step that succeeds has outputs. If only its contact motion fails, these outputs are NaN. */
static void check_row(const model *m, sm_status status, size_t count, const double *out) {
    if (status == SM_OK) {
        CHECK(count == 1);
        CHECK_FINITE(out, m->outputs);
    } else if (count > 0) {
        CHECK(count == 1);
        CHECK(isnan(out[m->outputs - 1]));
    }
}

/* One call on a component; a refused one must leave the state alone. */
static void random_component_call(model *m, double *before, double *state, double *out) {
    sm_component *c = m->component;
    sm_inputs inputs = resonant_inputs();
    sm_status status = SM_OK;
    double duration = 3.0 * random_number(), amplitude[] = {1.0, 0.5, 0.1, -1.0}, time = 3.0;
    sm_trace trace = {.capacity = 1, .outputs = out};
    size_t done = 0;
    CHECK_STATUS(sm_component_get_state(c, before), SM_OK);
    switch (random_below(7)) {
    case 0:
        /* a force whose phase races is noise, which is followed honestly and slowly */
        spoil((double *)&inputs, offsetof(sm_inputs, phase_rate) / sizeof(double));
        status = sm_component_set_inputs(c, &inputs);
        break;
    case 1:
        spoil(amplitude, 4);
        if (random_below(4) == 0) spoil(&time, 1);
        status = sm_component_reset(c, time, amplitude);
        break;
    case 2:
        memcpy(state, before, m->state * sizeof(double));
        spoil(state, m->state);
        status = sm_component_set_state(c, state);
        break;
    case 3:
        status = sm_component_run(c, 1, &duration, &inputs, out, &done);
        check_row(m, status, done, out);
        return; /* the inputs have moved on in any case */
    case 4:
        if (random_below(3) == 0) spoil(&duration, 1);
        status = sm_component_trace(c, 1, &duration, &inputs, &trace);
        check_row(m, status, trace.count, out);
        CHECK(trace.done <= trace.count && trace.elapsed >= 0.0);
        return;
    default:
        if (random_below(3) == 0) spoil(&duration, 1);
        status = sm_component_step(c, duration);
    }
    CHECK_STATUS(sm_component_get_state(c, state), SM_OK);
    CHECK_FINITE(state, m->state);
    if (status != SM_OK) CHECK(memcmp(before, state, m->state * sizeof(double)) == 0);
    check_response(sm_component_outputs(c, out), out, m->outputs);
}

static void random_component(int modes, int wanted, int calls) {
    model m = new_model(modes, 2, wanted);
    double *before = new_doubles(m.state), *state = new_doubles(m.state);
    double *out = new_doubles(m.outputs);
    for (int k = 0; k < calls; k++) random_component_call(&m, before, state, out);
    /* and it still works */
    const double zero[4] = {0.0};
    const sm_inputs inputs = resonant_inputs();
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_reset(m.component, 0.0, zero), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 1.0), SM_OK);
    free(before);
    free(state);
    free(out);
    free_model(&m);
}

void check_random_calls(int times) {
    table one = new_table(1, 13, 1), two = new_table(2, 4, 4);
    for (int k = 0; k < times * 2500; k++) {
        random_lookup(k % 2 ? &one : &two);
        if (k % 2 == 0) random_motion();
        if (k % 10 == 0) random_torus();
    }
    free_table(&one);
    free_table(&two);
    for (int modes = 1; modes <= 2; modes++) {
        random_component(modes, 0, times * 500);
        random_component(modes, 1, times * 500);
    }
}
