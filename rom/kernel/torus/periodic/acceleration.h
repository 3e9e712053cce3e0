/* Faster approach to the periodic contact motion.
 *
 * A stuck contact remembers its start: a constant offset on each phase line that fades only by
 * creep. Seen at fixed t_A as a function of t_B, the offset shifts by 2 pi omega_B / omega_A every
 * period, so its Fourier coefficients over t_B form geometric sequences X_m + c r_m^k with
 * complex r_m. Two successive changes give r_m, and the limit X_m (Aitken's extrapolation).
 */
#ifndef SLIPMODE_ACCELERATION_H
#define SLIPMODE_ACCELERATION_H

#include "base/block.h"

#define SM_SLOW_RATIO 0.5 /* of successive changes, from which marching alone takes too long */

typedef struct {
    int contacts, lines;
    int recorded;             /* periods since the start or the last extrapolation, up to 2 */
    double *spectrum;         /* (coefficients, N_c, 2) at the end of the last period */
    double *change, *fresh;   /* the same shape: last change, present spectrum */
} sm_acceleration;

void sm_acceleration_place(sm_acceleration *acceleration, int contacts, int lines,
                           sm_block *block);
void sm_acceleration_start(sm_acceleration *acceleration);
/* End of a period: displacements x (N_c, lines) at phases (cosine, sine)(lines) of t_B. Where it is
 * wanted, replaces x by its extrapolation if that is due; returns whether it did. */
int sm_accelerate(sm_acceleration *acceleration, int wanted, const double *cosine,
                  const double *sine, double *x);

#endif
