/* Elastic contacts on the torus: `sm_torus_harmonics` and `sm_torus_growing` for SM_ELASTIC. */
#ifndef SLIPMODE_TORUS_ELASTIC_H
#define SLIPMODE_TORUS_ELASTIC_H

#include "slipmode.h"

typedef struct {
    const double *rates;
    int32_t steps, lines;
    double tolerance;
    const double *smallest_scale;
    int32_t max_periods;
    size_t points;
    const double *amplitudes;
    int32_t orders_count;
    const int32_t *orders;
    const double *near;
    double *harmonics, *mean_square, *residual;
    int32_t *marched;
} sm_torus_task;

sm_status sm_torus_elastic(const sm_contact *contact, const sm_torus_task *task);

/* `sm_torus_growing`, of a task that has no tolerance and no periods; see torus/growth.c. */
sm_status sm_torus_elastic_growing(const sm_contact *contact, const sm_torus_task *task,
                                   const double *growth, int settling);

#endif
