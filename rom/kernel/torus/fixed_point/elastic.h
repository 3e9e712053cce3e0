/* Elastic contacts on the torus: `sm_torus_harmonics` and `sm_torus_growing` for SM_ELASTIC. */
#ifndef SLIPMODE_TORUS_ELASTIC_H
#define SLIPMODE_TORUS_ELASTIC_H

#include "slipmode.h"

/* What is computed: the arguments of sm_torus_harmonics. */
typedef struct {
    const sm_discretisation *grid;
    const sm_torus_points *points;
    const sm_torus_motion *motion;
} sm_torus_task;

sm_status sm_torus_elastic(const sm_contact *contact, const sm_torus_task *task);

/* `sm_torus_growing`, of a task that has no tolerance and no periods; see torus/growth.c. */
sm_status sm_torus_elastic_growing(const sm_contact *contact, const sm_torus_task *task,
                                   const double *growth, int settling);

#endif
