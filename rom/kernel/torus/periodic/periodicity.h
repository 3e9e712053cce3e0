/* The test of periodicity: the harmonics of the contact motion repeat from period to period. */
#ifndef SLIPMODE_PERIODICITY_H
#define SLIPMODE_PERIODICITY_H

#include "slipmode.h"

#define SM_SLOW_RATIO 0.5 /* of successive changes, from which marching alone takes too long */

/* How the harmonics of one point converge. */
typedef struct {
    double change[2]; /* last change over a period, relative to the displacement scale; the
                         first after even halves, the second after odd ones */
    double turn;      /* last difference of half periods, see sm_distance_by_halves */
    double ratio;     /* by which it fell */
    double best;      /* smallest change so far */
    int stalled;         /* half periods since `best` last fell noticeably */
    int slow;         /* whether the changes hardly fall from period to period */
    int done;
} sm_progress;

/* Sizes of the contact motion and of the forces (elastic contacts: displacements) that the modes alone
 * cause, at a point's amplitudes or at smallest_scale, whichever are larger. Rigid contacts move by
 * 2 |L_j| a_j / K_ii without friction; elastic contacts that stick have half the peak of the force. */
typedef struct {
    double of_mode[SM_MODES]; /* motion by each mode; elastic contacts: 0 */
    double motion, response;  /* largest motion, largest force (displacement) */
} sm_scales;

void sm_progress_start(sm_progress *progress);
/* What follows does not continue the series of changes. */
void sm_progress_restart(sm_progress *progress);
sm_scales sm_scales_at(const sm_contact *contact, const double *amplitude,
                       const double *smallest_scale);
/* The size that harmonic (n, m) is measured by. */
double sm_scale_of(const sm_scales *scales, const int32_t *order);
/* Largest difference of harmonics (orders_count, N_c, 2), relative to the scales; 0 without any. */
double sm_relative_distance(const sm_scales *scales, int contacts, int orders_count,
                            const int32_t *orders, const double *one, const double *other);
/* Distance of the last half period from those to come, when its harmonics differ by `turn` from
 * the half before. Odd motion repeats with opposite sign after half a period. If the two halves are
 * not of one grid, the series of `turn` begins anew with the same ratio. */
double sm_distance_by_halves(sm_progress *progress, double turn);
void sm_progress_other_grid(sm_progress *progress);
/* Distance from periodicity after so many half periods: the smaller of `by_halves` and the estimate
 * from the change of the harmonics over a whole period; sets progress->done. */
double sm_distance_from_periodic(sm_progress *progress, const sm_scales *scales, double change,
                                 double by_halves, int halves, double tolerance);

#endif
