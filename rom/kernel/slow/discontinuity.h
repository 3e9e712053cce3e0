/* What discontinuities of the forces leave behind. */
#ifndef SLIPMODE_DISCONTINUITY_H
#define SLIPMODE_DISCONTINUITY_H

#include "slipmode.h"

/* The forces that the modes moved under until now; `known` 0: whatever acts next did before. */
typedef struct {
    double force[SM_MODES], phase[SM_MODES], known;
} sm_held_force;

sm_held_force sm_hold_force(const sm_inputs *inputs);

/* Adds to the amplitudes (SM_MODES complex) the free vibrations with which displacement and
 * velocity of the modes go on as they were where the forces are discontinuous, from `held` to those
 * of `now`: the motion that the new force maintains does not fit them. 1 if there was one.
 *
 * A slow amplitude a vibrates freely as exp((-gamma / 2 + i omega_d) t) alone. Of its own force,
 * discontinuous by F, a mode therefore keeps
 *   a = i exp(-i theta) Re(F exp(i theta) / (gamma + 2 i (Omega + omega_d))) / omega_d,
 * and of another's, to which it responds by q exp(i theta_j), what makes displacement and velocity
 * of both together zero. */
int sm_force_discontinuity(const sm_slow_flow *flow, const sm_held_force *held,
                           const sm_inputs *now, double *amplitude);

#endif
