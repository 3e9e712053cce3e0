/* Traces of the step-able component: its outputs after each internal step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "component.h"
#include "driver.h"

enum { STEPS = 4, MOST_ROWS = 4000 };

/* A jump of the force, a step shorter than an internal one, a sweep, a ramp. */
static void script(double *durations, sm_inputs *inputs) {
    const double lengths[STEPS] = {50.0, 1e-6, 700.0, 200.0};
    memcpy(durations, lengths, sizeof lengths);
    for (int k = 0; k < STEPS; k++) inputs[k] = resonant_inputs();
    inputs[2].force[0] = 0.05;
    inputs[2].frequency_rate[0] = 2e-5;
    inputs[3].force_rate[1] = -2e-4;
}

/* How a trace went, and its rows, in memory of their exact size. */
typedef struct {
    sm_status status;
    size_t rows, done;
    double elapsed, *out;
} trace;

/* A script in calls of `capacity` rows. */
static trace traced(const model *m, const double *durations, const sm_inputs *inputs,
                    size_t capacity) {
    trace t = {.out = new_doubles(MOST_ROWS * m->outputs)};
    do {
        double *part = new_doubles(capacity * m->outputs);
        sm_trace rows = {capacity, 99, part, t.done, t.elapsed};
        t.status = sm_component_trace(m->component, STEPS, durations, inputs, &rows);
        const size_t count = rows.count;
        t.done = rows.done;
        t.elapsed = rows.elapsed;
        CHECK(count <= capacity && t.rows + count <= MOST_ROWS);
        CHECK(count == capacity || t.done == STEPS || t.status != SM_OK);
        memcpy(t.out + t.rows * m->outputs, part, count * m->outputs * sizeof *part);
        t.rows += count;
        free(part);
    } while (t.status == SM_OK && t.done < STEPS);
    return t;
}

static const double *row(const model *m, const trace *t, size_t k) {
    return t->out + k * m->outputs;
}

/* Times rise, and there is a row at the end of each step, with what a run gives there. */
static void check_against_run(int modes, int wanted) {
    model m = new_model(modes, 2, wanted), twin = new_model(modes, 2, wanted);
    double durations[STEPS], *ends = new_doubles(STEPS * m.outputs), end = 0.0;
    sm_inputs inputs[STEPS];
    size_t done, k = 0;
    uint64_t accepted;
    script(durations, inputs);
    const trace t = traced(&m, durations, inputs, 100);
    CHECK_STATUS(t.status, SM_OK);
    CHECK(t.elapsed == 0.0);
    CHECK_STATUS(sm_component_run(twin.component, STEPS, durations, inputs, ends, &done), SM_OK);
    sm_component_work(m.component, &accepted, NULL);
    CHECK(t.rows > 10 * STEPS && accepted >= t.rows);
    for (size_t r = 1; r < t.rows; r++) CHECK(row(&m, &t, r)[0] > row(&m, &t, r - 1)[0]);
    for (int step = 0; step < STEPS; step++) {
        const double *expected = ends + (size_t)step * m.outputs;
        end += durations[step];
        while (k < t.rows && row(&m, &t, k)[0] < end - 1e-9) k++;
        CHECK(k < t.rows);
        CHECK_NEAR(row(&m, &t, k)[0], end, 1e-12);
        for (int output = 1; output < 5; output++)
            CHECK_NEAR(row(&m, &t, k)[output], expected[output], 1e-6);
        k++;
    }
    CHECK(k == t.rows);
    free(ends);
    free(t.out);
    free_model(&m);
    free_model(&twin);
}

/* In calls of any capacity: the same rows and the same state, to the bit. */
static void check_parts(int wanted) {
    model m = new_model(2, 2, wanted);
    double durations[STEPS], *states[2] = {new_doubles(m.state), new_doubles(m.state)};
    sm_inputs inputs[STEPS];
    script(durations, inputs);
    const trace whole = traced(&m, durations, inputs, MOST_ROWS);
    CHECK_STATUS(whole.status, SM_OK);
    CHECK_STATUS(sm_component_get_state(m.component, states[0]), SM_OK);
    for (size_t capacity = 1; capacity <= 7; capacity += 3) {
        model other = new_model(2, 2, wanted);
        const trace parts = traced(&other, durations, inputs, capacity);
        CHECK_STATUS(parts.status, SM_OK);
        CHECK(parts.rows == whole.rows);
        CHECK(memcmp(parts.out, whole.out, whole.rows * m.outputs * sizeof(double)) == 0);
        CHECK_STATUS(sm_component_get_state(other.component, states[1]), SM_OK);
        CHECK(memcmp(states[0], states[1], m.state * sizeof(double)) == 0);
        free(parts.out);
        free_model(&other);
    }
    free(states[0]);
    free(states[1]);
    free(whole.out);
    free_model(&m);
}

/* Where a step cannot be taken the trace stops at its last row, and says which step it was. */
static void check_failure(double duration, double force, size_t done, sm_status expected) {
    model m = new_model(2, 2, 1);
    double durations[STEPS], *now = new_doubles(m.outputs);
    sm_inputs inputs[STEPS];
    script(durations, inputs);
    durations[done] = duration;
    inputs[done].force[0] = force;
    const trace t = traced(&m, durations, inputs, 50);
    CHECK_STATUS(t.status, expected);
    CHECK(t.done == done && t.rows > 0);
    CHECK(t.elapsed >= 0.0 && (t.elapsed == 0.0 || t.elapsed < durations[done]));
    CHECK_STATUS(sm_component_outputs(m.component, now), SM_OK);
    CHECK(now[0] == row(&m, &t, t.rows - 1)[0]);
    for (int output = 1; output < 7; output++)
        CHECK(now[output] == row(&m, &t, t.rows - 1)[output]);
    if (expected == SM_OUTSIDE_TABLE) {
        CHECK(t.elapsed > 0.0);
        CHECK_NEAR(hypot(now[1], now[2]), 4.0, 0.02); /* up to the edge */
    } else {
        CHECK(t.elapsed == 0.0);
    }
    inputs[done] = resonant_inputs();
    inputs[done].force[0] = 0.0;
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs[done]), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 1.0), SM_OK);
    free(now);
    free(t.out);
    free_model(&m);
}

/* Nothing to do changes nothing; nothing is read or written where a pointer is missing. */
static void check_nothing_to_do(void) {
    model m = new_model(1, 1, 0);
    double durations[STEPS], *before = new_doubles(m.state), *after = new_doubles(m.state);
    double out[SM_OUTPUTS_FIXED];
    sm_inputs inputs[STEPS];
    sm_trace rows = {.capacity = 1, .count = 99, .outputs = out, .done = STEPS};
    sm_component *c = m.component;
    script(durations, inputs);
    CHECK_STATUS(sm_component_get_state(c, before), SM_OK);
    CHECK_STATUS(sm_component_trace(c, STEPS, durations, inputs, &rows), SM_OK);
    CHECK(rows.count == 0 && rows.done == STEPS && rows.elapsed == 0.0);
    rows.done = rows.capacity = 0;
    CHECK_STATUS(sm_component_trace(c, STEPS, durations, inputs, &rows), SM_OK);
    CHECK(rows.count == 0 && rows.done == 0 && rows.elapsed == 0.0);
    CHECK_STATUS(sm_component_trace(NULL, 1, durations, inputs, &rows), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_trace(c, 1, NULL, inputs, &rows), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_trace(c, 1, durations, NULL, &rows), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_trace(c, 1, durations, inputs, NULL), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, rows.outputs, NULL, sm_component_trace(c, 1, durations, inputs, &rows),
                  SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_get_state(c, after), SM_OK);
    CHECK(memcmp(before, after, m.state * sizeof(double)) == 0);
    free(before);
    free(after);
    free_model(&m);
}

void check_component_trace(void) {
    for (int modes = 1; modes <= 2; modes++) {
        check_against_run(modes, 0);
        check_against_run(modes, 1);
    }
    check_parts(0);
    check_parts(1);
    check_failure(-1.0, 0.15, 2, SM_BAD_ARGUMENT);
    check_failure(NAN, 0.15, 1, SM_NOT_FINITE);
    check_failure(10.0, NAN, 3, SM_NOT_FINITE);
    check_failure(1000.0, 10.0, 2, SM_OUTSIDE_TABLE);
    check_nothing_to_do();
}
