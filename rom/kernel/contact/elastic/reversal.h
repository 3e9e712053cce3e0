/* Where sliders turn back between two steps.
 *
 * A slider that slid and now sticks has stopped where its contact was farthest, which is beyond
 * the farthest of its steps by a part of the step's square. That is what steps lose most by: a
 * parabola through the last three tells it but for the cube. */
#ifndef SLIPMODE_REVERSAL_H
#define SLIPMODE_REVERSAL_H

#include "contact/elastic/law.h"

/* Moves the sliders that turned back at the middle one of three displacements x (3, N_c) at even
 * times, the last of them where `memory` is. Friction in two directions is left as it is: there
 * the direction turns, and the slider never stops. */
void sm_elastic_reverse(const sm_elastic *elastic, const double *const x[3], double *memory);

#endif
