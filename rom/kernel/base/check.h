/* Checks of arguments, used by the functions that slipmode.h declares; and the limits of numbers
 * that all rooms share. */
#ifndef SLIPMODE_CHECK_H
#define SLIPMODE_CHECK_H

#include <math.h>

#include "slipmode.h"

/* Largest relative difference of numbers that are equal except for rounding [-]: products of
 * matrices, sums of many time steps. Errors in a model are much larger. */
#define SM_ROUNDING_TOLERANCE 1e-9
/* Rounding error of a sum of some ten numbers, relative to the largest of them [-]: residuals,
 * pivots of matrices and steps below are rounding alone. */
#define SM_ROUNDING 1e-14
/* Halvings of a step in a line search: the rest, 2^-50 of the step, is rounding. */
#define SM_MAX_HALVINGS 50
/* Iterations at most: a linear convergence with a ratio of 0.7 reaches 1e-15. Newton's method for
 * random elastic contacts needed up to 64. */
#define SM_MAX_ITERATIONS 100
/* Smallest divisor, in units of SI: reciprocals of smaller numbers are close to overflow. */
#define SM_TINY 1e-300
/* Largest number of steps of a period and of nodes of a table, and largest order of a harmonic: no
 * grid resolves more. */
#define SM_MOST 65536
/* Largest number of displacements in the outputs: sizes of arrays do not overflow. */
#define SM_MOST_OUTPUTS 1000000

/* Returns from the calling function with the status of a call, unless it is SM_OK. */
#define SM_TRY(call)                              \
    do {                                          \
        const sm_status called_ = (call);         \
        if (called_ != SM_OK) return called_;     \
    } while (0)

/* Returns whether no value is NaN or infinite. */
static inline int sm_all_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return 0;
    return 1;
}

/* Returns whether all doubles of an array or structure are finite. */
#define SM_FINITE(doubles) \
    sm_all_finite((const double *)(const void *)&(doubles), sizeof(doubles) / sizeof(double))

/* Returns the factor of the next time step after a step with an error relative to the tolerance, by a
 * method whose error estimate is proportional to h^order; at most `largest`. The safety factor and
 * the smallest factor are usual values (Hairer, Norsett, Wanner 1993, II.4). */
#define SM_SAFETY 0.9
#define SM_SMALLEST_FACTOR 0.2
static inline double sm_step_factor(double error, double order, double largest) {
    if (!(error > 0.0)) return largest;
    return fmin(fmax(SM_SAFETY * pow(error, -1.0 / order), SM_SMALLEST_FACTOR), largest);
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
