/* Random calls with a fixed seed: whatever the arguments, an answer without a NaN or a status. And
 * calls that are refused. */
#include "component.h"

void check_random_calls(int times);
void check_refusals(int times);
void check_friction_refusals(void);
void check_elastic_refusals(void);
void check_torus_refusals(void);
void check_slow_flow_refusals(void);
void check_curves_refusals(void);
void check_tone_refusals(void);
void check_full_refusals(void);
int random_elastic_call(void);

static void random_rate(void) {
    table t = new_table(1 + random_below(2), 4, 4);
    double rate[4], powers[2], amplitude[4];
    const size_t terms = 2 * (size_t)t.table.modes;
    sm_slow_flow flow = flow_over(&t);
    sm_inputs inputs = resonant_inputs();
    for (int k = 0; k < 4; k++) amplitude[k] = 3.0 * random_number();
    spoil(t.values, 32);
    spoil(amplitude, 4);
    check_response(sm_table_lookup(&t.table, 1, amplitude, rate), rate, terms);
    spoil((double *)&inputs, INPUT_COUNT);
    spoil(flow.natural, 2);
    const sm_status status = sm_slow_flow_rate(&flow, &inputs, random_number(), amplitude, rate,
                                               powers);
    check_response(status, rate, terms);
    check_response(status, powers, 2);
    free_doubles();
}

/* One call on a component; a refused one must leave the state alone. A step that succeeds has
 * outputs; if only its contact motion fails, these are NaN. */
static void random_component_call(model *m, double *before, double *state, double *out) {
    sm_component *c = m->component;
    sm_inputs inputs = resonant_inputs();
    sm_status status = SM_OK;
    double duration = 3.0 * random_number(), amplitude[] = {1.0, 0.5, 0.1, -1.0}, time = 3.0;
    sm_trace trace = {.capacity = 1, .outputs = out};
    size_t done = 0;
    CHECK_STATUS(sm_component_get_state(c, before), SM_OK);
    switch (random_below(6)) {
    case 0: /* a force whose phase races is noise, which is followed honestly and slowly */
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
        if (random_below(3) == 0) spoil(&duration, 1);
        status = sm_component_trace(c, 1, &duration, &inputs, &trace);
        done = trace.count;
        CHECK(trace.done <= done && done <= 1 && trace.elapsed >= 0.0);
        if (status == SM_OK) check_response(status, out, m->outputs);
        else CHECK(done == 0 || isnan(out[m->outputs - 1]));
        return; /* the inputs have moved on in any case */
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
    const double zero[4] = {0.0};
    const sm_inputs inputs = resonant_inputs();
    model m;
    new_model(&m, modes, 2, wanted);
    double *before = new_doubles(m.state), *state = new_doubles(m.state);
    double *out = new_doubles(m.outputs);
    for (int k = 0; k < calls; k++) random_component_call(&m, before, state, out);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK); /* and it still works */
    CHECK_STATUS(sm_component_reset(m.component, 0.0, zero), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 1.0), SM_OK);
    free_model(&m);
    free_doubles();
}

void check_random_calls(int times) {
    int solved = 0;
    for (int k = 0; k < times * 1000; k++) {
        random_rate();
        if (k % 4 == 0) solved += random_elastic_call();
    }
    CHECK(solved > 80 * times && solved < 245 * times); /* neither all harmless nor all hopeless */
    for (int k = 0; k < 4; k++) random_component(1 + k % 2, k / 2, times * 500);
}

static void check_creation(model *m) {
    REFUSES(&m->tolerance, create_again, m, 0.0, -1e-6, 1.0, 2.0);
    REFUSES(&m->flow.natural[1], create_again, m, 0.0);
    REFUSES(&m->t.node_a[2], create_again, m, 0.0);
    REFUSES(&m->p.limit[1], create_again, m, -1.0);
    REFUSES(&m->motion.memory_periods, create_again, m, 0.0);
    REFUSES_INTS(&m->p.contact.modes, create_again, m, 1);
    REFUSES_INTS(&m->motion.elastic, create_again, m, -1, INT32_MIN, 1000001, INT32_MAX);
    REFUSES_INTS(&m->motion.steps_per_period, create_again, m, 3, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&m->motion.orders_count, create_again, m, -1, INT32_MIN, 513, INT32_MAX);
    REFUSES_INTS(&m->orders[1], create_again, m, 129);
    REFUSES_NULL(create_again, m, &m->motion.orders, &m->motion.reaction, &m->motion.response,
                 &m->motion.modes_out, &m->motion.contacts_out);
    REFUSES_NOT_FINITE(create_again, m, {&m->tolerance, 1}, {m->flow.natural, 4},
                       {m->t.values, 16}, {m->p.limit, 2}, {m->modes_out, ELASTIC * 4},
                       {m->forces_out, ELASTIC * 4}, {m->contacts_out, ELASTIC * 2},
                       {m->reaction, 200}, {m->response, 200});
    check_no_memory(create_again, m);
    m->tolerance = 1e-300; /* which no step can follow */
    CHECK_STATUS(create_again(m), SM_OK);
    const sm_inputs inputs = resonant_inputs();
    CHECK_STATUS(sm_component_set_inputs(m->component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_step(m->component, 1.0), SM_STEP_TOO_SMALL);
    CHECK_STATUS(sm_component_reset(m->component, 0.0, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_inputs(m->component, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_outputs(m->component, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_set_state(m->component, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_component_step(NULL, 1.0), SM_BAD_ARGUMENT);
}

void check_refusals(int times) {
    void (*const others[])(void) = {check_friction_refusals,  check_elastic_refusals,
                                    check_torus_refusals,     check_slow_flow_refusals,
                                    check_curves_refusals,    check_tone_refusals,
                                    check_full_refusals};
    model m;
    (void)times;
    for (size_t k = 0; k < COUNT(others); k++) others[k]();
    new_model(&m, 2, 2, 1);
    check_creation(&m);
    free_model(&m);
    for (int k = SM_OK; k <= SM_STEP_TOO_SMALL; k++)
        for (int other = SM_OK; other < k; other++)
            CHECK(strcmp(sm_message((sm_status)k), sm_message((sm_status)other)) != 0);
}
