/* Fixed points z = G(z) by Anderson's acceleration, for maps G with a discretisation error.
 *
 * The next iterate is the combination of the last iterates that minimises the linearised residual
 * (Anderson 1965; type II in Fang and Saad 2009). If the residual grows, the iteration restarts
 * from the iterate with the least residual, with a smaller step. Called by periodic/search.c. */
#ifndef SLIPMODE_FIXED_POINT_H
#define SLIPMODE_FIXED_POINT_H

#include "base/block.h"

#define SM_ANDERSON_DEPTH 20 /* differences of successive iterates that are combined */

typedef struct {
    size_t size;
    int count;                 /* iterates since the start or restart */
    double *z_last, *g_last;   /* (size) last iterate, and its residual g = G(z) - z */
    double *dz, *dg;           /* (SM_ANDERSON_DEPTH, size) differences of successive z, and of g */
    double gram[SM_ANDERSON_DEPTH][SM_ANDERSON_DEPTH]; /* inner products of the dg */
    double *best_z, *best_g;   /* (size) iterate with the least residual, and its residual */
    double best;               /* norm of this residual */
    double reference;          /* residual after the last reduction by MIN_REDUCTION */
    int stalled;               /* evaluations since this reduction */
    double step;               /* z = best_z + step best_g after a restart */
} sm_fixed_point;

/* Places the arrays for `size` unknowns. */
void sm_fixed_point_place(sm_fixed_point *f, size_t size, sm_block *block);
/* Forgets all iterates. */
void sm_fixed_point_start(sm_fixed_point *f);
/* Replaces z by the next iterate, given change = G(z) - z and its norm `residual`. Returns 0 if
 * the residual stalls, because the discretisation error dominates it; z is then the iterate with
 * the least residual. */
int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z);

#endif
