/* When the contact motion counts as periodic: its harmonics repeat from period to period. */
#ifndef SLIPMODE_PERIODICITY_H
#define SLIPMODE_PERIODICITY_H

#include "slipmode.h"

/* How the harmonics of one point settle. */
typedef struct {
    double change; /* last change, relative to the displacement scale */
    double best;   /* smallest change so far */
    int idle;      /* periods since `best` last fell noticeably */
    int done;
} sm_progress;

/* Frictionless contact displacement that each mode alone would cause: the scale of its harmonics.
 * The larger of the one at the point's amplitudes and the one at smallest_scale. */
typedef struct {
    double of_mode[SM_MODES], largest;
} sm_scales;

void sm_progress_start(sm_progress *progress);
sm_scales sm_displacement_scales(const sm_contact *contact, const double *amplitude,
                                 const double *smallest_scale);
/* Distance from periodicity after a period that turned the harmonics `last` into `fresh`, both
 * (orders_count, N_c, 2); sets progress->done. `first` is the first period: nothing to compare. */
double sm_distance_from_periodic(sm_progress *progress, const sm_scales *scales, int contacts,
                                 int orders_count, const int32_t *orders, const double *fresh,
                                 const double *last, int first, double tolerance);

#endif
