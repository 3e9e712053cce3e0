/* The slow flow: amplitude equations (18), (19) in the frame of the forcing (docs/theory.md,
 * "Amplitude equations" and "Rate correction"). Time steps (dopri5.c), entries.c and branches/ call
 * it. */
#include "slow/slow_flow.h"

#include <math.h>

#include "base/check.h"
#include "base/lanes.h"

/* With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   (d/dt + mass) (d/dt - slow) a = load = force / 2 + c s G(e),  e = c (a + shift force) / s,
 * with the coefficients of coefficients.c and the friction terms G of friction_model.c. To first
 * order in the rate of the load, (d/dt - slow) a = load / mass - (load / mass)' / mass, which is
 * integrated:
 *   mass a' + stiffness a = load - load' / mass + mass' load / mass^2 + lag.
 * The lag is the friction force less the friction force of steady motion. The paper neglects load',
 * mass' and the lag. The nonlinear stiffness sum_k h_jk |a_k|^2 of the mode acts as a load -h a. */

/* Returns x a + y b. */
SM_INLINE sm_complex scaled_sum(sm_complex a, double x, sm_complex b, double y) {
    return sm_cx(x * a.re + y * b.re, x * a.im + y * b.im);
}

/* Evaluates the equations without a''; `modes` is a literal, as in the functions below. */
SM_INLINE sm_status flow_at(const sm_slow_flow *flow, sm_instant *instant, int modes,
                            sm_friction_terms terms, const double *y, sm_flow_state *state) {
    sm_complex e[SM_MODES] = {{0.0, 0.0}};
    for (int j = 0; j < modes; j++) {
        state->amplitude[j] = sm_pair(y + 2 * j);
        e[j] = sm_cadd(sm_cmul(instant->ratio[j], state->amplitude[j]), instant->offset[j]);
    }
    SM_TRY(sm_friction_at(flow, instant, terms, e, &state->friction));
    for (int j = 0; j < modes; j++) {
        state->gain[j] = sm_cmul(instant->gain[j], state->friction.unit[j]);
        state->reaction[j] = sm_cmul(state->gain[j], state->friction.term[j]);
        state->hardening[j] = 0.0;
        for (int k = 0; k < modes; k++)
            state->hardening[j] += flow->hardening[j][k] * sm_cabs2(state->amplitude[k]);
        const sm_complex forced = scaled_sum(instant->now.force[j], 0.5, state->reaction[j], 1.0);
        const sm_complex load =
            scaled_sum(forced, 1.0, state->amplitude[j], -state->hardening[j]);
        state->follow[j] = sm_cmul(load, instant->per_mass[j]);
        state->rate[j] =
            sm_csub(state->follow[j], sm_cmul(instant->spring[j], state->amplitude[j]));
    }
    return SM_OK;
}

/* Returns a + shift force. */
SM_INLINE sm_complex shifted(const sm_slow_flow *flow, const sm_instant *instant,
                             const sm_flow_state *state, int j) {
    const sm_complex shift = sm_pair(flow->off_resonance[j]);
    return sm_cadd(state->amplitude[j], sm_cmul(shift, instant->now.force[j]));
}

/* Computes the changes of sm_flow_change. */
SM_INLINE void flow_change(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                           const sm_flow_state *state, const sm_complex *amplitude,
                           const sm_coefficients *d, sm_complex *load, sm_complex *w) {
    const sm_coefficients *now = &instant->now;
    const sm_friction *f = &state->friction;
    const double s = now->limit_scale, per_s = 1.0 / s;
    for (int k = 0; k < modes; k++) {
        const sm_complex back = sm_conj(f->unit[k]);
        w[k] = sm_cmul(sm_cmul(back, instant->ratio[k]), amplitude[k]);
        if (!d) continue;
        const sm_complex by_force = sm_cmul(sm_pair(flow->off_resonance[k]), d->force[k]);
        const sm_complex effective = shifted(flow, instant, state, k);
        const sm_complex by_inputs =
            sm_cadd(sm_cmul(d->coupling[k], effective), sm_cmul(now->coupling[k], by_force));
        w[k] = sm_cadd(w[k], sm_cscale(sm_cmul(back, by_inputs), per_s));
        w[k].re -= f->modulus[k] * d->limit_scale * per_s;
    }
    for (int j = 0; j < modes; j++) {
        sm_complex term = f->beat[j];
        for (int k = 0; k < modes; k++) {
            const sm_complex along = f->along[j][k], across = f->across[j][k];
            term.re += along.re * w[k].re + across.re * w[k].im;
            term.im += along.im * w[k].re + across.im * w[k].im;
            if (!d || !flow->table.detuning) continue;
            const double *by_frequency = f->by_frequency + 2 * (j * modes + k);
            term = sm_cadd(term, sm_cscale(sm_pair(by_frequency), d->detuning[k]));
        }
        double stiffened = 0.0;
        for (int k = 0; k < modes; k++)
            stiffened += 2.0 * flow->hardening[j][k]
                         * sm_cmul(sm_conj(state->amplitude[k]), amplitude[k]).re;
        const sm_complex elastic =
            scaled_sum(amplitude[j], state->hardening[j], state->amplitude[j], stiffened);
        load[j] = sm_csub(sm_cmul(state->gain[j], term), elastic);
        if (!d) continue;
        const sm_complex gain = scaled_sum(d->coupling[j], s, now->coupling[j], d->limit_scale);
        const sm_complex rescaled = sm_cmul(sm_cmul(gain, f->unit[j]), f->term[j]);
        load[j] = sm_cadd(load[j], scaled_sum(rescaled, 1.0, d->force[j], 0.5));
    }
}

SM_HOT_ONE sm_status sm_flow_at(const sm_slow_flow *flow, sm_instant *instant,
                                sm_friction_terms terms, const double *y, sm_flow_state *state) {
    return flow->table.modes == 1 ? flow_at(flow, instant, 1, terms, y, state)
                                  : flow_at(flow, instant, SM_MODES, terms, y, state);
}

void sm_flow_change(const sm_slow_flow *flow, const sm_instant *instant,
                    const sm_flow_state *state, const sm_complex *amplitude,
                    const sm_coefficients *d, sm_complex *load, sm_complex *w) {
    flow_change(flow, instant, flow->table.modes, state, amplitude, d, load, w);
}

void sm_flow_jacobian(const sm_slow_flow *flow, const sm_instant *instant,
                      const sm_flow_state *state, double *jacobian) {
    const sm_friction *f = &state->friction;
    const int modes = flow->table.modes, unknowns = 2 * modes;
    for (int j = 0; j < modes; j++) {
        const sm_complex gain = sm_cmul(state->gain[j], instant->per_mass[j]);
        double *re = jacobian + 2 * j * unknowns, *im = re + unknowns;
        for (int k = 0; k < modes; k++) {
            /* relative change of the effective amplitude by Re a; by Im a it is i w */
            const sm_complex w = sm_cmul(sm_conj(f->unit[k]), instant->ratio[k]);
            const sm_complex along = sm_cmul(gain, f->along[j][k]);
            const sm_complex across = sm_cmul(gain, f->across[j][k]);
            sm_complex own = sm_cx(0.0, 0.0);
            if (j == k)
                own = scaled_sum(instant->per_mass[j], state->hardening[j], instant->spring[j], 1.0);
            const sm_complex stiffened = sm_cscale(
                sm_cmul(instant->per_mass[j], state->amplitude[j]), 2.0 * flow->hardening[j][k]);
            const sm_complex a = state->amplitude[k];
            re[2 * k] = along.re * w.re + across.re * w.im - own.re - stiffened.re * a.re;
            im[2 * k] = along.im * w.re + across.im * w.im - own.im - stiffened.im * a.re;
            re[2 * k + 1] = across.re * w.re - along.re * w.im + own.im - stiffened.re * a.im;
            im[2 * k + 1] = across.im * w.re - along.im * w.im - own.re - stiffened.im * a.im;
        }
    }
}

/* Computes the lag of the friction forces while the effective amplitudes change by w per second:
 * their moduli grow, and the contacts move at Omega_k + d(arg e_k)/dt. */
SM_INLINE void find_lag(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                        const sm_flow_state *state, const sm_complex *w, sm_complex *lag) {
    const sm_friction *f = &state->friction;
    const sm_table *table = &flow->table;
    for (int j = 0; j < modes; j++) lag[j] = sm_cx(0.0, 0.0);
    if (!table->rate_correction && !table->detuning) return;
    for (int k = 0; k < modes; k++) {
        const int at_rest = f->modulus[k] == 0.0; /* the amplitude grows in the direction of w */
        const sm_complex growth = sm_cx(w[k].re, at_rest ? w[k].im : 0.0);
        double change = 0.0; /* of the detuning, by the rotation */
        if (table->detuning && !at_rest)
            change = sm_detuning(flow, k, instant->inputs.frequency[k] + w[k].im / f->modulus[k])
                     - instant->now.detuning[k];
        for (int j = 0; j < modes; j++) {
            const int at = 2 * (j * modes + k);
            if (table->rate_correction)
                lag[j] = sm_cadd(lag[j], sm_cmul(sm_pair(f->lag + at), growth));
            if (table->detuning)
                lag[j] = sm_cadd(lag[j], sm_cscale(sm_pair(f->by_frequency + at), change));
        }
    }
    for (int j = 0; j < modes; j++) lag[j] = sm_cmul(state->gain[j], lag[j]);
}

/* Returns the power from the forces to the contacts, without the power through the shift of the
 * amplitudes. The table has it for the forces g_j of steady states, g_j (1 + 2 shift D) =
 * 2 (D (a + shift force) - reaction) with the stiffness D. It is proportional to the force, so that
 * it is multiplied by sum |F| Re(conj(F) g) / sum |F| |g|^2, which is 1 in a steady state and 0
 * without a force. The factor is limited to 1, because g vanishes at some amplitudes. */
SM_INLINE double forces_power(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                              const sm_flow_state *state, const sm_complex *lag,
                              double tabulated) {
    double along = 0.0, steady = 0.0;
    for (int j = 0; j < modes; j++) {
        const sm_complex F = instant->now.force[j], linear = instant->now.stiffness[j];
        const sm_complex D = sm_cx(linear.re + state->hardening[j], linear.im);
        const sm_complex ratio = sm_cscale(sm_cmul(sm_pair(flow->off_resonance[j]), D), 2.0);
        const sm_complex reaction = sm_cadd(state->reaction[j], lag[j]);
        const sm_complex load = sm_csub(sm_cmul(D, shifted(flow, instant, state, j)), reaction);
        const sm_complex g = sm_cdiv(sm_cscale(load, 2.0), sm_cx(1.0 + ratio.re, ratio.im));
        const double size = sqrt(sm_cabs2(F));
        along += size * sm_cmul(sm_conj(F), g).re;
        steady += size * sm_cabs2(g);
    }
    if (fabs(along) >= steady) return along > 0.0 ? tabulated : along < 0.0 ? -tabulated : 0.0;
    return tabulated * along / steady;
}

/* Returns the mean of F cos(theta + phase) x' for the motion x of the loaded DOFs due to the mode,
 * the other modes and the contacts. By reciprocity, the reaction of the contacts moves the loaded
 * DOFs by shift * reaction. */
SM_INLINE double input_power(const sm_slow_flow *flow, const sm_instant *instant, int j,
                             sm_complex a, sm_complex reaction, sm_complex rate) {
    const sm_complex F = instant->now.force[j];
    const sm_complex by_contacts = sm_cmul(sm_pair(flow->off_resonance[j]), reaction);
    const sm_complex by_others = sm_cadd(sm_cmul(sm_pair(flow->other_modes[j][0]), F),
                                         sm_cmul(sm_pair(flow->other_modes[j][1]), a));
    const sm_complex x = sm_cadd(a, scaled_sum(by_contacts, 2.0, by_others, 1.0));
    const double Omega = instant->inputs.frequency[j];
    const sm_complex velocity = sm_cx(rate.re - Omega * x.im, rate.im + Omega * x.re);
    return sm_cmul(sm_conj(F), velocity).re;
}

/* Computes the derivative of the unknowns: the rates with a'' to first order, and the powers. */
SM_INLINE sm_status derivative(const sm_slow_flow *flow, sm_instant *instant, int modes,
                               const double *y, double *dy) {
    sm_flow_state state;
    sm_complex load[SM_MODES], w[SM_MODES], lag[SM_MODES] = {{0.0, 0.0}};
    SM_TRY(flow_at(flow, instant, modes, SM_ALL_TERMS, y, &state));
    for (int u = 2 * modes; u < SM_UNKNOWNS; u++) dy[u] = 0.0;
    if (!flow->paper) {
        const sm_coefficients *d = instant->constant ? NULL : &instant->rate;
        flow_change(flow, instant, modes, &state, state.rate, d, load, w);
        find_lag(flow, instant, modes, &state, w, lag);
    }
    for (int j = 0; j < modes; j++) {
        sm_complex rate = state.rate[j];
        if (!flow->paper) {
            if (!instant->constant)
                load[j] = sm_csub(load[j], sm_cmul(instant->rate.mass[j], state.follow[j]));
            const sm_complex delayed = sm_csub(lag[j], sm_cmul(load[j], instant->per_mass[j]));
            rate = sm_cadd(rate, sm_cmul(delayed, instant->per_mass[j]));
        }
        const sm_complex reaction = sm_cadd(state.reaction[j], lag[j]);
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
        dy[SM_PUT_IN] += input_power(flow, instant, j, state.amplitude[j], reaction, rate);
        /* mean power from the modes, and from the forces through the shift, to the contacts */
        const sm_complex effective = shifted(flow, instant, &state, j);
        const double Omega = instant->inputs.frequency[j];
        dy[SM_DISSIPATED] -= 2.0 * Omega * sm_cmul(sm_conj(effective), reaction).im;
    }
    if (flow->table.power) {
        const double square = instant->now.limit_scale * instant->now.limit_scale;
        const double *tabulated = state.friction.power;
        const double by_forces =
            forces_power(flow, instant, modes, &state, lag, square * tabulated[1]);
        dy[SM_PUT_IN] += by_forces;
        dy[SM_DISSIPATED] = fmax(dy[SM_DISSIPATED] + square * tabulated[0] + by_forces, 0.0);
    }
    return SM_OK;
}

SM_HOT_ONE sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, sm_instant *instant,
                                             const double *y, double *dy) {
    return flow->table.modes == 1 ? derivative(flow, instant, 1, y, dy)
                                  : derivative(flow, instant, SM_MODES, y, dy);
}
