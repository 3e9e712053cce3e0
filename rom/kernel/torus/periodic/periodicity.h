/* The test of periodicity of rigid contacts, half period by half period.
 *
 * Friction is odd: half a period repeats the one before with opposite sign, but where contacts
 * that stick are off the middle. So the harmonics of each half are compared with those of the half
 * before, and means of two halves with those a period before. The march ends when either repeats.
 */
#ifndef SLIPMODE_PERIODICITY_H
#define SLIPMODE_PERIODICITY_H

#include "base/block.h"
#include "torus/march.h"

/* How the harmonics of one point converge. */
typedef struct {
    double *half, *half_square; /* (orders, N_c, 2), (N_c): of the last half */
    double *mean[2];    /* (orders, N_c, 2) of the last two halves, after even halves and odd ones */
    double *sum, *sum_square; /* sums of these over the halves without progress */
    double change[2];   /* last change of `mean` over a period, relative to the scales */
    double half_change; /* last change of `half`, */
    double half_ratio;  /* and by which it fell */
    double best;        /* smallest change so far */
    int stalled;        /* half periods since `best` last fell noticeably */
    int slow;           /* whether the changes hardly fall from period to period */
    int done;
} sm_progress;

void sm_progress_place(sm_progress *progress, size_t harmonics, size_t contacts, sm_block *block);
void sm_progress_start(sm_progress *progress, size_t harmonics, size_t contacts);
/* What follows does not continue the series of changes. */
void sm_progress_restart(sm_progress *progress);
/* After a half with harmonics Y and mean squares: replaces both by the result so far, and returns
 * the residual, the estimated distance from periodicity; sets `done`. The result is the last half
 * where halves of one line repeat, else the mean of the last two. Where phases drift from period
 * to period, the harmonics of a coarse grid keep moving by its error: then it is the mean over the
 * halves without progress, and the residual the distance of the last harmonics from it. */
double sm_progress_next(sm_progress *progress, const sm_march *march, const sm_scales *scales,
                        double *Y, double *square);

#endif
