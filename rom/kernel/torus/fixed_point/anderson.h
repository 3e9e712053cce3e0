/* Anderson's acceleration of a fixed point z = G(z): the next z is the one whose residual, with
 * the differences of the last iterates, is least (Anderson 1965; type II in Fang and Saad 2009).
 */
#ifndef SLIPMODE_ANDERSON_H
#define SLIPMODE_ANDERSON_H

#include <stddef.h>

#define SM_ANDERSON_DEPTH 20

typedef struct {
    size_t size;
    int count;                        /* iterates seen since the start */
    double *z_last, *g_last;          /* (size) */
    double *dz, *dg;                  /* (SM_ANDERSON_DEPTH, size) */
    double gram[SM_ANDERSON_DEPTH][SM_ANDERSON_DEPTH];
} sm_anderson;

static inline size_t sm_anderson_size(size_t size) { return (2 + 2 * SM_ANDERSON_DEPTH) * size; }
void sm_anderson_place(sm_anderson *a, size_t size, double *memory);
void sm_anderson_start(sm_anderson *a);
/* The same where one z and its residual are known. */
void sm_anderson_start_from(sm_anderson *a, const double *z, const double *g);
/* From z and its residual g = G(z) - z to the next z. */
void sm_anderson_next(sm_anderson *a, const double *g, double *z);

#endif
