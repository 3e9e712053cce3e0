/* Checks of arguments, used by the functions that slipmode.h declares. */
#ifndef SLIPMODE_CHECK_H
#define SLIPMODE_CHECK_H

#include <math.h>

#include "slipmode.h"

/* Largest asymmetry |K_ij - K_ji| of a matrix relative to its diagonal [-]. Matrices are products
 * of others and symmetric only up to rounding; errors in a model are much larger. */
#define SM_SYMMETRY_TOLERANCE 1e-9

/* Returns whether no value is NaN or infinite. */
static inline int sm_all_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return 0;
    return 1;
}

/* Returns SM_OK for a finite value > 0. */
static inline sm_status sm_check_positive(double value) {
    if (!isfinite(value)) return SM_NOT_FINITE;
    return value > 0.0 ? SM_OK : SM_BAD_ARGUMENT;
}

/* Returns SM_OK for a finite value >= 0. */
static inline sm_status sm_check_not_negative(double value) {
    if (!isfinite(value)) return SM_NOT_FINITE;
    return value >= 0.0 ? SM_OK : SM_BAD_ARGUMENT;
}

/* Returns whether the size in bytes of `count` elements of `size` bytes can be represented. */
static inline int sm_fits(size_t count, size_t size) { return count <= SIZE_MAX / 2 / size; }

#endif
