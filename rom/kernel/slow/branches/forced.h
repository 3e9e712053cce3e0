/* Inputs along the line of a forced slow flow, for forced.c and solutions.c. */
#ifndef SLIPMODE_FORCED_H
#define SLIPMODE_FORCED_H

#include "slow/slow_flow.h"

/* Returns the inputs at a part (0 to 1) of the line. */
sm_inputs sm_forced_inputs(const sm_forced *forced, double part);

#endif
