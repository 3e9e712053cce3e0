/* Free vibrations after discontinuities of the forces. */
#ifndef SLIPMODE_DISCONTINUITY_H
#define SLIPMODE_DISCONTINUITY_H

#include "slipmode.h"

/* The forces up to the present time. `known` is 0 if they are unknown: the next forces are then not
 * treated as a discontinuity. */
typedef struct {
    double force[SM_MODES], phase[SM_MODES], known;
} sm_previous_force;

/* Returns the forces of the inputs. */
sm_previous_force sm_force_of(const sm_inputs *inputs);

/* Adds free vibrations to the amplitudes (SM_MODES complex), which keep displacement and velocity
 * of the modes continuous if the forces change from `previous` to the forces of `now`. Returns 1 if
 * the forces are discontinuous.
 *
 * A slow amplitude vibrates freely as exp((-gamma / 2 + i omega_d) t). After a discontinuity F of
 * its own force a mode vibrates with
 *   a = i exp(-i theta) Re(F exp(i theta) / (gamma + 2 i (Omega + omega_d))) / omega_d.
 * After a discontinuity of another force, to which it responds by q exp(i theta_j), its free
 * vibration cancels displacement and velocity of this response. */
int sm_force_discontinuity(const sm_slow_flow *flow, const sm_previous_force *previous,
                           const sm_inputs *now, double *amplitude);

#endif
