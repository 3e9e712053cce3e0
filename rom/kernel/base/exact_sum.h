/* Sums and angles that many small terms do not carry away: Neumaier's compensated sum. */
#ifndef SLIPMODE_EXACT_SUM_H
#define SLIPMODE_EXACT_SUM_H

#include <math.h>

#define SM_TWO_PI 6.283185307179586
#define SM_TWO_PI_HIGH 6.283185303211212 /* 30 bits of 2 pi: times up to 2^23 turns it is exact */
#define SM_TWO_PI_LOW 3.968374318722162e-09 /* 2 pi - SM_TWO_PI_HIGH */

/* Steps after which a phasor that is advanced by products is computed from its exact angle again. */
#define SM_EXACT_STEPS 64

typedef struct {
    double value, carry; /* the sum is value + carry, value the double nearest to it */
} sm_exact_sum;

static inline void sm_add(sm_exact_sum *sum, double term) {
    const double total = sum->value + term;
    const double lost = fabs(sum->value) >= fabs(term) ? (sum->value - total) + term
                                                       : (term - total) + sum->value;
    sum->value = total;
    sum->carry += lost;
    const double settled = sum->value + sum->carry;
    sum->carry -= settled - sum->value;
    sum->value = settled;
}

/* Adds to an angle and brings it back to [0, 2 pi). */
static inline void sm_add_angle(sm_exact_sum *angle, double term) {
    sm_add(angle, term);
    const double turns = floor(angle->value / SM_TWO_PI);
    if (turns != 0.0) {
        sm_add(angle, -turns * SM_TWO_PI_HIGH);
        sm_add(angle, -turns * SM_TWO_PI_LOW);
    }
}

#endif
