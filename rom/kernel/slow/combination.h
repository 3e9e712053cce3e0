/* Near resonances: harmonics (n, m) of the contacts that drive a mode close to its carrier. */
#ifndef SLIPMODE_NEAR_H
#define SLIPMODE_NEAR_H

#include "slow/instant.h"

/* exp(i (n t_A + m t_B - t_j)), t_j = theta_j + arg a_j: how a near resonance turns against its
 * mode. */
SM_INLINE sm_complex sm_near_turn(const sm_near *near, sm_complex wave, const sm_modal *unit) {
    const sm_complex by_a = sm_unit_power(sm_of(unit, 0), near->n - (near->mode == 0));
    const sm_complex by_b = sm_unit_power(sm_of(unit, 1), near->m - (near->mode == 1));
    return sm_cmul(sm_cmul(wave, by_b), by_a);
}

/* Those of all near resonances, many of them equal or opposite to the first; 0 for harmonics of
 * an amplitude that is. */
SM_INLINE void sm_near_turns(const sm_slow_flow *flow, const sm_instant *instant,
                             const sm_modal *unit, const double *modulus, sm_complex *turn) {
    const sm_near *near = flow->near;
    for (int k = 0; k < flow->table.near; k++) {
        const int like_first = instant->like_first[k];
        turn[k] = like_first ? sm_cx(turn[0].re, like_first * turn[0].im)
                             : sm_near_turn(&near[k], instant->near_wave[k], unit);
    }
    if (modulus[0] * modulus[1] > 0.0) return;
    for (int k = 0; k < flow->table.near; k++)
        if ((near[k].n != 0 && modulus[0] == 0.0) || (near[k].m != 0 && modulus[1] == 0.0))
            turn[k] = sm_cx(0.0, 0.0);
}

/* Adds to the strength of the mode that a near resonance drives. */
SM_INLINE void sm_add_near(const sm_instant *instant, int k, int modes, sm_complex near,
                           sm_modal *strength) {
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        strength->re[j] += instant->near_on[k][j] * near.re;
        strength->im[j] += instant->near_on[k][j] * near.im;
    }
}

#endif
