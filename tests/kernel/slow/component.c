/* The step-able component: time and angles of long runs. */
#include "component.h"

void check_long_run(int times);

/* Harmonics of `width` signals at the nodes, linear in the amplitudes. */
static double *new_response(const model *m, int width) {
    const int count_b = m->t.table.count_b, all = COUNT_A * count_b * ORDERS * width * 2;
    double *values = new_doubles((size_t)all);
    for (int k = 0; k < all; k++) {
        const int node = k / (ORDERS * width * 2), order = k / (2 * width) % ORDERS;
        const double b = m->t.node_b ? m->t.node_b[node % count_b] : 0.0;
        values[k] = 0.01 * (order + 1) * (m->t.node_a[node / count_b] - 0.5 * b)
                    * (k % 2 ? -0.3 : 1.0) * (1.0 + k / 2 % width);
    }
    return values;
}

sm_status create_again(void *arguments) {
    model *m = arguments;
    sm_component *made = NULL;
    const sm_status status =
        sm_component_create(&m->flow, &m->p.contact, &m->motion, m->tolerance, &made);
    CHECK((status == SM_OK) == (made != NULL));
    if (status != SM_OK) return status;
    sm_component_free(m->component);
    m->component = made;
    m->outputs = sm_component_output_count(made);
    m->state = sm_component_state_count(made);
    return status;
}

void free_model(model *m) { sm_component_free(m->component); }

void new_model(model *m, int modes, int contacts, int wanted) {
    const int32_t orders[2][2 * ORDERS] = {{1, 0, 3, 0, 5, 0}, {0, 1, 2, -1, -3, 2}};
    *m = (model){.t = new_table(modes, COUNT_A, COUNT_B),
                 .p = new_problem(contacts, modes, SM_TANH),
                 .modes_out = new_doubles((size_t)(2 * ELASTIC * modes)),
                 .forces_out = new_doubles((size_t)(2 * ELASTIC * modes)),
                 .contacts_out = new_doubles((size_t)(ELASTIC * contacts)), .tolerance = 1e-8};
    memcpy(m->orders, orders[modes - 1], sizeof m->orders);
    m->reaction = new_response(m, contacts);
    m->response = new_response(m, ELASTIC);
    for (int k = 0; k < 2 * ELASTIC * modes; k++) m->modes_out[k] = 0.3 + 0.1 * k;
    for (int k = 0; k < 2 * ELASTIC * modes; k++) m->forces_out[k] = 0.2 - 0.1 * k;
    for (int k = 0; k < ELASTIC * contacts; k++) m->contacts_out[k] = 0.7 - 0.05 * k;
    m->flow = flow_over(&m->t);
    m->motion = (sm_motion){wanted, ELASTIC, m->modes_out, m->forces_out, m->contacts_out, ORDERS,
                            m->orders, m->reaction, m->response, 32, 4.0};
    CHECK_STATUS(create_again(m), SM_OK);
}

/* An angle less its whole turns, with 2 pi to twice the precision of a double. */
static double angle_of(double radians) {
    const double turns = floor(radians / TWO_PI), two_pi_low = 2.4492935982947064e-16;
    return fma(-turns, TWO_PI, radians) - turns * two_pi_low;
}

static void check_many_steps(int steps, double h, double frequency, double exact) {
    model m;
    const sm_inputs inputs = {.frequency = {frequency, 0.0}, .limit_scale = 1.0};
    double out[SM_OUTPUTS_FIXED];
    new_model(&m, 1, 1, 0);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < steps; k++) CHECK_STATUS(sm_component_step(m.component, h), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
    CHECK_NEAR(out[0], h * steps, 1e-16 * h * steps);
    CHECK_NEAR(out[5], angle_of(exact), 1e-10);
    free_model(&m);
}

/* Steps of 0.1 s, up to a million: a plain sum of the time is off by 1e-7 to 1e-6 s. And 1.1e7
 * periods in steps of exactly 7168 rad: a 2 pi in double precision is off by 3e-9 rad after as
 * many turns. */
void check_long_run(int times) {
    const int steps = 250000 * times;
    check_many_steps(steps, 0.1, 1.7, 0.17 * steps);
    check_many_steps(10000, 4096.0, 1.75, 7.168e7);
}
