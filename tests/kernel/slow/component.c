/* The step-able component: runs in closed form, outputs, states. */
#include "component.h"

void check_component(int times);
void check_long_run(int times);
void check_trace(int times);

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

/* Without friction q'' + d q' + natural^2 q = 0 beside the steady motion: the mode vibrates as it
 * does by itself, a(t) = a_s + (a_0 - a_s) exp(s t), s = -d / 2 + i (sqrt(natural^2 - d^2 / 4) -
 * Omega). Returns the error of the amplitudes. Steps take no memory. */
static double linear_error(double tolerance, double *steps) {
    model m;
    const double start[4] = {0.5, 0.1, -0.3, 0.2};
    const sm_inputs inputs = {.force = {0.01, 0.02}, .frequency = {0.98, 1.65},
                              .phase = {0.4, -1.0}, .limit_scale = 1.0};
    double out[SM_OUTPUTS_FIXED], worst = 0.0;
    uint64_t accepted;
    new_model(&m, 2, 1, 0);
    memset(m.t.values, 0, COUNT_A * COUNT_B * 16 * sizeof(double));
    m.tolerance = tolerance;
    CHECK_STATUS(create_again(&m), SM_OK);
    CHECK_STATUS(sm_component_reset(m.component, 100.0, start), SM_OK);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    allocations_left = 0;
    for (double time = 140.0; time < 400.0; time += 140.0) {
        CHECK_STATUS(sm_component_step(m.component, 140.0), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
        CHECK_NEAR(out[0], 100.0 + time, 1e-12);
        for (int j = 0; j < 2; j++) {
            const double Omega = inputs.frequency[j], d = m.flow.damping[j];
            const double square = m.flow.natural[j] * m.flow.natural[j];
            const double complex slow = -0.5 * d + I * (sqrt(square - 0.25 * d * d) - Omega);
            const double complex steady = 0.5 * inputs.force[j] * cexp(I * inputs.phase[j])
                                          / (square - Omega * Omega + I * d * Omega);
            const double complex from = start[2 * j] + I * start[2 * j + 1] - steady;
            const double complex a = steady + from * cexp(slow * time);
            worst = fmax(worst, cabs(out[1 + 2 * j] + I * out[2 + 2 * j] - a));
            CHECK_NEAR(cos(out[5 + j] - time * Omega), 1.0, 1e-15);
            CHECK(out[5 + j] >= 0.0 && out[5 + j] < TWO_PI);
        }
        CHECK(out[8] == 0.0 && out[9] == 0.0);
    }
    allocations_left = -1;
    sm_component_work(m.component, &accepted, NULL);
    *steps = (double)accepted;
    free_model(&m);
    return worst;
}

/* Steps are controlled by the error of fourth order in h of a fifth-order step: their number grows
 * as tolerance^(-1/5), and the error stays within the tolerance times the amplitudes, which are
 * below 0.6. */
static void check_linear_response(void) {
    double steps[2];
    const double coarse = linear_error(1e-5, &steps[0]), fine = linear_error(1e-10, &steps[1]);
    CHECK(coarse <= 0.6 * 1e-5 && fine <= 0.6 * 1e-10);
    CHECK_NEAR(log10(steps[1] / steps[0]), 1.0, 0.1);
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

/* A jump of the force, a step shorter than an internal one, a sweep, a ramp. */
enum { STEPS = 4, ROWS = 4000 };
static const double DURATION[STEPS] = {50.0, 1e-6, 700.0, 200.0};

static void script(sm_inputs *inputs) {
    for (int k = 0; k < STEPS; k++) inputs[k] = resonant_inputs();
    inputs[2].force[0] = 0.05;
    inputs[2].frequency_rate[0] = 2e-5;
    inputs[3].force_rate[1] = -2e-4;
}

void check_component(int times) {
    (void)times;
    check_linear_response();
    for (int modes = 1; modes <= 2; modes++) {
        check_motion_outputs(modes, 1);
        check_motion_outputs(modes, 3);
    }
}

/* A trace in calls of few rows ends in the same state as in one call, to the bit, and its last row
 * is what outputs are there. From that state another component takes the same steps. */
void check_trace(int times) {
    (void)times;
    for (int wanted = 0; wanted <= 1; wanted++) {
        model m, other;
        sm_inputs inputs[STEPS];
        const double rest[4] = {0.0};
        size_t done;
        script(inputs);
        new_model(&m, 2, 2, wanted);
        new_model(&other, 2, 2, wanted);
        const size_t size = m.outputs * sizeof(double);
        double *rows = new_doubles(ROWS * m.outputs), *out = new_doubles(STEPS * m.outputs);
        double *again = new_doubles(STEPS * m.outputs), *states[2];
        for (int k = 0; k < 2; k++) {
            sm_trace t = {.capacity = k ? 7 : ROWS, .outputs = rows};
            states[k] = new_doubles(m.state);
            CHECK_STATUS(sm_component_reset(m.component, 0.0, rest), SM_OK);
            while (t.done < STEPS) {
                CHECK_STATUS(sm_component_trace(m.component, STEPS, DURATION, inputs, &t), SM_OK);
                CHECK(t.count == t.capacity || (t.count < t.capacity && t.done == STEPS));
            }
            CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
            CHECK(memcmp(out, rows + (t.count - 1) * m.outputs, size) == 0);
            CHECK_STATUS(sm_component_get_state(m.component, states[k]), SM_OK);
        }
        CHECK(memcmp(states[0], states[1], m.state * sizeof(double)) == 0);
        CHECK_STATUS(sm_component_set_state(other.component, states[0]), SM_OK);
        CHECK_STATUS(sm_component_run(m.component, STEPS, DURATION, inputs, out, &done), SM_OK);
        CHECK_STATUS(sm_component_run(other.component, STEPS, DURATION, inputs, again, &done),
                     SM_OK);
        CHECK(memcmp(out, again, STEPS * size) == 0);
        free_model(&m);
        free_model(&other);
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
