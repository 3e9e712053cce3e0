/* Numbers that carry their derivatives with respect to the displacements of a contact: forward
 * differentiation for frictional.c. */
#ifndef SLIPMODE_DUAL_H
#define SLIPMODE_DUAL_H

#include <math.h>

#include "contact/elastic/law.h"

typedef struct {
    double value, slope[SM_MOST_COLUMNS];
} sm_dual;

static inline sm_dual sm_dual_constant(double value) { return (sm_dual){.value = value}; }

/* Returns f(a, b) from its value and its partial derivatives with respect to a and b. */
static inline sm_dual sm_dual_of(double value, double by_a, sm_dual a, double by_b, sm_dual b) {
    sm_dual f = {.value = value};
    for (int k = 0; k < SM_MOST_COLUMNS; k++) f.slope[k] = by_a * a.slope[k] + by_b * b.slope[k];
    return f;
}

static inline sm_dual sm_dual_add(sm_dual a, sm_dual b) {
    return sm_dual_of(a.value + b.value, 1.0, a, 1.0, b);
}

static inline sm_dual sm_dual_sub(sm_dual a, sm_dual b) {
    return sm_dual_of(a.value - b.value, 1.0, a, -1.0, b);
}

static inline sm_dual sm_dual_mul(sm_dual a, sm_dual b) {
    return sm_dual_of(a.value * b.value, b.value, a, a.value, b);
}

static inline sm_dual sm_dual_div(sm_dual a, sm_dual b) {
    const double quotient = a.value / b.value;
    return sm_dual_of(quotient, 1.0 / b.value, a, -quotient / b.value, b);
}

static inline sm_dual sm_dual_scale(double factor, sm_dual a) {
    return sm_dual_of(factor * a.value, factor, a, 0.0, a);
}

/* Returns the square root of a, or 0 if rounding made a negative. */
static inline sm_dual sm_dual_root(sm_dual a) {
    const double root = a.value > 0.0 ? sqrt(a.value) : 0.0;
    return sm_dual_of(root, root > 0.0 ? 0.5 / root : 0.0, a, 0.0, a);
}

static inline sm_dual sm_dual_dot(const sm_dual a[2], const sm_dual b[2]) {
    return sm_dual_add(sm_dual_mul(a[0], b[0]), sm_dual_mul(a[1], b[1]));
}

#endif
