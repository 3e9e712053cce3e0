/* A slow flow under inputs that change along a straight line. */
#ifndef SLIPMODE_FORCED_H
#define SLIPMODE_FORCED_H

#include "slipmode.h"

/* The inputs at p; neither is checked. */
sm_inputs sm_forced_inputs(const sm_forced *forced, double p);

#endif
