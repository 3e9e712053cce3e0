/* Elastic contacts on the torus: `sm_torus_harmonics` and `sm_torus_growing` for SM_ELASTIC. */
#ifndef SLIPMODE_TORUS_ELASTIC_H
#define SLIPMODE_TORUS_ELASTIC_H

#include "slipmode.h"
#include "torus/group.h"

/* What is computed: the arguments of sm_torus_harmonics. */
typedef struct {
    const sm_discretisation *grid;
    const sm_torus_points *points;
    const sm_torus_motion *motion;
} sm_torus_task;

sm_status sm_torus_elastic(const sm_contact *contact, const sm_torus_task *task);

/* `sm_torus_growing` for SM_ELASTIC, of a task without tolerance and periods; see torus/growth.c.
 * `before`: periods from rest to the first that counts. */
sm_status sm_torus_elastic_growing(const sm_contact *contact, const sm_torus_task *task,
                                   const double *growth, int before);

/* The contacts and how finely they are resolved. */
sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid);

/* Finite amplitudes or growths (points, modes), and that the results at so many points fit. */
sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count);

/* Whether relaxed passes from response to response may take too long, or diverge. */
int sm_torus_is_soft(const sm_torus_grid *grid);
/* Solves the points of a group, `first` on, by Anderson's acceleration. */
sm_status sm_torus_soft_group(const sm_torus_grid *grid, sm_torus_group *group,
                              const sm_torus_task *task, size_t first, size_t count);

#endif
