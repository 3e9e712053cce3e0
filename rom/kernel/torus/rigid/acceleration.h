/* Faster approach to the periodic contact motion.
 *
 * A stuck contact remembers its start: a constant offset on each phase line that fades only by
 * creep. Seen at fixed t_A as a function of t_B, the offset shifts by 2 pi omega_B / omega_A every
 * period, so its Fourier coefficients over t_B form geometric sequences X_m + c r_m^k with
 * complex r_m. Two successive changes give r_m, and the limit X_m (Aitken's extrapolation).
 */
#ifndef SLIPMODE_ACCELERATION_H
#define SLIPMODE_ACCELERATION_H

#include <stddef.h>

typedef struct {
    int recorded;             /* periods since the start or the last extrapolation, up to 2 */
    double *spectrum;         /* (coefficients, N_c, 2) at the end of the last period */
    double *change, *fresh;   /* the same shape: last change, present spectrum */
} sm_acceleration;

/* Doubles of each of these arrays. */
static inline size_t sm_acceleration_size(size_t contacts, size_t lines) {
    return 2 * contacts * (lines < 2 ? 1 : lines / 2);
}

#endif
