/* Periodic motion as a fixed point, by Anderson's acceleration: for elastic contacts, and for rigid
 * ones to which the modes respond strongly. */
#ifndef SLIPMODE_SEARCH_H
#define SLIPMODE_SEARCH_H

#include "torus/march.h"

/* Solves all points of the task. */
sm_status sm_torus_search(sm_march *march);

#endif
