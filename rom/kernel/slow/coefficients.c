/* Coefficients of the amplitude equations (18), (19) at given inputs (docs/theory.md, "Amplitude
 * equations"). The slow flow (slow_flow.c) evaluates them in each stage of a time step. */
#include "slow/coefficients.h"

#include <math.h>
#include <string.h>

/* Consistent formulation, carrier at the forcing: q'' + gamma q' + omega^2 q is
 * (d/dt + mass) (d/dt - slow) a with root^2 = gamma^2 / 4 - omega^2 and
 *   mass = gamma / 2 + root + i Omega,  slow = -gamma / 2 + root - i Omega,
 *   stiffness = -mass slow = omega^2 - Omega^2 + i gamma Omega.
 * Paper, carrier at the natural frequency, to first order in the detuning:
 *   mass = 2 i omega,  stiffness = 2 omega (omega - Omega) + i gamma omega. */

/* Largest distance from the carrier of the table at which dS/dOmega is used, relative to the
 * carrier [-]; farther away S stays constant. The slope is measured 2 % from the carrier, and its
 * error 5 % from the carrier (rom/contact/detuning.py). */
#define LARGEST_DETUNING 0.05

double sm_detuning(const sm_slow_flow *flow, int j, double Omega) {
    const double most = LARGEST_DETUNING * flow->carrier[j];
    return fmax(-most, fmin(most, Omega - flow->carrier[j]));
}

double sm_natural_at(const sm_slow_flow *flow, int j, double Omega) {
    const double omega = flow->natural[j], carrier = flow->carrier[j], spin = flow->spin[j];
    return spin == 0.0 ? omega
                       : sqrt(omega * omega + spin * (Omega - carrier) * (Omega + carrier));
}

/* Computes the coefficients of mode j at the inputs, and their products. */
static void evaluate(sm_instant *instant, const sm_slow_flow *flow, int j, const sm_inputs *in) {
    const double Omega = in->frequency[j], gamma = flow->damping[j];
    const double omega = sm_natural_at(flow, j, Omega);
    sm_coefficients *now = &instant->now;
    instant->direction[j] = sm_unit(in->phase[j]);
    now->force[j] = sm_cscale(instant->direction[j], in->force[j]);
    now->coupling[j] = sm_coupling_at(flow, j, Omega);
    now->detuning[j] = sm_detuning(flow, j, Omega);
    if (flow->paper) {
        now->mass[j] = sm_cx(0.0, 2.0 * omega);
        now->stiffness[j] = sm_cx(2.0 * omega * (omega - Omega), gamma * omega);
    } else {
        const double half = 0.5 * gamma, square = (omega - half) * (omega + half);
        const double root = sqrt(fabs(square)); /* real beyond critical damping, else imaginary */
        now->mass[j] = square > 0.0 ? sm_cx(half, Omega + root) : sm_cx(half + root, Omega);
        now->stiffness[j] = sm_cx((omega - Omega) * (omega + Omega), gamma * Omega);
    }
    const sm_complex shifted = sm_cmul(sm_pair(flow->off_resonance[j]), now->force[j]);
    instant->ratio[j] = sm_cscale(now->coupling[j], 1.0 / in->limit_scale);
    instant->offset[j] = sm_cmul(instant->ratio[j], shifted);
    instant->gain[j] = sm_cscale(now->coupling[j], in->limit_scale);
    instant->per_mass[j] = sm_cdiv(sm_cx(1.0, 0.0), now->mass[j]);
    instant->spring[j] = sm_cmul(now->stiffness[j], instant->per_mass[j]);
}

/* Returns the change of the root in mass, root^2 = gamma^2 / 4 - omega^2, by a rise of omega^2. */
static sm_complex root_change(const sm_instant *instant, const sm_slow_flow *flow, int j,
                              double rise) {
    const sm_complex rest = sm_cx(0.5 * flow->damping[j], instant->inputs.frequency[j]);
    return sm_cdiv(sm_cx(-0.5 * rise, 0.0), sm_csub(instant->now.mass[j], rest));
}

void sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_inputs *change, sm_coefficients *d) {
    const sm_inputs *in = &instant->inputs;
    d->limit_scale = change->limit_scale;
    for (int j = 0; j < flow->table.modes; j++) {
        const double omega = flow->natural[j], Omega = in->frequency[j];
        const double dOmega = change->frequency[j];
        const double *c = flow->coupling_ratio[j][1];
        const sm_complex force = sm_cx(change->force[j], in->force[j] * change->phase[j]);
        const int limited = instant->now.detuning[j] != Omega - flow->carrier[j];
        d->force[j] = sm_cmul(instant->direction[j], force);
        d->coupling[j] = sm_cx(-dOmega * c[1], dOmega * c[0]);
        d->detuning[j] = limited ? 0.0 : dOmega;
        d->mass[j] = sm_cx(0.0, flow->paper ? 0.0 : dOmega);
        d->stiffness[j] = flow->paper ? sm_cx(-2.0 * omega * dOmega, 0.0)
                                      : sm_cx(-2.0 * Omega * dOmega, flow->damping[j] * dOmega);
        if (flow->spin[j] == 0.0) continue;
        const double rise = 2.0 * flow->spin[j] * Omega * dOmega; /* of omega^2 */
        d->mass[j] = sm_cadd(d->mass[j], root_change(instant, flow, j, rise));
        d->stiffness[j].re += rise;
    }
}

void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs) {
    const int same = instant->known
                     && memcmp(&instant->inputs, inputs, offsetof(sm_inputs, angle)) == 0;
    instant->inputs = *inputs;
    if (same) return;
    const double *in = (const double *)(const void *)inputs;
    sm_inputs rates = {.limit_scale = 0.0};
    double *rate = (double *)(void *)&rates;
    instant->known = instant->constant = 1;
    for (int k = 0; k < SM_INPUT_VALUES; k++) {
        rate[sm_value_place(k)] = in[sm_rate_place(k)];
        if (in[sm_rate_place(k)] != 0.0) instant->constant = 0;
    }
    instant->now.limit_scale = inputs->limit_scale;
    for (int j = 0; j < flow->table.modes; j++) evaluate(instant, flow, j, inputs);
    if (instant->constant) return;
    sm_coefficients_change(flow, instant, &rates, &instant->rate);
    for (int j = 0; j < flow->table.modes; j++) {
        if (flow->spin[j] == 0.0) continue;
        /* stiffness = d(root)/dt - mass slow: the amplitude of free vibration falls as omega rises */
        const sm_complex own = sm_cx(0.0, rates.frequency[j]);
        const sm_complex drift = sm_csub(instant->rate.mass[j], own);
        instant->now.stiffness[j] = sm_cadd(instant->now.stiffness[j], drift);
        instant->spring[j] = sm_cmul(instant->now.stiffness[j], instant->per_mass[j]);
    }
}

void sm_instant_advance(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs,
                        double elapsed) {
    const int modes = flow->table.modes;
    if (instant->constant) {
        for (int j = 0; j < modes; j++)
            instant->inputs.angle[j] = inputs->angle[j] + elapsed * inputs->frequency[j];
    } else {
        const sm_inputs now = sm_inputs_after(inputs, modes, elapsed);
        sm_instant_set(instant, flow, &now);
    }
}
