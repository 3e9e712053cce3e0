/* The friction model of a slow flow: the friction terms of eqs. (18), (19) at given amplitudes, and
 * their derivatives. */
#ifndef SLIPMODE_FRICTION_MODEL_H
#define SLIPMODE_FRICTION_MODEL_H

#include "slow/coefficients.h"

/* Friction terms at effective amplitudes e_k = |e_k| unit_k, relative to the scale of the limits:
 * G_j = unit_j term_j. Derivatives are [j][k], of the term of mode j by e_k. For a change
 * de_k = w_k unit_k,
 *   dG_j = unit_j sum_k (along_jk Re w_k + across_jk Im w_k).
 * This also holds at rest, where unit_k = 1. */
typedef struct {
    double modulus[SM_MODES];
    sm_complex unit[SM_MODES];
    sm_complex term[SM_MODES]; /* [N kg^-1/2] */
    sm_complex along[SM_MODES][SM_MODES], across[SM_MODES][SM_MODES];
    sm_complex beat[SM_MODES]; /* change per second by the beat of the combination resonances */
    double power[2];           /* tabulated powers, see sm_table */
    /* only if the table has them; complex, of modes j and k in row j modes + k: derivatives of the
     * term of mode j by d|e_k|/dt (rate correction R_jk), and by Omega_k (detuning D_jk) with its
     * slopes by the amplitudes */
    double lag[SM_RATE_CORRECTIONS], by_frequency[3 * SM_RATE_CORRECTIONS];
} sm_friction;

/* Which harmonics of the contact force act on a mode. */
typedef enum {
    SM_CARRIERS, /* at the carrier: in steady motion combination resonances have the mean 0 */
    SM_ALL_TERMS /* and the combination resonances */
} sm_friction_terms;

/* Evaluates the friction terms and their derivatives at effective amplitudes e (modes). Returns
 * SM_OUTSIDE_TABLE beyond the last node. */
sm_status sm_friction_at(const sm_slow_flow *flow, sm_instant *instant, sm_friction_terms terms,
                         const sm_complex *e, sm_friction *friction);

#endif
