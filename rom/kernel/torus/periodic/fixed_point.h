/* Fixed points z = G(z) of maps that are known only up to the error of a grid.
 *
 * Anderson's acceleration chooses the next z as the combination of the last iterates whose
 * residual is least (Anderson 1965; type II in Fang and Saad 2009). If the residual grows, the
 * search goes back to the z with the least residual and starts from there with a smaller step.
 */
#ifndef SLIPMODE_FIXED_POINT_H
#define SLIPMODE_FIXED_POINT_H

#include "base/block.h"

#define SM_ANDERSON_DEPTH 20 /* iterates that are combined */

typedef struct {
    size_t size;
    int count;                 /* iterates since the start */
    double *z_last, *g_last;   /* (size) last iterate, and its residual g = G(z) - z */
    double *dz, *dg;           /* (SM_ANDERSON_DEPTH, size) differences of successive ones */
    double gram[SM_ANDERSON_DEPTH][SM_ANDERSON_DEPTH]; /* products of dg */
    double *nearest, *change;  /* (size) z of the least residual, and g there */
    double best;               /* norm of that residual */
    double fallen;             /* what it last fell to noticeably */
    int stalled;               /* evaluations since then */
    double part;               /* of the change that a fresh start from there takes */
} sm_fixed_point;

void sm_fixed_point_place(sm_fixed_point *f, size_t size, sm_block *block);
void sm_fixed_point_start(sm_fixed_point *f);
/* Replaces z by the next iterate, given change = G(z) - z and its norm `residual`. Returns 0 if
 * the residual has stopped falling, because the error of the grid dominates it; z is then the
 * iterate with the least residual. */
int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z);

#endif
