/* The slow flow: its right-hand side and its integration step. */
#include "slow/slow_flow.h"

#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

/* All arguments of sm_slow_flow_rate, on ramps of every input. */
typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs;
    double elapsed, amplitude[4], rate[4], powers[2];
} rate_call;

static rate_call new_call(int modes, int paper) {
    rate_call c = {.t = new_table(modes, 2, 2),
                   .inputs = {.force = {0.15, 0.25},
                              .force_rate = {0.01, -0.02},
                              .frequency = {0.98, 1.65},
                              .frequency_rate = {1e-3, -2e-3},
                              .phase = {0.3, -1.2},
                              .phase_rate = {0.02, 0.01},
                              .limit_scale = 1.2,
                              .limit_scale_rate = 0.01},
                   .elapsed = 2.5,
                   .amplitude = {0.9, -0.7, -0.4, 1.1}};
    c.flow = flow_over(&c.t);
    c.flow.paper = paper;
    return c;
}

static sm_status evaluate(void *arguments) {
    rate_call *c = arguments;
    return sm_slow_flow_rate(&c->flow, &c->inputs, c->elapsed, c->amplitude, c->rate,
                             c->powers);
}

static double complex mass_of(const rate_call *c, int j, double t) {
    const double Omega = c->inputs.frequency[j] + t * c->inputs.frequency_rate[j];
    const double natural = c->flow.natural[j], half = 0.5 * c->flow.damping[j];
    if (c->flow.paper) return 2.0 * I * natural;
    return half + I * (sqrt(natural * natural - half * half) + Omega);
}

/* Of the amplitude by itself: in the consistent formulation as the mode vibrates. */
static double complex slow_root(const rate_call *c, int j, double t) {
    const double Omega = c->inputs.frequency[j] + t * c->inputs.frequency_rate[j];
    const double natural = c->flow.natural[j], half = 0.5 * c->flow.damping[j];
    if (c->flow.paper) return -half + I * (natural - Omega);
    return -half + I * (sqrt(natural * natural - half * half) - Omega);
}

/* (F exp(i ph) / 2 + Q a) / mass, at the amplitudes of both modes. */
static void driven(const rate_call *c, double t, const double complex *a,
                        double complex *u) {
    const int modes = c->flow.table.modes;
    const double scale = c->inputs.limit_scale + t * c->inputs.limit_scale_rate;
    double s[4];
    exact_friction(modes, cabs(a[0]) / scale, modes == 2 ? cabs(a[1]) / scale : 0.0, s);
    for (int j = 0; j < modes; j++) {
        const double F = c->inputs.force[j] + t * c->inputs.force_rate[j];
        const double phase = c->inputs.phase[j] + t * c->inputs.phase_rate[j];
        const double complex Q = scale * (s[2 * j] + I * s[2 * j + 1]) / cabs(a[j]);
        u[j] = (0.5 * F * cexp(I * phase) + Q * a[j]) / mass_of(c, j, t);
    }
}

/* The rate is v = slow a + u in the paper's formulation, v - u' / mass in the consistent one, with
 * (d/dt + mass) (d/dt - slow) a = mass u. */
static void check_equation(int modes, int paper) {
    rate_call c = new_call(modes, paper);
    const double t = c.elapsed, step = 1e-5;
    const double scale = c.inputs.limit_scale + t * c.inputs.limit_scale_rate;
    double s[4], power = 0.0;
    double complex a[2], u[2], v[2], after[2], before[2], a_after[2], a_before[2];
    CHECK_STATUS(evaluate(&c), SM_OK);
    for (int j = 0; j < 2; j++) a[j] = c.amplitude[2 * j] + I * c.amplitude[2 * j + 1];
    driven(&c, t, a, u);
    for (int j = 0; j < modes; j++) {
        v[j] = slow_root(&c, j, t) * a[j] + u[j];
        a_after[j] = a[j] + step * v[j];
        a_before[j] = a[j] - step * v[j];
    }
    driven(&c, t + step, a_after, after);
    driven(&c, t - step, a_before, before);
    exact_friction(modes, cabs(a[0]) / scale, modes == 2 ? cabs(a[1]) / scale : 0.0, s);
    for (int j = 0; j < modes; j++) {
        const double complex rate = c.rate[2 * j] + I * c.rate[2 * j + 1];
        const double complex curved = (after[j] - before[j]) / (2.0 * step) / mass_of(&c, j, t);
        CHECK_NEAR(cabs(rate - (paper ? v[j] : v[j] - curved)), 0.0, paper ? 1e-14 : 1e-10);
        CHECK(paper || cabs(curved) > 1e-4);
        power -= 2.0 * (c.inputs.frequency[j] + t * c.inputs.frequency_rate[j]) * cabs(a[j])
                 * scale * s[2 * j + 1];
    }
    CHECK_NEAR(c.powers[1], power, 1e-14);
    free_table(&c.t);
}

/* From rest the rate is the one just after: the effective amplitude has a direction only then. */
static void check_rest(void) {
    rate_call c = new_call(2, 0);
    double at_rest[4];
    c.elapsed = 0.0;
    memset(c.amplitude, 0, sizeof c.amplitude);
    CHECK_STATUS(evaluate(&c), SM_OK);
    memcpy(at_rest, c.rate, sizeof at_rest);
    c.elapsed = 1e-6;
    for (int k = 0; k < 4; k++) c.amplitude[k] = c.elapsed * at_rest[k];
    CHECK_STATUS(evaluate(&c), SM_OK);
    for (int k = 0; k < 4; k++) CHECK_NEAR(c.rate[k], at_rest[k], 1e-7);
    c.elapsed = 1e-3; /* where the direction is that of the amplitude itself */
    for (int k = 0; k < 4; k++) c.amplitude[k] = c.elapsed * at_rest[k];
    CHECK_STATUS(evaluate(&c), SM_OK);
    for (int k = 0; k < 4; k++) CHECK_NEAR(c.rate[k], at_rest[k], 1e-4);
    free_table(&c.t);
}

/* Force that holds the amplitudes still: what it puts in goes into friction and damping. */
static void check_power_balance(void) {
    rate_call c = new_call(2, 0);
    double s[4], damped = 0.0;
    exact_friction(2, hypot(0.9, 0.7), hypot(0.4, 1.1), s);
    c.elapsed = 0.0;
    c.inputs.limit_scale = 1.0;
    c.inputs.limit_scale_rate = 0.0;
    for (int j = 0; j < 2; j++) {
        const double complex a = c.amplitude[2 * j] + I * c.amplitude[2 * j + 1];
        const double natural = c.flow.natural[j], Omega = c.inputs.frequency[j];
        c.inputs.frequency_rate[j] = c.inputs.force_rate[j] = c.inputs.phase_rate[j] = 0.0;
        const double complex F =
            2.0 * (natural * natural - Omega * Omega + I * c.flow.damping[j] * Omega
                   - (s[2 * j] + I * s[2 * j + 1]) / cabs(a)) * a;
        c.inputs.force[j] = cabs(F);
        c.inputs.phase[j] = carg(F);
        damped += 2.0 * c.flow.damping[j] * pow(Omega * cabs(a), 2.0);
    }
    CHECK_STATUS(evaluate(&c), SM_OK);
    for (int k = 0; k < 4; k++) CHECK_NEAR(c.rate[k], 0.0, 1e-15);
    CHECK(c.powers[1] > 0.1);
    CHECK_NEAR(c.powers[0], c.powers[1] + damped, 1e-14);
    free_table(&c.t);
}

/* Unknowns after `steps` equal steps over 24 s of ramps, away from resonance. */
static void integrate(const rate_call *c, int steps, double *y) {
    double dy[SM_UNKNOWNS], y_new[SM_UNKNOWNS], dy_new[SM_UNKNOWNS], error;
    const double h = 24.0 / steps;
    sm_instant instant = {.known = 0};
    memset(y, 0, SM_UNKNOWNS * sizeof *y);
    memcpy(y, c->amplitude, 2 * (size_t)c->flow.table.modes * sizeof *y);
    CHECK_STATUS(sm_slow_flow_derivative(&c->flow, &c->inputs, &instant, y, dy), SM_OK);
    for (int k = 0; k < steps; k++) {
        const sm_inputs end = sm_inputs_after(&c->inputs, c->flow.table.modes, h * (k + 1));
        CHECK_STATUS(sm_slow_flow_dopri5(&c->flow, &c->inputs, h * k, h, &end, 1e-6, &instant, y,
                                         dy, y_new, dy_new, &error),
                     SM_OK);
        memcpy(y, y_new, sizeof y_new);
        memcpy(dy, dy_new, sizeof dy_new);
    }
}

static void check_order(int modes, int paper) {
    rate_call c = new_call(modes, paper);
    c.inputs.frequency[0] = 0.7;
    c.inputs.frequency[1] = 1.3;
    double exact[SM_UNKNOWNS], error[3] = {0.0, 0.0, 0.0};
    integrate(&c, 4096, exact);
    for (int k = 0; k < 3; k++) {
        double y[SM_UNKNOWNS];
        integrate(&c, 96 << k, y);
        for (int u = 0; u < SM_UNKNOWNS; u++) error[k] = fmax(error[k], fabs(y[u] - exact[u]));
    }
    CHECK_NEAR(log2(error[0] / error[1]), 5.0, 0.3);
    CHECK_NEAR(log2(error[1] / error[2]), 5.0, 0.3);
    free_table(&c.t);
}

/* Halving the step divides the estimate, which is of fourth order, by 32. The derivative at the
 * end is to the bit that of whoever comes there anew. */
static void check_error_estimate(void) {
    rate_call c = new_call(2, 0);
    double y[SM_UNKNOWNS] = {0.9, -0.7, -0.4, 1.1}, dy[SM_UNKNOWNS], y_new[SM_UNKNOWNS];
    double dy_new[SM_UNKNOWNS], check[SM_UNKNOWNS], error[2];
    sm_instant instant = {.known = 0}, anew = {.known = 0};
    sm_inputs end;
    CHECK_STATUS(sm_slow_flow_derivative(&c.flow, &c.inputs, &instant, y, dy), SM_OK);
    for (int k = 0; k < 2; k++) {
        const double h = k == 0 ? 0.4 : 0.2;
        end = sm_inputs_after(&c.inputs, 2, h);
        CHECK_STATUS(sm_slow_flow_dopri5(&c.flow, &c.inputs, 0.0, h, &end, 1e-9, &instant, y, dy,
                                      y_new, dy_new, &error[k]),
                     SM_OK);
    }
    CHECK_NEAR(log2(error[0] / error[1]), 5.0, 0.2);
    CHECK_STATUS(sm_slow_flow_derivative(&c.flow, &end, &anew, y_new, check), SM_OK);
    CHECK(memcmp(check, dy_new, sizeof check) == 0);
    free_table(&c.t);
}

/* With limits, forces and amplitudes s times as large, so are the rates; the powers s^2 times. */
static void check_homogeneity(double s) {
    rate_call c = new_call(2, 0), scaled = new_call(2, 0);
    rate_call *const both[] = {&c, &scaled};
    for (int k = 0; k < 2; k++) {
        free_table(&both[k]->t);
        both[k]->t = new_rich_table(4, 5, 1);
        both[k]->flow = flow_over(&both[k]->t);
        both[k]->flow.combination[0] = (sm_combination){1, 5, -2};
        both[k]->flow.off_resonance[1][0] = 0.3;
    }
    c.inputs.limit_scale = 1.0;
    scaled.inputs.limit_scale = s;
    c.inputs.limit_scale_rate = scaled.inputs.limit_scale_rate = 0.0;
    for (int j = 0; j < 2; j++) {
        scaled.inputs.force[j] *= s;
        scaled.inputs.force_rate[j] *= s;
    }
    for (int k = 0; k < 4; k++) scaled.amplitude[k] *= s;
    CHECK_STATUS(evaluate(&c), SM_OK);
    CHECK_STATUS(evaluate(&scaled), SM_OK);
    for (int k = 0; k < 4; k++) CHECK_NEAR(scaled.rate[k] / s, c.rate[k], 1e-14);
    CHECK_NEAR(scaled.powers[1] / (s * s), c.powers[1], 1e-14);
    CHECK_NEAR(scaled.powers[0] / (s * s), c.powers[0], 1e-14);
    free_table(&c.t);
    free_table(&scaled.t);
}

static void check_combination_refusals(void) {
    rate_call c = new_call(2, 0);
    const int32_t wrong[] = {INT32_MIN, -1001, 1001, INT32_MAX};
    sm_combination *const combination = &c.flow.combination[0];
    c.flow.table.combinations = 1;
    for (int k = 0; k < 4; k++) {
        CHECK_REFUSES(int32_t, combination->mode, wrong[k], evaluate(&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, combination->n, wrong[k], evaluate(&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, combination->m, wrong[k], evaluate(&c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c.flow.table.combinations, wrong[k], evaluate(&c), SM_BAD_ARGUMENT);
    }
    c.flow.table.combinations = 0;
    for (int j = 0; j < 2; j++) {
        CHECK_REFUSES_NOT_FINITE((double *)&c.flow.coupling_ratio[j],
                                 sizeof c.flow.coupling_ratio[j] / sizeof(double), evaluate, &c);
        CHECK_REFUSES_NOT_FINITE(c.flow.off_resonance[j], 2, evaluate, &c);
    }
    free_table(&c.t);
}

static void check_refusals(void) {
    rate_call c = new_call(2, 0);
    double *const a = c.amplitude, *const r = c.rate, *const p = c.powers;
    CHECK_STATUS(sm_slow_flow_rate(NULL, &c.inputs, 0.0, a, r, p), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_rate(&c.flow, NULL, 0.0, a, r, p), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_rate(&c.flow, &c.inputs, 0.0, NULL, r, p), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_rate(&c.flow, &c.inputs, 0.0, a, NULL, p), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_slow_flow_rate(&c.flow, &c.inputs, 0.0, a, r, NULL), SM_BAD_ARGUMENT);
    const int32_t wrong[] = {0, -1, 3, INT32_MIN, INT32_MAX};
    for (int k = 0; k < 5; k++)
        CHECK_REFUSES(int32_t, c.flow.table.modes, wrong[k], evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.inputs.frequency[1], 0.0, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.inputs.frequency_rate[0], -1.0, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.inputs.limit_scale, -1.0, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.inputs.limit_scale_rate, -1.0, evaluate(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.amplitude[2], 5.2, evaluate(&c), SM_OUTSIDE_TABLE);
    CHECK_REFUSES(double, c.inputs.force[0], 1e308, evaluate(&c), SM_NOT_FINITE);
    CHECK_REFUSES_NOT_FINITE((double *)&c.inputs, INPUT_COUNT, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE(c.amplitude, 4, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE(&c.elapsed, 1, evaluate, &c);
    CHECK_REFUSES_NOT_FINITE(c.flow.natural, 2, evaluate, &c);
    CHECK_STATUS(evaluate(&c), SM_OK);
    free_table(&c.t);
}

void check_slow_flow(void) {
    for (int modes = 1; modes <= 2; modes++)
        for (int paper = 0; paper <= 1; paper++) {
            check_equation(modes, paper);
            check_order(modes, paper);
        }
    check_rest();
    check_power_balance();
    check_homogeneity(1e-3);
    check_homogeneity(7.0);
    check_error_estimate();
    check_combination_refusals();
    check_refusals();
}
