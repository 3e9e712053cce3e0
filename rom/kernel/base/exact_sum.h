/* Sums and angles without accumulated rounding errors: the compensated sum of Neumaier (1974).
 * Times, angles theta_j and energies of a component, and of a tone, are such sums. */
#ifndef SLIPMODE_EXACT_SUM_H
#define SLIPMODE_EXACT_SUM_H

#include <math.h>

#define SM_TWO_PI 6.283185307179586
#define SM_TWO_PI_HIGH 6.283185303211212 /* first 30 bits of 2 pi: exact times up to 2^23 turns */
#define SM_TWO_PI_LOW 3.968374318722162e-09 /* 2 pi - SM_TWO_PI_HIGH */

/* Steps after which a phasor that is advanced by products is computed from its angle again: it has
 * then a rounding error of some 64 * 1e-16, and sine and cosine cost little per step. */
#define SM_EXACT_STEPS 64

typedef struct {
    double value, carry; /* the sum is value + carry; `value` is the double nearest to it */
} sm_exact_sum;

/* Adds a term. */
static inline void sm_add(sm_exact_sum *sum, double term) {
    const double total = sum->value + term;
    const double rounding = fabs(sum->value) >= fabs(term) ? (sum->value - total) + term
                                                           : (term - total) + sum->value;
    sum->value = total;
    sum->carry += rounding;
    const double nearest = sum->value + sum->carry;
    sum->carry -= nearest - sum->value;
    sum->value = nearest;
}

/* Adds a term to an angle and reduces the angle to [0, 2 pi). */
static inline void sm_add_angle(sm_exact_sum *angle, double term) {
    sm_add(angle, term);
    const double turns = floor(angle->value / SM_TWO_PI);
    if (turns != 0.0) {
        sm_add(angle, -turns * SM_TWO_PI_HIGH);
        sm_add(angle, -turns * SM_TWO_PI_LOW);
    }
}

#endif
