/* The step-able component: wrong use. Nothing that is refused changes its state. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "component.h"

#define MOST_STATE 2048 /* doubles */

static void check_null(model *m) {
    double values[64] = {0.0};
    sm_component *made, *c = m->component;
    const sm_inputs inputs = resonant_inputs();
    size_t done;
    uint64_t accepted = 7, rejected = 7;
    const double tolerance = m->tolerance;
    CHECK_STATUS(sm_component_create(NULL, &m->p.contact, &m->motion, tolerance, &made),
                 SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_create(&m->flow, NULL, &m->motion, tolerance, &made),
                 SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_create(&m->flow, &m->p.contact, NULL, tolerance, &made),
                 SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_create(&m->flow, &m->p.contact, &m->motion, tolerance, NULL),
                 SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_reset(NULL, 0.0, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_reset(c, 0.0, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_inputs(NULL, &inputs), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_inputs(c, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_step(NULL, 1.0), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_outputs(NULL, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_outputs(c, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_run(NULL, 1, values, &inputs, values, &done), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_run(c, 1, NULL, &inputs, values, &done), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_run(c, 1, values, NULL, values, &done), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_run(c, 1, values, &inputs, NULL, &done), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_run(c, 1, values, &inputs, values, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_recent_motion(NULL, &inputs, values, values, 0, values),
                 SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_recent_motion(c, NULL, values, values, 0, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_recent_motion(c, &inputs, NULL, values, 0, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_recent_motion(c, &inputs, values, NULL, 0, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_recent_motion(c, &inputs, values, values, 0, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_get_state(NULL, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_get_state(c, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_state(NULL, values), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_state(c, NULL), SM_BAD_ARGUMENT);
    CHECK(sm_component_output_count(NULL) == 0 && sm_component_state_count(NULL) == 0);
    sm_component_work(NULL, &accepted, &rejected);
    CHECK(accepted == 0 && rejected == 0);
    sm_component_work(c, NULL, NULL);
    sm_component_free(NULL);
}

static void check_creation_not_finite(model *m) {
    CHECK_REFUSES_NOT_FINITE(&m->tolerance, 1, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->flow.natural, 2, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->flow.damping, 2, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->t.node_a, 4, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->t.values, 16, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->p.limit, 2, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->p.stiffness, 4, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->modes_out, ELASTIC * 4, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->forces_out, ELASTIC * 4, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->reaction, m->reactions, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->response, m->responses, create_once, m);
    CHECK_REFUSES_NOT_FINITE(m->contacts_out, ELASTIC * 2, create_once, m);
    CHECK_REFUSES_NOT_FINITE(&m->motion.memory_periods, 1, create_once, m);
}

static void check_creation(model *m) {
    const double bad_tolerances[] = {0.0, -1e-6, 1.0, 2.0};
    for (int k = 0; k < 4; k++)
        CHECK_REFUSES(double, m->tolerance, bad_tolerances[k], create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, m->flow.natural[1], 0.0, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, m->t.node_a[2], 0.0, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, m->p.limit[1], -1.0, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, m->p.contact.modes, 1, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, m->flow.table.modes, 1, create_once(m), SM_BAD_ARGUMENT);
    const int32_t wrong[] = {-1, INT32_MIN, 1000001, INT32_MAX};
    for (int k = 0; k < 4; k++) {
        CHECK_REFUSES(int32_t, m->motion.elastic, wrong[k], create_once(m), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, m->motion.steps_per_period, wrong[k], create_once(m),
                      SM_BAD_ARGUMENT);
    }
    const int32_t counts[] = {-1, INT32_MIN, 513, INT32_MAX};
    for (int k = 0; k < 4; k++)
        CHECK_REFUSES(int32_t, m->motion.orders_count, counts[k], create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, m->orders[1], 129, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const int32_t *, m->motion.orders, NULL, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, m->motion.reaction, NULL, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, m->motion.response, NULL, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, m->motion.steps_per_period, 3, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, m->motion.memory_periods, 0.0, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, m->motion.modes_out, NULL, create_once(m), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, m->motion.contacts_out, NULL, create_once(m), SM_BAD_ARGUMENT);
    /* what is not wanted need not be valid */
    m->motion.wanted = 0;
    CHECK_REFUSES(const double *, m->motion.modes_out, NULL, create_once(m), SM_OK);
    m->motion.wanted = 1;
    allocations_left = 0;
    CHECK_STATUS(create_once(m), SM_NO_MEMORY);
    allocations_left = -1;
    CHECK_STATUS(create_once(m), SM_OK);
}

/* The call fails with this status and leaves the state as it was. */
#define CHECK_KEEPS_STATE(m, call, expected)                                              \
    do {                                                                                  \
        double before[MOST_STATE], after[MOST_STATE];                                     \
        CHECK((m)->state <= MOST_STATE);                                                  \
        CHECK_STATUS(sm_component_get_state((m)->component, before), SM_OK);              \
        CHECK_STATUS(call, expected);                                                     \
        CHECK_STATUS(sm_component_get_state((m)->component, after), SM_OK);               \
        CHECK(memcmp(before, after, (m)->state * sizeof(double)) == 0);                   \
    } while (0)

static sm_status set_inputs(void *arguments) {
    void **pair = arguments;
    return sm_component_set_inputs(pair[0], pair[1]);
}

static sm_status set_state(void *arguments) {
    void **pair = arguments;
    return sm_component_set_state(pair[0], pair[1]);
}

static void check_inputs(model *m) {
    sm_inputs inputs = resonant_inputs();
    sm_component *c = m->component;
    void *pair[] = {c, &inputs};
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_REFUSES_NOT_FINITE((double *)&inputs, INPUT_COUNT, set_inputs, pair);
    for (int j = 0; j < 2; j++) {
        CHECK_REFUSES(double, inputs.frequency[j], 0.0, sm_component_set_inputs(c, &inputs),
                      SM_BAD_ARGUMENT);
        inputs.frequency[j] *= -1.0;
        CHECK_KEEPS_STATE(m, sm_component_set_inputs(c, &inputs), SM_BAD_ARGUMENT);
        inputs.frequency[j] *= -1.0;
    }
    inputs.limit_scale = 1.5; /* of the tanh law */
    CHECK_KEEPS_STATE(m, sm_component_set_inputs(c, &inputs), SM_BAD_ARGUMENT);
}

static void check_steps(model *m) {
    sm_component *c = m->component;
    sm_inputs inputs = resonant_inputs();
    CHECK_STATUS(sm_component_step(c, 12.3), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 0.0), SM_BAD_ARGUMENT);
    CHECK_KEEPS_STATE(m, sm_component_step(c, -1.0), SM_BAD_ARGUMENT);
    CHECK_KEEPS_STATE(m, sm_component_step(c, NAN), SM_NOT_FINITE);
    CHECK_KEEPS_STATE(m, sm_component_step(c, INFINITY), SM_NOT_FINITE);
    inputs.frequency_rate[1] = -0.5; /* zero after 3.3 s */
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 4.0), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_step(c, 0.5), SM_OK);
    inputs = resonant_inputs();
    inputs.force[0] = 10.0;
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 1000.0), SM_OUTSIDE_TABLE);
    inputs.force[0] = 1e100; /* beyond the table at once, or beyond any number */
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 1.0), SM_OUTSIDE_TABLE);
    inputs.force[0] = 1e308;
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 1.0), SM_NOT_FINITE);
    inputs.force[0] = 0.0;
    inputs.force_rate[0] = 1e308; /* the input itself overflows on the way */
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_KEEPS_STATE(m, sm_component_step(c, 10.0), SM_NOT_FINITE);
    inputs = resonant_inputs();
    CHECK_STATUS(sm_component_set_inputs(c, &inputs), SM_OK);
    CHECK_STATUS(sm_component_step(c, 1.0), SM_OK);
}

static void check_resets(model *m) {
    sm_component *c = m->component;
    const double outside[4] = {2.0, 3.5, 0.0, 0.0}, wrong[4] = {0.0, 0.0, NAN, 0.0};
    const double infinite[4] = {-INFINITY, NAN, 0.0, 0.0}, zero[4] = {0.0};
    CHECK_KEEPS_STATE(m, sm_component_reset(c, 0.0, outside), SM_OUTSIDE_TABLE);
    CHECK_KEEPS_STATE(m, sm_component_reset(c, 0.0, wrong), SM_NOT_FINITE);
    CHECK_KEEPS_STATE(m, sm_component_reset(c, 0.0, infinite), SM_NOT_FINITE);
    CHECK_KEEPS_STATE(m, sm_component_reset(c, NAN, zero), SM_NOT_FINITE);
    CHECK_KEEPS_STATE(m, sm_component_reset(c, -INFINITY, zero), SM_NOT_FINITE);
    CHECK_STATUS(sm_component_reset(c, 1e308, zero), SM_OK);
    CHECK_STATUS(sm_component_step(c, 1.0), SM_OK);
    CHECK_STATUS(sm_component_reset(c, 0.0, zero), SM_OK);
}

static void check_states(model *m) {
    double *state = new_doubles(m->state);
    void *pair[] = {m->component, state};
    CHECK_STATUS(sm_component_get_state(m->component, state), SM_OK);
    CHECK_REFUSES_NOT_FINITE(state, m->state, set_state, pair);
    state[8] = 4.1; /* Re a_A: after time, energy and two angles, each a value and a carry */
    CHECK_KEEPS_STATE(m, set_state(pair), SM_OUTSIDE_TABLE);
    state[8] = 0.5;
    CHECK_STATUS(set_state(pair), SM_OK);
    state[18 + 4] = -0.98; /* frequency of mode A: after step, held forces, forces and rates */
    CHECK_KEEPS_STATE(m, set_state(pair), SM_BAD_ARGUMENT);
    free(state);
}

/* What a one-mode component is told about mode B is no matter. */
static void check_absent_mode(void) {
    model m = new_model(1, 1, 1);
    double state[MOST_STATE], out[64];
    sm_inputs inputs = resonant_inputs();
    inputs.force[1] = inputs.frequency[1] = inputs.phase_rate[1] = NAN;
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 10.0), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
    CHECK_FINITE(out, m.outputs);
    CHECK_STATUS(sm_component_get_state(m.component, state), SM_OK);
    CHECK_STATUS(sm_component_set_state(m.component, state), SM_OK);
    free_model(&m);
}

/* A model that no internal step can follow. */
static void check_impossible_tolerance(void) {
    model m = new_model(1, 1, 0);
    const sm_inputs inputs = resonant_inputs();
    sm_component_free(m.component);
    CHECK_STATUS(sm_component_create(&m.flow, &m.p.contact, &m.motion, 1e-300, &m.component),
                 SM_OK);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_KEEPS_STATE(&m, sm_component_step(m.component, 1.0), SM_STEP_TOO_SMALL);
    free_model(&m);
}

static void check_messages(void) {
    for (int k = SM_OK; k <= SM_STEP_TOO_SMALL; k++)
        for (int other = SM_OK; other < k; other++)
            CHECK(strcmp(sm_message((sm_status)k), sm_message((sm_status)other)) != 0);
    CHECK(strlen(sm_message((sm_status)7)) > 0); /* even one that no entry returns */
}

void check_component_refusals(void) {
    model m = new_model(2, 2, 1);
    check_null(&m);
    check_inputs(&m);
    check_steps(&m);
    check_resets(&m);
    check_states(&m);
    check_creation_not_finite(&m);
    check_creation(&m);
    free_model(&m);
    check_absent_mode();
    check_impossible_tolerance();
    check_messages();
}
