/* Points of a solution curve, by Newton's method in a plane across it. */
#ifndef SLIPMODE_CURVE_H
#define SLIPMODE_CURVE_H

#include <math.h>

#include "slipmode.h"

/* z = (y, p), the direction there, and dF/dy (k, k). */
typedef struct {
    double z[SM_CURVE_UNKNOWNS + 1], tangent[SM_CURVE_UNKNOWNS + 1];
    double jacobian[SM_CURVE_UNKNOWNS * SM_CURVE_UNKNOWNS];
    int passes; /* of Newton's method that led to it */
} sm_curve_point;

static inline double sm_curve_dot(int n, const double *a, const double *b) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static inline double sm_curve_distance(int n, const double *a, const double *b) {
    double square = 0.0;
    for (int i = 0; i < n; i++) square += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(square);
}

int sm_curve_is_valid(const sm_curve *curve);

/* The point close to a guess in the plane through it that has this normal; its tangent points
 * onward. SM_NOT_CONVERGED: there is none. */
sm_status sm_curve_corrected(const sm_curve *curve, const double *guess, const double *normal,
                             const double *onward, sm_curve_point *found);

/* The same with a tangent and Jacobian that tell where stability changes. */
sm_status sm_curve_between(const sm_curve *curve, const double *guess, const double *normal,
                           const double *onward, sm_curve_point *found);

#endif
