#include "slow/instant.h"

#include <string.h>

#include "base/check.h"

sm_status sm_inputs_check(const sm_inputs *inputs, int modes) {
    for (int j = 0; j < modes; j++) {
        const double values[] = {inputs->force[j], inputs->force_rate[j],
                                 inputs->frequency_rate[j], inputs->phase[j],
                                 inputs->phase_rate[j], inputs->angle[j]};
        if (!sm_all_finite(values, sizeof values / sizeof *values)) return SM_NOT_FINITE;
        const sm_status status = sm_check_positive(inputs->frequency[j]);
        if (status != SM_OK) return status;
    }
    if (!isfinite(inputs->limit_scale_rate)) return SM_NOT_FINITE;
    return sm_check_positive(inputs->limit_scale);
}

static double angle_after(const sm_inputs *inputs, int j, double elapsed) {
    const double half_rate = 0.5 * inputs->frequency_rate[j];
    return inputs->angle[j] + elapsed * (inputs->frequency[j] + half_rate * elapsed);
}

sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed) {
    sm_inputs after = {.limit_scale = inputs->limit_scale + inputs->limit_scale_rate * elapsed,
                       .limit_scale_rate = inputs->limit_scale_rate};
    for (int j = 0; j < modes; j++) {
        after.force[j] = inputs->force[j] + inputs->force_rate[j] * elapsed;
        after.force_rate[j] = inputs->force_rate[j];
        after.frequency[j] = inputs->frequency[j] + inputs->frequency_rate[j] * elapsed;
        after.frequency_rate[j] = inputs->frequency_rate[j];
        after.phase[j] = inputs->phase[j] + inputs->phase_rate[j] * elapsed;
        after.phase_rate[j] = inputs->phase_rate[j];
        after.angle[j] = angle_after(inputs, j, elapsed);
    }
    return after;
}

double sm_detuning(const sm_slow_flow *flow, int j, double Omega) {
    /* farther from the carrier dS/dOmega is no guide, and S stays as it is there */
    const double most = 0.05 * flow->carrier[j];
    return fmax(-most, fmin(most, Omega - flow->carrier[j]));
}

/* Carrier at the forcing (consistent formulation): in its frame q'' + damping q' + omega^2 q is
 * (d/dt + mass) (d/dt - slow) a, where slow = -damping / 2 + root - i Omega decays as the mode does
 * by itself, root^2 = damping^2 / 4 - omega^2, and
 *   mass = damping / 2 + root + i Omega,  stiffness = -mass slow = omega^2 - Omega^2 + i damping Omega;
 * carrier at the natural frequency, detuning to first order (the paper's):
 *   mass = 2 i omega,                     stiffness = 2 omega (omega - Omega) + i damping omega. */
static void set_now(sm_instant *instant, const sm_slow_flow *flow, int j, const sm_inputs *in) {
    const double omega = flow->natural[j], Omega = in->frequency[j], damping = flow->damping[j];
    const sm_complex c0 = sm_pair(flow->coupling_ratio[j][0]),
                     c1 = sm_pair(flow->coupling_ratio[j][1]);
    sm_coefficients *now = &instant->now;
    sm_put(&now->excitation, j, sm_cscale(sm_of(&instant->direction, j), in->force[j]));
    sm_put(&now->coupling_ratio, j, sm_cx(1.0 + c0.re - Omega * c1.im, c0.im + Omega * c1.re));
    now->detuning[j] = sm_detuning(flow, j, Omega);
    if (flow->paper) {
        sm_put(&now->mass, j, sm_cx(0.0, 2.0 * omega));
        sm_put(&now->stiffness, j, sm_cx(2.0 * omega * (omega - Omega), damping * omega));
    } else {
        const double half = 0.5 * damping, square = (omega - half) * (omega + half);
        const double root = sqrt(fabs(square)); /* no vibration beyond critical damping */
        sm_put(&now->mass, j,
               square > 0.0 ? sm_cx(half, Omega + root) : sm_cx(half + root, Omega));
        sm_put(&now->stiffness, j, sm_cx((omega - Omega) * (omega + Omega), damping * Omega));
    }
}

void sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_inputs *change, sm_coefficients *d) {
    const sm_inputs *in = &instant->inputs;
    for (int j = 0; j < flow->table.modes; j++) {
        const double omega = flow->natural[j], dOmega = change->frequency[j];
        const sm_complex c1 = sm_pair(flow->coupling_ratio[j][1]);
        const sm_complex force = sm_cx(change->force[j], in->force[j] * change->phase[j]);
        sm_put(&d->excitation, j, sm_cmul(sm_of(&instant->direction, j), force));
        sm_put(&d->coupling_ratio, j, sm_cx(-dOmega * c1.im, dOmega * c1.re));
        const int beyond = instant->now.detuning[j] != in->frequency[j] - flow->carrier[j];
        d->detuning[j] = beyond ? 0.0 : dOmega;
        if (flow->paper) {
            sm_put(&d->mass, j, sm_cx(0.0, 0.0));
            sm_put(&d->stiffness, j, sm_cx(-2.0 * omega * dOmega, 0.0));
        } else {
            sm_put(&d->mass, j, sm_cx(0.0, dOmega));
            sm_put(&d->stiffness, j,
                   sm_cx(-2.0 * in->frequency[j] * dOmega, flow->damping[j] * dOmega));
        }
    }
}

double sm_combination_angle(const sm_combination *combination, const double *theta) {
    return combination->n * theta[0] + combination->m * theta[1] - theta[combination->mode];
}

/* d/dt of the inputs, as inputs. */
static sm_inputs rates_of(const sm_inputs *in) {
    sm_inputs d = {.limit_scale = in->limit_scale_rate};
    for (int j = 0; j < SM_MODES; j++) {
        d.force[j] = in->force_rate[j];
        d.frequency[j] = in->frequency_rate[j];
        d.phase[j] = in->phase_rate[j];
        d.angle[j] = in->frequency[j];
    }
    return d;
}

static void set_factors(sm_instant *instant, const sm_slow_flow *flow, int j) {
    const sm_coefficients *now = &instant->now;
    sm_factors *by = &instant->factor;
    const sm_complex per_mass = sm_of(&instant->per_mass, j),
                     ratio = sm_of(&now->coupling_ratio, j);
    const sm_complex excitation = sm_of(&now->excitation, j);
    const sm_complex force_ratio = sm_cscale(ratio, instant->inputs.limit_scale);
    const sm_complex amplitude_ratio = sm_cscale(ratio, instant->per_scale);
    sm_put(&by->amplitude_ratio, j, amplitude_ratio);
    sm_put(&by->off_resonance, j,
           sm_cmul(amplitude_ratio, sm_cmul(sm_pair(flow->off_resonance[j]), excitation)));
    sm_put(&by->force_ratio, j, force_ratio);
    sm_put(&by->forcing, j, sm_cmul(sm_cscale(excitation, 0.5), per_mass));
    sm_put(&by->spring, j, sm_cmul(sm_of(&now->stiffness, j), per_mass));
    sm_put(&by->rate_ratio, j, sm_cmul(force_ratio, per_mass));
}

static int is_held(const sm_inputs *in) {
    int moving = in->limit_scale_rate != 0.0;
    for (int j = 0; j < SM_MODES; j++)
        moving |= in->force_rate[j] != 0.0 || in->frequency_rate[j] != 0.0
                  || in->phase_rate[j] != 0.0;
    return !moving;
}

/* 1 where the angles of two combination resonances are equal whatever the thetas, -1 where
 * opposite. */
static int relation(const sm_combination *a, const sm_combination *b) {
    const int32_t n_a = a->n - (a->mode == 0), m_a = a->m - (a->mode == 1);
    const int32_t n_b = b->n - (b->mode == 0), m_b = b->m - (b->mode == 1);
    if (n_a == n_b && m_a == m_b) return 1;
    return n_a == -n_b && m_a == -m_b ? -1 : 0;
}

static void set_coefficients(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *in) {
    for (int j = 0; j < flow->table.modes; j++) {
        if (!instant->known || instant->inputs.phase[j] != in->phase[j])
            sm_put(&instant->direction, j, sm_unit(in->phase[j]));
        set_now(instant, flow, j, in);
        sm_put(&instant->per_mass, j, sm_cdiv(sm_cx(1.0, 0.0), sm_of(&instant->now.mass, j)));
    }
    instant->per_scale = 1.0 / in->limit_scale;
    instant->inputs = *in;
    instant->held = is_held(in);
    if (instant->held) {
        instant->rate = (sm_coefficients){.detuning = {0.0}};
    } else {
        const sm_inputs rates = rates_of(in);
        sm_coefficients_change(flow, instant, &rates, &instant->rate);
    }
    for (int j = 0; j < flow->table.modes; j++) set_factors(instant, flow, j);
    for (int k = 0; k < flow->table.combinations; k++) {
        instant->combination_rate[k] = sm_combination_angle(&flow->combination[k], in->frequency);
        instant->like_first[k] = k > 0 ? relation(&flow->combination[k], &flow->combination[0]) : 0;
        instant->combination_order[k][0] = flow->combination[k].n;
        instant->combination_order[k][1] = flow->combination[k].m;
        for (int j = 0; j < SM_MODES; j++)
            instant->combination_on[k][j] = flow->combination[k].mode == j;
    }
}

/* p theta_A close to q theta_B makes combination resonances of both modes, often of opposite
 * angles. */
static void set_combination_waves(sm_instant *instant, const sm_slow_flow *flow,
                                  const double *theta) {
    for (int k = 0; k < flow->table.combinations; k++) {
        const sm_complex first = instant->combination_wave[0];
        if (instant->like_first[k]) {
            instant->combination_wave[k] = instant->like_first[k] > 0 ? first : sm_conj(first);
            continue;
        }
        instant->combination_wave[k] = sm_unit(sm_combination_angle(&flow->combination[k], theta));
    }
}

static int same_but_angles(const sm_instant *instant, const sm_inputs *inputs) {
    return instant->known && memcmp(&instant->inputs, inputs, offsetof(sm_inputs, angle)) == 0;
}

void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs) {
    const size_t angles = sizeof inputs->angle;
    const int same = same_but_angles(instant, inputs);
    const int here = instant->known && memcmp(instant->inputs.angle, inputs->angle, angles) == 0;
    if (!same) set_coefficients(instant, flow, inputs);
    if (!here) set_combination_waves(instant, flow, inputs->angle);
    instant->inputs = *inputs;
    instant->known = 1;
}

int sm_instant_holds(const sm_instant *instant, const sm_inputs *inputs) {
    return instant->held && same_but_angles(instant, inputs);
}

void sm_instant_advance(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs,
                        double elapsed) {
    for (int j = 0; j < flow->table.modes; j++)
        instant->inputs.angle[j] = angle_after(inputs, j, elapsed);
    set_combination_waves(instant, flow, instant->inputs.angle);
}
