/* Cubic Hermite polynomials between two nodes with values f_0, f_1 and slopes f_0', f_1':
 *   value = f_0 + rise (f_1 - f_0) + bend_0 f_0' + bend_1 f_1',
 *   slope =       rise (f_1 - f_0) + bend_0 f_0' + bend_1 f_1' with other weights.
 * Friction tables (table/table.c, slow/tone/tone_flow.c), amplitudes and forces along a trajectory
 * (slow/motion/) and predictions on solution curves (slow/branches/curve.c) are such polynomials. */
#ifndef SLIPMODE_HERMITE_H
#define SLIPMODE_HERMITE_H

#include "base/lanes.h"

typedef struct {
    double rise, bend[2];
} sm_hermite_weights;

typedef struct {
    sm_hermite_weights value, slope;
} sm_hermite;

/* Returns the weights at the fraction u of the distance h between the nodes. */
SM_INLINE sm_hermite sm_hermite_at(double h, double u) {
    const double v = 1.0 - u, uv = u * v;
    return (sm_hermite){{u * u * (3.0 - 2.0 * u), {h * v * uv, -h * u * uv}},
                        {6.0 * (1.0 / h) * uv, {v * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)}}};
}

/* Returns the slope of a polynomial. */
SM_INLINE double sm_hermite_slope(const sm_hermite_weights *slope, double left, double left_slope,
                                  double right, double right_slope) {
    return slope->bend[0] * left_slope + slope->bend[1] * right_slope
           + slope->rise * (right - left);
}

/* Returns the value of a polynomial. */
SM_INLINE double sm_hermite_value(const sm_hermite_weights *value, double left, double left_slope,
                                  double right, double right_slope) {
    return left + value->bend[0] * left_slope + value->bend[1] * right_slope
           + value->rise * (right - left);
}

#endif
