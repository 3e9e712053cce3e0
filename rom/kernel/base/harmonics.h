/* Harmonics (n, m) of two carriers. */
#ifndef SLIPMODE_HARMONICS_H
#define SLIPMODE_HARMONICS_H

#include "base/cnumber.h"
#include "slipmode.h"

#define SM_MOST_ORDERS 512 /* harmonics of one sum */

/* At most SM_MOST_ORDERS of them, each |n| and |m| small enough for what follows. */
sm_status sm_orders_check(int count, const int32_t *orders);

/* exp(i (n theta_A + m theta_B)) of each harmonic. */
void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im);

#endif
