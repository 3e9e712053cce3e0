/* The step-able component: correct use. */
#include "component.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"

#define COUNT_A 4
#define COUNT_B 5

/* Harmonics of `width` signals at the nodes that a linear surface holds exactly. */
static double response_at(double a, double b, int order, int part, size_t signal) {
    return 0.01 * (order + 1) * (a - 0.5 * b) * (part == 0 ? 1.0 : -0.3) * (1.0 + (double)signal);
}

static double *new_response(const table *t, size_t width) {
    const size_t count_b = (size_t)t->table.count_b;
    double *values = new_doubles(COUNT_A * count_b * ORDERS * width * 2), *v = values;
    for (size_t k = 0; k < COUNT_A * count_b; k++)
        for (int q = 0; q < ORDERS; q++)
            for (size_t s = 0; s < width; s++)
                for (int part = 0; part < 2; part++)
                    *v++ = response_at(t->node_a[k / count_b],
                                     t->node_b ? t->node_b[k % count_b] : 0.0, q, part, s);
    return values;
}

model new_model(int modes, int contacts, int wanted) {
    model m = {.t = new_table(modes, COUNT_A, COUNT_B),
               .p = new_problem(contacts, modes, SM_TANH),
               .modes_out = new_doubles((size_t)(2 * ELASTIC * modes)),
               .forces_out = new_doubles((size_t)(2 * ELASTIC * modes)),
               .contacts_out = new_doubles((size_t)(ELASTIC * contacts)),
               .orders = malloc(2 * ORDERS * sizeof(int32_t)),
               .tolerance = 1e-8};
    const int32_t orders[2][2 * ORDERS] = {{1, 0, 3, 0, 5, 0}, {0, 1, 2, -1, -3, 2}};
    if (!m.orders) abort();
    memcpy(m.orders, orders[modes - 1], sizeof orders[0]);
    m.reaction = new_response(&m.t, (size_t)contacts);
    m.response = new_response(&m.t, ELASTIC);
    m.reactions = (size_t)(COUNT_A * m.t.table.count_b * ORDERS * contacts * 2);
    m.responses = (size_t)(COUNT_A * m.t.table.count_b * ORDERS * ELASTIC * 2);
    for (int k = 0; k < 2 * ELASTIC * modes; k++) m.modes_out[k] = 0.3 + 0.1 * k;
    for (int k = 0; k < 2 * ELASTIC * modes; k++) m.forces_out[k] = 0.2 - 0.1 * k;
    for (int k = 0; k < ELASTIC * contacts; k++) m.contacts_out[k] = 0.7 - 0.05 * k;
    m.flow = flow_over(&m.t);
    m.motion = (sm_motion){.wanted = wanted,
                           .elastic = ELASTIC,
                           .modes_out = m.modes_out,
                           .forces_out = m.forces_out,
                           .contacts_out = m.contacts_out,
                           .orders_count = ORDERS,
                           .orders = m.orders,
                           .reaction = m.reaction,
                           .response = m.response,
                           .steps_per_period = 32,
                           .memory_periods = 4.0};
    CHECK_STATUS(sm_component_create(&m.flow, &m.p.contact, &m.motion, m.tolerance, &m.component),
                 SM_OK);
    m.outputs = sm_component_output_count(m.component);
    m.state = sm_component_state_count(m.component);
    return m;
}

void free_model(model *m) {
    sm_component_free(m->component);
    free_table(&m->t);
    free_problem(&m->p);
    free(m->modes_out);
    free(m->forces_out);
    free(m->contacts_out);
    free(m->orders);
    free(m->reaction);
    free(m->response);
}

sm_status create_once(void *arguments) {
    model *m = arguments;
    sm_component *made = NULL;
    const sm_status status =
        sm_component_create(&m->flow, &m->p.contact, &m->motion, m->tolerance, &made);
    CHECK((status == SM_OK) == (made != NULL));
    sm_component_free(made);
    return status;
}

/* Without friction q'' + d q' + natural^2 q = 0 beside the steady motion: the mode vibrates as it does
 * by itself, a(t) = a_s + (a_0 - a_s) exp(s t), s = -d / 2 + i (sqrt(natural^2 - d^2 / 4) - Omega). */
static void check_linear_response(void) {
    model m = new_model(2, 1, 0);
    const double start[4] = {0.5, 0.1, -0.3, 0.2};
    const sm_inputs inputs = {.force = {0.01, 0.02},
                              .frequency = {0.98, 1.65},
                              .phase = {0.4, -1.0},
                              .limit_scale = 1.0};
    double out[SM_OUTPUTS_FIXED];
    for (int k = 0; k < 4 * 5 * 16; k++) m.t.values[k] = 0.0;
    sm_component_free(m.component);
    m.tolerance = 1e-11;
    CHECK_STATUS(sm_component_create(&m.flow, &m.p.contact, &m.motion, m.tolerance, &m.component),
                 SM_OK);
    CHECK_STATUS(sm_component_reset(m.component, 100.0, start), SM_OK);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 1; k <= 20; k++) {
        CHECK_STATUS(sm_component_step(m.component, 7.0), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
        CHECK_NEAR(out[0], 100.0 + 7.0 * k, 1e-12);
        for (int j = 0; j < 2; j++) {
            const double Omega = inputs.frequency[j], d = m.flow.damping[j];
            const double square = m.flow.natural[j] * m.flow.natural[j];
            const double complex stiffness = square - Omega * Omega + I * d * Omega;
            const double complex slow = -0.5 * d + I * (sqrt(square - 0.25 * d * d) - Omega);
            const double complex steady =
                0.5 * inputs.force[j] * cexp(I * inputs.phase[j]) / stiffness;
            const double complex a =
                steady + (start[2 * j] + I * start[2 * j + 1] - steady)
                             * cexp(slow * 7.0 * k);
            CHECK_NEAR(cabs(out[1 + 2 * j] + I * out[2 + 2 * j] - a), 0.0, 1e-9);
            CHECK_NEAR(cos(out[5 + j] - 7.0 * k * Omega), 1.0, 1e-15);
            CHECK(out[5 + j] >= 0.0 && out[5 + j] < TWO_PI);
        }
        CHECK(out[8] == 0.0 && out[9] == 0.0);
    }
    free_model(&m);
}

/* One long step, or many of uneven length: the same result within tolerance; on ramps. */
static void check_step_pattern(void) {
    model once = new_model(2, 1, 0), often = new_model(2, 1, 0);
    sm_inputs ramps = resonant_inputs();
    ramps.frequency_rate[0] = 2e-4;
    ramps.force_rate[1] = -1e-3;
    ramps.phase_rate[0] = 1e-3;
    CHECK_STATUS(sm_component_set_inputs(once.component, &ramps), SM_OK);
    CHECK_STATUS(sm_component_set_inputs(often.component, &ramps), SM_OK);
    CHECK_STATUS(sm_component_step(once.component, 200.0), SM_OK);
    double left = 200.0, a[SM_OUTPUTS_FIXED], b[SM_OUTPUTS_FIXED];
    while (left > 0.0) {
        const double h = fmin(left, 5.0 * random_number());
        CHECK_STATUS(sm_component_step(often.component, h), SM_OK);
        left = h == left ? 0.0 : left - h;
    }
    CHECK_STATUS(sm_component_outputs(once.component, a), SM_OK);
    CHECK_STATUS(sm_component_outputs(often.component, b), SM_OK);
    CHECK(hypot(a[1], a[2]) > 0.5 && hypot(a[3], a[4]) > 0.1);
    for (int k = 0; k < SM_OUTPUTS_FIXED; k++) CHECK_NEAR(a[k], b[k], 1e-6);
    free_model(&once);
    free_model(&often);
}

/* At the steady state, energy = power times time and all that is put in is dissipated. */
static void check_energy(void) {
    model m = new_model(1, 1, 0);
    const sm_inputs inputs = resonant_inputs();
    double before[SM_OUTPUTS_FIXED], after[SM_OUTPUTS_FIXED];
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 5000.0), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, before), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 100.0), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, after), SM_OK);
    CHECK(before[8] > 1e-3);
    CHECK_NEAR((after[9] - before[9]) / (100.0 * before[8]), 1.0, 1e-6);
    const double damped = 2.0 * m.flow.damping[0] * pow(0.98 * hypot(after[1], after[2]), 2.0);
    CHECK_NEAR(after[7], after[8] + damped, 1e-7);
    CHECK(after[3] == 0.0 && after[4] == 0.0 && after[6] == 0.0); /* there is no mode B */
    free_model(&m);
}

/* What the modes respond at a signal, from the outputs. */
static double response_in(const model *m, const double *out, size_t signal) {
    double complex effective[2] = {0.0, 0.0}, phasor[2] = {1.0, 1.0};
    double sum = 0.0;
    for (int j = 0; j < m->flow.table.modes; j++) {
        effective[j] = out[1 + 2 * j] + I * out[2 + 2 * j];
        phasor[j] = cexp(I * out[5 + j]) * effective[j] / cabs(effective[j]);
    }
    for (int q = 0; q < ORDERS; q++) {
        const double a = cabs(effective[0]), b = cabs(effective[1]);
        const double complex c =
            response_at(a, b, q, 0, signal) + I * response_at(a, b, q, 1, signal);
        sum += creal(c * cpow(phasor[0], m->orders[2 * q]) * cpow(phasor[1], m->orders[2 * q + 1]));
    }
    return sum;
}

/* Contacts in equilibrium with the amplitudes and the modes' response at the communication point;
 * elastic outputs their linear combination. */
static void check_motion_outputs(int modes, int contacts) {
    model m = new_model(modes, contacts, 1);
    const sm_inputs inputs = resonant_inputs();
    double *out = new_doubles(m.outputs), largest = 0.0;
    CHECK(m.outputs == (size_t)(SM_OUTPUTS_FIXED + 3 * contacts + ELASTIC));
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < 40; k++) {
        CHECK_STATUS(sm_component_step(m.component, 0.3 + (k % 5) * 7.0), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
        const double *x = out + SM_OUTPUTS_FIXED, *v = x + contacts, *f = v + contacts;
        double complex q[2] = {0.0, 0.0};
        for (int j = 0; j < modes; j++)
            q[j] = 2.0 * (out[1 + 2 * j] + I * out[2 + 2 * j]) * cexp(I * out[5 + j]);
        for (int i = 0; i < contacts; i++) {
            double left = f[i] - response_in(&m, out, (size_t)i);
            for (int c = 0; c < contacts; c++)
                left += m.p.stiffness[i * contacts + c] * x[c]
                        + m.p.damping[i * contacts + c] * v[c];
            for (int j = 0; j < modes; j++) {
                const double *L = m.p.coupling + 2 * (j * contacts + i);
                left += 2.0 * creal((L[0] + I * L[1]) * (out[1 + 2 * j] + I * out[2 + 2 * j])
                                    * cexp(I * out[5 + j]));
            }
            CHECK_NEAR(left, 0.0, 1e-9);
            CHECK_NEAR(f[i], m.p.limit[i] * tanh(v[i] / 0.02), 1e-9);
            largest = fmax(largest, fabs(x[i]));
        }
        for (int e = 0; e < ELASTIC; e++) {
            double sum = response_in(&m, out, (size_t)e);
            for (int j = 0; j < modes; j++) {
                const double *shape = m.modes_out + 2 * (e * modes + j);
                sum += creal((shape[0] + I * shape[1]) * q[j]);
                const double *by_force = m.forces_out + 2 * (e * modes + j);
                const double complex force =
                    2.0 * inputs.force[j] * cexp(I * (out[5 + j] + inputs.phase[j]));
                sum += creal((by_force[0] + I * by_force[1]) * force);
            }
            for (int c = 0; c < contacts; c++) sum += m.contacts_out[e * contacts + c] * x[c];
            CHECK_NEAR(f[contacts + e], sum, 1e-13);
        }
    }
    CHECK(largest > 1e-3);
    free(out);
    free_model(&m);
}

/* Motion marched from rest is the motion of a component that has stepped so far, in steady state;
 * and leaves the state alone. */
static void check_recent_motion(int modes, int contacts) {
    model m = new_model(modes, contacts, 1);
    sm_inputs inputs = resonant_inputs();
    const size_t count = m.outputs - SM_OUTPUTS_FIXED;
    double *out = new_doubles(m.outputs), *motion = new_doubles(count);
    double *before = new_doubles(m.state), *after = new_doubles(m.state);
    const double rate[4] = {0.0};
    sm_component_free(m.component);
    m.motion.steps_per_period = 128; /* the grids differ where an internal step ends in between */
    CHECK_STATUS(sm_component_create(&m.flow, &m.p.contact, &m.motion, m.tolerance, &m.component),
                 SM_OK);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_step(m.component, 20000.0), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
    CHECK_STATUS(sm_component_get_state(m.component, before), SM_OK);
    memcpy(inputs.angle, out + 5, sizeof inputs.angle);
    CHECK_STATUS(sm_component_recent_motion(m.component, &inputs, out + 1, rate, 0, motion), SM_OK);
    CHECK_STATUS(sm_component_get_state(m.component, after), SM_OK);
    CHECK(memcmp(before, after, m.state * sizeof(double)) == 0);
    for (size_t k = 0; k < count; k++) CHECK_NEAR(motion[k], out[SM_OUTPUTS_FIXED + k], 1e-5);
    inputs.frequency_rate[0] = 10.0; /* faster than could be, so long ago */
    CHECK_STATUS(sm_component_recent_motion(m.component, &inputs, out + 1, rate, 0, motion), SM_OK);
    CHECK_FINITE(motion, count);
    free(out);
    free(motion);
    free(before);
    free(after);
    free_model(&m);
}

/* A state put into another component of the same model continues to the same bits. */
static void check_continuation(int modes, int wanted) {
    model m = new_model(modes, 2, wanted), twin = new_model(modes, 2, wanted);
    sm_inputs inputs = resonant_inputs();
    inputs.frequency_rate[0] = 1e-4;
    double *state = new_doubles(m.state), *a = new_doubles(m.outputs), *b = new_doubles(m.outputs);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < 7; k++) CHECK_STATUS(sm_component_step(m.component, 3.7), SM_OK);
    CHECK_STATUS(sm_component_get_state(m.component, state), SM_OK);
    CHECK_STATUS(sm_component_step(twin.component, 50.0), SM_OK); /* a past to be forgotten */
    CHECK_STATUS(sm_component_set_state(twin.component, state), SM_OK);
    for (int k = 0; k < 9; k++) {
        CHECK_STATUS(sm_component_outputs(m.component, a), SM_OK);
        CHECK_STATUS(sm_component_outputs(twin.component, b), SM_OK);
        CHECK(memcmp(a, b, m.outputs * sizeof(double)) == 0);
        CHECK_STATUS(sm_component_step(m.component, 0.9 * (k + 1)), SM_OK);
        CHECK_STATUS(sm_component_step(twin.component, 0.9 * (k + 1)), SM_OK);
    }
    free(state);
    free(a);
    free(b);
    free_model(&m);
    free_model(&twin);
}

/* With a combination resonance, so that the rate depends on the angles as well. */
static model new_combination_model(void) {
    model m = new_model(2, 1, 0);
    sm_component_free(m.component);
    free_table(&m.t);
    m.t = new_rich_table(4, 5, 1);
    m.flow = flow_over(&m.t);
    m.flow.combination[0] = (sm_combination){1, 5, -2};
    CHECK_STATUS(sm_component_create(&m.flow, &m.p.contact, &m.motion, m.tolerance, &m.component),
                 SM_OK);
    return m;
}

/* Whether the rate at the communication point is remembered from the step, or computed anew after
 * the same inputs or the same state are set, changes no bit. */
static void check_memory_of_the_rate(int ramps) {
    model m = new_combination_model(), twin = new_combination_model();
    sm_inputs inputs = resonant_inputs();
    double state[2048], a[SM_OUTPUTS_FIXED], b[SM_OUTPUTS_FIXED];
    inputs.frequency_rate[0] = ramps ? 1e-4 : 0.0;
    inputs.phase_rate[0] = ramps ? 0.01 : 0.0;
    CHECK(m.state <= 2048);
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_set_inputs(twin.component, &inputs), SM_OK);
    for (int k = 0; k < 50; k++) {
        const double duration = 0.1 + (k % 7) * 2.3;
        CHECK_STATUS(sm_component_step(m.component, duration), SM_OK);
        CHECK_STATUS(sm_component_step(twin.component, duration), SM_OK);
        CHECK_STATUS(sm_component_get_state(twin.component, state), SM_OK);
        CHECK_STATUS(sm_component_set_state(twin.component, state), SM_OK);
        if (!ramps) CHECK_STATUS(sm_component_set_inputs(twin.component, &inputs), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, a), SM_OK);
        CHECK_STATUS(sm_component_outputs(twin.component, b), SM_OK);
        CHECK(memcmp(a, b, sizeof a) == 0);
    }
    inputs.force[0] *= 2.0; /* other inputs, another rate */
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, b), SM_OK);
    CHECK(fabs(b[7] - a[7]) > 1e-3);
    free_model(&m);
    free_model(&twin);
}

/* Many steps in one call are the steps one by one; after a failure `done` tells how many were. */
static void check_run(int wanted) {
    enum { STEPS = 12 };
    model m = new_model(2, 2, wanted), twin = new_model(2, 2, wanted);
    double durations[STEPS], *out = new_doubles(STEPS * m.outputs), *one = new_doubles(m.outputs);
    sm_inputs inputs[STEPS];
    size_t done = 99;
    for (int k = 0; k < STEPS; k++) {
        durations[k] = 1.0 + k;
        inputs[k] = resonant_inputs();
        inputs[k].phase[0] = 0.1 * k;
    }
    durations[9] = -1.0;
    CHECK_STATUS(sm_component_run(m.component, STEPS, durations, inputs, out, &done),
                 SM_BAD_ARGUMENT);
    CHECK(done == 9);
    for (size_t k = 0; k < 9; k++) {
        CHECK_STATUS(sm_component_set_inputs(twin.component, &inputs[k]), SM_OK);
        CHECK_STATUS(sm_component_step(twin.component, durations[k]), SM_OK);
        CHECK_STATUS(sm_component_outputs(twin.component, one), SM_OK);
        CHECK(memcmp(one, out + k * m.outputs, m.outputs * sizeof(double)) == 0);
    }
    durations[9] = 1.0;
    CHECK_STATUS(sm_component_run(m.component, 3, durations + 9, inputs + 9, out, &done), SM_OK);
    CHECK(done == 3);
    free(out);
    free(one);
    free_model(&m);
    free_model(&twin);
}

/* Reset starts anew: the same run again, to the bit; the work goes on being counted. */
static void check_reset_and_work(void) {
    model m = new_model(2, 2, 1);
    const sm_inputs inputs = resonant_inputs();
    const double start[4] = {0.1, 0.2, 0.0, 0.3};
    double *out[2] = {new_doubles(m.outputs), new_doubles(m.outputs)};
    uint64_t accepted[2], rejected[2];
    for (int k = 0; k < 2; k++) {
        CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
        CHECK_STATUS(sm_component_reset(m.component, 5.0, start), SM_OK);
        CHECK_STATUS(sm_component_step(m.component, 60.0), SM_OK);
        CHECK_STATUS(sm_component_outputs(m.component, out[k]), SM_OK);
        sm_component_work(m.component, &accepted[k], &rejected[k]);
    }
    CHECK(memcmp(out[0], out[1], m.outputs * sizeof(double)) == 0);
    CHECK(accepted[0] > 0 && accepted[1] == 2 * accepted[0] && rejected[1] == 2 * rejected[0]);
    free(out[0]);
    free(out[1]);
    free_model(&m);
}

void check_component(void) {
    check_linear_response();
    check_step_pattern();
    check_energy();
    for (int modes = 1; modes <= 2; modes++) {
        check_motion_outputs(modes, 1);
        check_motion_outputs(modes, 3);
        check_recent_motion(modes, 2);
        check_continuation(modes, 0);
        check_continuation(modes, 1);
    }
    check_memory_of_the_rate(0);
    check_memory_of_the_rate(1);
    check_run(0);
    check_run(1);
    check_reset_and_work();
}

/* An angle less its whole turns, with 2 pi to twice the precision of a double. */
static double angle_of(double radians) {
    const double turns = floor(radians / TWO_PI), two_pi_low = 2.4492935982947064e-16;
    return fma(-turns, TWO_PI, radians) - turns * two_pi_low;
}

/* The angle after 1.1e7 periods in steps of 4096 s, each of 7168 rad exactly. A 2 pi in double
 * precision is off by 3e-9 rad after as many turns. */
static void check_many_turns(void) {
    model m = new_model(1, 1, 0);
    const sm_inputs inputs = {.frequency = {1.75, 0.0}, .limit_scale = 1.0};
    double out[SM_OUTPUTS_FIXED];
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < 10000; k++) CHECK_STATUS(sm_component_step(m.component, 4096.0), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
    CHECK_NEAR(out[5], angle_of(7.168e7), 1e-10);
    free_model(&m);
}

/* Steps of 0.1 s, up to a million: a plain sum of the time is off by 1e-7 to 1e-6 s. */
void check_long_run(int times) {
    const int steps = 250000 * times;
    model m = new_model(1, 1, 0);
    const sm_inputs inputs = {.frequency = {1.7, 0.0}, .limit_scale = 1.0};
    double out[SM_OUTPUTS_FIXED];
    CHECK_STATUS(sm_component_set_inputs(m.component, &inputs), SM_OK);
    for (int k = 0; k < steps; k++) CHECK_STATUS(sm_component_step(m.component, 0.1), SM_OK);
    CHECK_STATUS(sm_component_outputs(m.component, out), SM_OK);
    CHECK_NEAR(out[0], 0.1 * steps, 2e-11);
    CHECK_NEAR(out[5], angle_of(0.17 * steps), 1e-10); /* 0.1 times 1.7 is rounded every time */
    free_model(&m);
    check_many_turns();
}
