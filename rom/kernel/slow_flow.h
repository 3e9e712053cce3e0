#ifndef SLIPMODE_SLOW_FLOW_H
#define SLIPMODE_SLOW_FLOW_H

#include "slipmode.h"

#define SM_UNKNOWNS (2 * SM_MODES + 1) /* a_A, a_B and the energy dissipated at the contacts */

/* Everything but the contents of the table. */
sm_status sm_slow_flow_check(const sm_slow_flow *flow);

/* Finite inputs of the first `modes` modes, frequencies > 0. */
sm_status sm_inputs_check(const sm_inputs *inputs, int modes);

/* What the inputs are `elapsed` seconds later, modes that are not there 0. */
sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed);

/* Derivative of (a_A, a_B, energy) at `elapsed` seconds after the inputs' start. */
sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *inputs,
                                  double elapsed, const double *y, double *dy);

/* One Dormand-Prince 5(4) step from y (with derivative dy) over h: new values, the derivative
 * there and the error relative to tolerance (1 is the limit). */
sm_status sm_slow_flow_try(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                           double h, double tolerance, const double *y, const double *dy,
                           double *y_new, double *dy_new, double *error);

#endif
