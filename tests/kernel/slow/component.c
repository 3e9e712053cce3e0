/* The step-able component: contact outputs in equilibrium, time and angles of long runs. */
#include "component.h"

void check_component(int times);
void check_long_run(int times);

/* Harmonics of `width` signals at the nodes that a linear surface holds exactly. */
static double response_at(double a, double b, int order, int part, int signal) {
    return 0.01 * (order + 1) * (a - 0.5 * b) * (part == 0 ? 1.0 : -0.3) * (1.0 + signal);
}

static double *new_response(const model *m, int width) {
    const int count_b = m->t.table.count_b, all = COUNT_A * count_b * ORDERS * width * 2;
    double *values = new_doubles((size_t)all);
    for (int k = 0; k < all; k++) {
        const int node = k / (ORDERS * width * 2);
        const double b = m->t.node_b ? m->t.node_b[node % count_b] : 0.0;
        values[k] = response_at(m->t.node_a[node / count_b], b, k / (2 * width) % ORDERS, k % 2,
                                k / 2 % width);
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

/* Re sum c_nm exp(i (n theta_A + m theta_B)), what the modes respond at a signal, from the
 * outputs. */
static double response_in(const model *m, const double *out, int signal) {
    double complex q[2] = {0.0, 0.0}, phasor[2] = {1.0, 1.0};
    double sum = 0.0;
    for (int j = 0; j < m->flow.table.modes; j++) {
        q[j] = out[1 + 2 * j] + I * out[2 + 2 * j];
        phasor[j] = cexp(I * out[5 + j]) * q[j] / cabs(q[j]);
    }
    for (int k = 0; k < ORDERS; k++) {
        const double re = response_at(cabs(q[0]), cabs(q[1]), k, 0, signal);
        const double im = response_at(cabs(q[0]), cabs(q[1]), k, 1, signal);
        sum += creal((re + I * im) * cpow(phasor[0], m->orders[2 * k])
                     * cpow(phasor[1], m->orders[2 * k + 1]));
    }
    return sum;
}

/* Contacts in equilibrium with the amplitudes and the modes' response at the communication point;
 * elastic outputs their linear combination. */
static void check_motion_outputs(int modes, int contacts) {
    model m;
    const sm_inputs inputs = resonant_inputs();
    new_model(&m, modes, contacts, 1);
    double *out = new_doubles(m.outputs), largest = 0.0;
    CHECK(m.outputs == (size_t)(SM_OUTPUTS_FIXED + 3 * contacts + ELASTIC));
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < 20; k++) {
        CHECK_STATUS(sm_component_step(m.component, 0.3 + (k % 5) * 7.0), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
        const double *x = out + SM_OUTPUTS_FIXED, *v = x + contacts, *f = v + contacts;
        double complex q[2] = {0.0, 0.0};
        for (int j = 0; j < modes; j++)
            q[j] = 2.0 * (out[1 + 2 * j] + I * out[2 + 2 * j]) * cexp(I * out[5 + j]);
        for (int i = 0; i < contacts; i++) {
            double left = f[i] - response_in(&m, out, i);
            for (int c = 0; c < contacts; c++)
                left += m.p.stiffness[i * contacts + c] * x[c]
                        + m.p.damping[i * contacts + c] * v[c];
            for (int j = 0; j < modes; j++) {
                const double *L = m.p.coupling + 2 * (j * contacts + i);
                left += creal((L[0] + I * L[1]) * q[j]);
            }
            CHECK_NEAR(left, 0.0, 1e-9);
            CHECK_NEAR(f[i], m.p.limit[i] * tanh(v[i] / 0.02), 1e-9);
            largest = fmax(largest, fabs(x[i]));
        }
        for (int e = 0; e < ELASTIC; e++) {
            double sum = response_in(&m, out, e);
            for (int j = 0; j < modes; j++) {
                const double *shape = m.modes_out + 2 * (e * modes + j);
                const double *by_force = m.forces_out + 2 * (e * modes + j);
                const double complex force = 2.0 * inputs.force[j] * cexp(I * out[5 + j]);
                sum += creal((shape[0] + I * shape[1]) * q[j]
                             + (by_force[0] + I * by_force[1]) * force);
            }
            for (int c = 0; c < contacts; c++) sum += m.contacts_out[e * contacts + c] * x[c];
            CHECK_NEAR(f[contacts + e], sum, 1e-13);
        }
    }
    CHECK(largest > 1e-3);
    free_model(&m);
}

void check_component(int times) {
    (void)times;
    for (int modes = 1; modes <= 2; modes++) {
        check_motion_outputs(modes, 1);
        check_motion_outputs(modes, 3);
    }
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
