/* Checks that the entries make on what they are given. */
#ifndef SLIPMODE_CHECK_H
#define SLIPMODE_CHECK_H

#include <math.h>

#include "slipmode.h"

#define SM_SYMMETRY_TOLERANCE 1e-9 /* of a matrix, relative to its diagonal */

static inline int sm_all_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return 0;
    return 1;
}

static inline sm_status sm_check_positive(double value) {
    if (!isfinite(value)) return SM_NOT_FINITE;
    return value > 0.0 ? SM_OK : SM_BAD_ARGUMENT;
}

static inline sm_status sm_check_not_negative(double value) {
    if (!isfinite(value)) return SM_NOT_FINITE;
    return value >= 0.0 ? SM_OK : SM_BAD_ARGUMENT;
}

/* Whether `count` elements of `size` bytes fit in memory at all. */
static inline int sm_fits(size_t count, size_t size) { return count <= SIZE_MAX / 2 / size; }

#endif
