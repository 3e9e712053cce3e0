/* Combination resonances: harmonics (n, m) of the contacts that drive a mode close to its carrier. */
#ifndef SLIPMODE_COMBINATION_H
#define SLIPMODE_COMBINATION_H

#include "slow/instant.h"

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
