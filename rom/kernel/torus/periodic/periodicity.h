/* The test of periodicity of rigid contacts on the torus, eq. (13), after each half period.
 * Friction is odd: the motion of a half period repeats with opposite sign, except where contacts
 * stick at an offset. The harmonics of each half period are therefore compared with the half period
 * before, and means of two half periods with the means one period before. The march ends when one
 * of them repeats. Called by search.c. */
#ifndef SLIPMODE_PERIODICITY_H
#define SLIPMODE_PERIODICITY_H

#include "base/block.h"
#include "torus/march.h"

/* The convergence of the harmonics of one point. */
typedef struct {
    double *half, *half_square; /* (orders, N_c, 2), (N_c): results of the last half period */
    double *mean[2];    /* (orders, N_c, 2) means of two half periods, after even and odd numbers */
    double *sum, *sum_square; /* sums of the means since `best` decreased */
    double change[2];   /* last change of `mean` over a period, relative to the scales */
    double half_change; /* last change of `half`, relative to the scales */
    double half_ratio;  /* ratio of the last two changes of `half` */
    double best;        /* smallest change so far */
    int stalled;        /* half periods since `best` decreased by the factor PROGRESS */
    int slow;           /* 1: changes decrease slowly from period to period */
    int done;           /* 1: periodic, or the changes have stalled */
} sm_progress;

/* Places the arrays for so many doubles of the harmonics and so many contacts. */
void sm_progress_place(sm_progress *progress, size_t harmonics, size_t contacts, sm_block *block);
/* Prepares the test for a march from rest. */
void sm_progress_start(sm_progress *progress, size_t harmonics, size_t contacts);
/* Forgets the changes: the displacements were extrapolated. */
void sm_progress_restart(sm_progress *progress);
/* Receives the harmonics Y and mean squares of a half period, replaces both by the result so far,
 * sets `done`, and returns the residual: the estimated distance from periodicity. The result is the
 * last half period if half periods of one line repeat, else the mean of the last two. On a coarse
 * grid the harmonics may keep changing by the discretisation error, because the phases of the lines
 * change from period to period. If the changes stall, the result is the mean since then, and the
 * residual is the distance of the last harmonics from it. */
double sm_progress_next(sm_progress *progress, const sm_march *march, const sm_scales *scales,
                        double *Y, double *square);

#endif
