/* The torus of contacts that are soft against the modes that respond to them. */
#ifndef SLIPMODE_TORUS_SOFT_H
#define SLIPMODE_TORUS_SOFT_H

#include "torus/fixed_point/elastic.h"
#include "torus/group.h"

/* Whether relaxed passes from response to response may take too long, or diverge. */
int sm_torus_is_soft(const sm_torus_grid *grid);
/* Solves the points of a group, `first` on, by Anderson's acceleration. */
sm_status sm_torus_soft_group(const sm_torus_grid *grid, sm_torus_group *group,
                              const sm_torus_task *task, size_t first, size_t count);

#endif
