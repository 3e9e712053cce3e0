/* The search for a fixed point z = G(z) whose map is only known up to the error of a grid. */
#ifndef SLIPMODE_FIXED_POINT_H
#define SLIPMODE_FIXED_POINT_H

#include "torus/fixed_point/anderson.h"

#define SM_ALMOST 1e-3 /* residual that is left to means over several periods */
/* Parts of the amplitudes through which points that do not settle are led up from below. */
static const double SM_LADDER[] = {0.3, 0.45, 0.6, 0.7, 0.8, 0.87, 0.94, 1.0};
#define SM_RUNGS (sizeof SM_LADDER / sizeof *SM_LADDER)

typedef struct {
    sm_anderson faster;
    double *nearest, *change;  /* (size) z of the least residual, and G(z) - z there */
    double best;               /* that residual */
    double fallen;             /* what it last fell to noticeably */
    double part;               /* of the change that a fresh start from there takes */
    int idle;                  /* evaluations since then */
} sm_fixed_point;

static inline size_t sm_fixed_point_size(size_t size) {
    return sm_anderson_size(size) + 2 * size;
}
void sm_fixed_point_place(sm_fixed_point *f, size_t size, double *memory);
void sm_fixed_point_start(sm_fixed_point *f);
/* From z, change = G(z) - z and a measure of that to the next z. 0 where it comes no nearer; z is
 * the nearest then: what is left is the error of the grid, and Anderson's differences mislead. */
int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z);

#endif
