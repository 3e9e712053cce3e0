/* The response of the modes to the harmonics P_nm of the contacts, eq. (14), tabulated over the
 * amplitude plane. */
#ifndef SLIPMODE_RESPONSE_SURFACE_H
#define SLIPMODE_RESPONSE_SURFACE_H

#include "base/block.h"
#include "slow/slow_flow.h"

/* Weights of the nodes of a friction table at given amplitudes, and phasors of the harmonics. */
typedef struct {
    size_t node[4];
    double weight[4];          /* times the scale of the friction limits */
    sm_complex unit[SM_MODES]; /* exp(i arg e) of the effective amplitude; 0 at rest */
} sm_response_point;

/* Returns the point of amplitudes a + shift force (modes, 2) at frequencies [rad/s] and a limit
 * scale. */
sm_response_point sm_response_point_at(const sm_slow_flow *flow, const double *frequency,
                                       double limit_scale, const double *amplitude);

/* Computes coefficients c_nm (orders, width, 2) of `width` signals from harmonics `values` (nodes,
 * orders, width, 2) at the nodes. */
void sm_response_coefficients(const sm_response_point *point, int count, const int32_t *orders,
                              size_t width, const double *values, double *coefficient);

/* Adds Re sum c_nm exp(i (n theta_A + m theta_B)) to each signal (width). */
void sm_response_add_sums(const sm_response_point *point, int count, const int32_t *orders,
                          size_t width, const double *values, const sm_complex carrier[SM_MODES],
                          double *signal);

#endif
