/* What the modes respond to the harmonics of the contacts, tabulated over the amplitude plane.
 *
 * Straight between the nodes of a friction table: the response is a few per cent of the motion, so
 * that a surface of higher order would gain nothing.
 */
#ifndef SLIPMODE_RESPONSE_SURFACE_H
#define SLIPMODE_RESPONSE_SURFACE_H

#include "slow/instant.h"

/* Where in a table the contacts are, and how their harmonics are rotated and scaled. */
typedef struct {
    size_t node[4];
    double weight[4];          /* of those nodes, times the scale of the friction limits */
    sm_complex unit[SM_MODES]; /* exp(i arg) of the effective amplitude; 0 at rest */
} sm_response_point;

/* At amplitudes y under `inputs`, to which `instant` is set. Equal arguments give equal bits. */
sm_response_point sm_response_point_at(const sm_slow_flow *flow, sm_instant *instant,
                                       const sm_inputs *inputs, const double *y);

/* Of `width` signals with harmonics `values` (nodes, orders, width, 2):
 * their coefficients (orders, width, 2) there, */
void sm_response_coefficients(const sm_response_point *point, int count, const int32_t *orders,
                              size_t width, const double *values, double *coefficient);
/* and their sums Re sum c_nm exp(i (n theta_A + m theta_B)), added to signal (width). */
void sm_response_add_sums(const sm_response_point *point, int count, const int32_t *orders,
                          size_t width, const double *values, const sm_complex carrier[SM_MODES],
                          double *signal);

#endif
