#ifndef SLIPMODE_SLOW_FLOW_H
#define SLIPMODE_SLOW_FLOW_H

#include "slow/first_order.h"
#include "slipmode.h"

/* a_A, a_B and the energies dissipated at the contacts and put in by the forces */
#define SM_UNKNOWNS (2 * SM_MODES + 2)
#define SM_DISSIPATED (2 * SM_MODES)
#define SM_PUT_IN (2 * SM_MODES + 1)

/* Everything but the contents of the table. */
sm_status sm_slow_flow_check(const sm_slow_flow *flow);

/* The flow and the inputs `elapsed` seconds after their start, which are put
 * into *now. */
sm_status sm_slow_flow_check_at(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                                sm_inputs *now);

/* Derivative of the unknowns. It has one compiled body, and what `instant` remembers is only spared
 * work: equal arguments give equal bits. */
sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *now,
                                  sm_instant *instant, const double *y, double *dy);
/* At the inputs that `instant` is set to. */
sm_status sm_slow_flow_derivative_at(const sm_slow_flow *flow, sm_instant *instant,
                                     const double *y, double *dy);

/* One Dormand-Prince 5(4) step from y (with derivative dy), `elapsed` seconds after the inputs'
 * start, over h: new values, the derivative there and the error relative to tolerance (1 is the
 * limit). `end`: the inputs at the end of the step. */
sm_status sm_slow_flow_dopri5(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                           double h, const sm_inputs *end, double tolerance, sm_instant *instant,
                           const double *y, const double *dy, double *y_new, double *dy_new,
                           double *error);

/* The inputs at a part of a line. */
sm_inputs sm_forced_inputs(const sm_forced *forced, double part);

#endif
