/* The march of a group towards periodicity, half a period of mode A at a time. */
#ifndef SLIPMODE_ITERATION_H
#define SLIPMODE_ITERATION_H

#include "torus/group.h"

/* The first or second half of a period of mode A; the harmonics over this and the half before
 * are in `fresh`. */
sm_status sm_torus_group_half(const sm_torus_grid *grid, sm_torus_group *group, int half);
/* After a half: let the retained modes respond to the harmonics in `fresh`; after the second,
 * advance the phases and move the lines of unfinished points closer to periodicity. */
void sm_torus_group_next(const sm_torus_grid *grid, sm_torus_group *group, size_t points,
                         int half);
/* The reaction to the harmonics in `responded`, at the present phases. */
void sm_torus_group_react(const sm_torus_grid *grid, sm_torus_group *group);
/* After a period: the phases of the next. */
void sm_torus_group_advance(const sm_torus_grid *grid, sm_torus_group *group);

#endif
