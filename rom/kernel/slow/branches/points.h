/* The slow flow of steady motion at a point: without a'', combination resonances at their mean, 0. */
#ifndef SLIPMODE_POINTS_H
#define SLIPMODE_POINTS_H

#include "slipmode.h"
#include "slow/first_order.h"

/* At amplitudes y (2 modes) and inputs that are checked; of a flow that is. `sloped` as in
 * sm_first_order. What `instant` remembers of another point is only spared work. */
sm_status sm_steady_point(const sm_slow_flow *flow, const sm_inputs *inputs, int sloped,
                          const double *y, sm_instant *instant, sm_flow_state *state);

/* d rate / d amplitude (2 modes, 2 modes) there, a column for each real part and each imaginary
 * one. */
void sm_steady_jacobian(const sm_slow_flow *flow, const sm_instant *instant,
                        const sm_flow_state *state, double *jacobian);

#endif
