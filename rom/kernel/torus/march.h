/* A block of phase lines, marched through half a period of mode A. */
#ifndef SLIPMODE_MARCH_H
#define SLIPMODE_MARCH_H

#include "torus/group.h"

/* The first or second half of the steps: adds x exp(-i (n + m ratio) t_A) / steps to the sums of the
 * block's lanes, and x^2 to the squares of that half. */
sm_status sm_torus_march(const sm_torus_grid *grid, const sm_torus_group *group, int block,
                         int half);

#endif
