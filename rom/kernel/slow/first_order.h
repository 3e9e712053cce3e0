/* The amplitude equations without a'', and how the rates that they give change. */
#ifndef SLIPMODE_FIRST_ORDER_H
#define SLIPMODE_FIRST_ORDER_H

#include "slow/instant.h"

/* The effective amplitudes, which the contacts see of the modes; a mode that is not there is 0. */
typedef struct {
    sm_modal amplitude;           /* a_j */
    sm_modal unit;                /* direction of the effective amplitude; 1 at rest */
    double modulus[SM_MODES];     /* of it, relative to the scale of the limits */
    double per_modulus[SM_MODES]; /* 1 / modulus; 0 at rest */
} sm_effective;

/* And how they react. */
typedef struct {
    sm_effective effective;
    sm_modal
        reaction;   /* of the contacts, as tabulated: S_j unit_j and the combination resonances */
    sm_modal force; /* rotated and scaled: on the mode */
    sm_modal rate;  /* of the amplitude */
    sm_complex combination_phasor[SM_COMBINATIONS]; /* exp(i (n t_A + m t_B - t_j)), t_j = theta_j +
                                                       arg a_j */
    double slopes[3 * SM_MOST_FIELDS]; /* of the table: values, d/da, d/db */
    double rate_correction[SM_RATE_CORRECTIONS];
    double detuning[3 * SM_RATE_CORRECTIONS]; /* dS_j / dOmega_k, d/da, d/db, if the table has it */
} sm_flow_state;

/* A direction in amplitudes and inputs. */
typedef struct {
    const sm_modal *amplitude;
    const sm_coefficients *now;
    const double *combination_angle; /* (combinations) */
    double limit_scale;
} sm_direction;

/* What changes along it. */
typedef struct {
    sm_modal rate, force;
    sm_modal rate_correction; /* along the flow: the force of friction less that in steady motion */
} sm_flow_change;

/* At amplitudes y (2 modes) and the inputs that `instant` is set to. */
void sm_effective_at(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
                     sm_effective *effective);

/* At amplitudes y (2 modes) and the inputs that `instant` is set to. How it changes along a direction
 * takes slopes of the table, which are looked up if they are `sloped`. */
sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, int sloped,
                         const double *y, sm_flow_state *state);

void sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                           const sm_flow_state *state, const sm_direction *along,
                           sm_flow_change *change);

/* Combination resonances: harmonics (n, m) of the contacts that drive a mode close to its carrier. */

/* exp(i (n t_A + m t_B - t_j)), t_j = theta_j + arg a_j: phase of a combination resonance against
 * its mode. */
SM_INLINE sm_complex sm_combination_phasor(const sm_combination *combination, sm_complex wave,
                                           const sm_modal *unit) {
    const sm_complex by_a =
        sm_unit_power(sm_of(unit, 0), combination->n - (combination->mode == 0));
    const sm_complex by_b =
        sm_unit_power(sm_of(unit, 1), combination->m - (combination->mode == 1));
    return sm_cmul(sm_cmul(wave, by_b), by_a);
}

/* Those of all combination resonances, many of them equal or opposite to the first; 0 for harmonics
 * of an amplitude that is. */
SM_INLINE void sm_combination_phasors(const sm_slow_flow *flow, const sm_instant *instant,
                             const sm_modal *unit, const double *modulus, sm_complex *phasor) {
    const sm_combination *combination = flow->combination;
    for (int k = 0; k < flow->table.combinations; k++) {
        const int like_first = instant->like_first[k];
        phasor[k] =
            like_first ? sm_cx(phasor[0].re, like_first * phasor[0].im)
                       : sm_combination_phasor(&combination[k], instant->combination_wave[k], unit);
    }
    if (modulus[0] * modulus[1] > 0.0) return;
    for (int k = 0; k < flow->table.combinations; k++)
        if ((combination[k].n != 0 && modulus[0] == 0.0)
            || (combination[k].m != 0 && modulus[1] == 0.0))
            phasor[k] = sm_cx(0.0, 0.0);
}

/* Adds to the strength of the mode that a combination resonance drives. */
SM_INLINE void sm_add_combination(const sm_instant *instant, int k, int modes,
                                  sm_complex combination, sm_modal *strength) {
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        strength->re[j] += instant->combination_on[k][j] * combination.re;
        strength->im[j] += instant->combination_on[k][j] * combination.im;
    }
}

#endif
