/* A slow flow under inputs that change along a straight line. */
#ifndef SLIPMODE_FORCED_H
#define SLIPMODE_FORCED_H

#include "slipmode.h"

sm_status sm_forced_check(const sm_forced *forced);

/* At p; not checked. */
sm_inputs sm_forced_inputs(const sm_forced *forced, double p);

#endif
