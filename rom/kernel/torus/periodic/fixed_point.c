/* Fixed points z = G(z) by Anderson's acceleration: z_next = z + g - sum_k theta_k (dz_k + dg_k),
 * where theta minimises |g - sum_k theta_k dg_k|, g = G(z) - z. See the header. */
#include "torus/periodic/fixed_point.h"

#include <math.h>
#include <string.h>

#include "base/dense.h"

/* The residual stalls if it is not reduced by the factor MIN_REDUCTION in MAX_STALLED evaluations.
 * Slower convergence would need more than 190 evaluations for three digits. */
#define MAX_STALLED 10
#define MIN_REDUCTION 0.7
#define DIVERGENCE_RATIO 4.0 /* residual / least residual above which the iteration restarts */
#define SMALLEST_STEP 0.1    /* of a restart; each restart halves the step */
/* Pivot / diagonal below which a difference is a linear combination of the others: squares of
 * rounding errors relative to squares of differences that still have some digits. */
#define SMALLEST_PIVOT 1e-13

/* Replaces `right` by the theta that solves gram theta = right. The theta of linearly dependent
 * columns is 0. */
static void least_squares(double gram[][SM_ANDERSON_DEPTH], size_t n, double *right) {
    double factor[SM_ANDERSON_DEPTH * SM_ANDERSON_DEPTH];
    for (size_t i = 0; i < n; i++) memcpy(factor + i * n, gram[i], n * sizeof(double));
    (void)sm_cholesky(n, SMALLEST_PIVOT, factor);
    sm_cholesky_solve(n, factor, right);
}

/* Replaces z, whose residual is g, by the next iterate. */
static void combine(sm_fixed_point *a, const double *g, double *z) {
    const size_t size = a->size;
    double theta[SM_ANDERSON_DEPTH] = {0.0};
    const int known = a->count < SM_ANDERSON_DEPTH ? a->count : SM_ANDERSON_DEPTH;
    if (a->count > 0) {
        const size_t slot = (size_t)((a->count - 1) % SM_ANDERSON_DEPTH);
        double *dz = a->dz + slot * size, *dg = a->dg + slot * size;
        for (size_t k = 0; k < size; k++) {
            dz[k] = z[k] - a->z_last[k];
            dg[k] = g[k] - a->g_last[k];
        }
        for (int j = 0; j < known; j++)
            a->gram[slot][j] = a->gram[j][slot] = sm_dot(size, dg, a->dg + (size_t)j * size);
        for (int j = 0; j < known; j++) theta[j] = sm_dot(size, g, a->dg + (size_t)j * size);
        least_squares(a->gram, (size_t)known, theta);
    }
    memcpy(a->z_last, z, size * sizeof(double));
    memcpy(a->g_last, g, size * sizeof(double));
    a->count++;
    for (size_t k = 0; k < size; k++) z[k] += g[k];
    for (int j = 0; j < known; j++)
        for (size_t k = 0; k < size; k++)
            z[k] -= theta[j] * (a->dz[(size_t)j * size + k] + a->dg[(size_t)j * size + k]);
}

void sm_fixed_point_place(sm_fixed_point *f, size_t size, sm_block *block) {
    f->size = size;
    SM_TAKE_EACH(block, size, &f->z_last, &f->g_last, &f->best_z, &f->best_g);
    SM_TAKE_EACH(block, SM_ANDERSON_DEPTH * size, &f->dz, &f->dg);
    sm_fixed_point_start(f);
}

void sm_fixed_point_start(sm_fixed_point *f) {
    f->count = 0;
    f->best = f->reference = INFINITY;
    f->step = 1.0;
    f->stalled = 0;
}

/* Restarts from the iterate with the least residual, with half the step, and forgets the others. */
static void restart(sm_fixed_point *f, double *z) {
    f->step = fmax(0.5 * f->step, SMALLEST_STEP);
    f->count = 1;
    memcpy(f->z_last, f->best_z, f->size * sizeof(double));
    memcpy(f->g_last, f->best_g, f->size * sizeof(double));
    for (size_t k = 0; k < f->size; k++) z[k] = f->best_z[k] + f->step * f->best_g[k];
}

int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z) {
    const size_t bytes = f->size * sizeof(double);
    f->stalled++;
    if (residual < MIN_REDUCTION * f->reference) {
        f->reference = residual;
        f->stalled = 0;
    }
    if (residual < f->best) {
        f->best = residual;
        memcpy(f->best_z, z, bytes);
        memcpy(f->best_g, change, bytes);
    }
    if (f->stalled >= MAX_STALLED)
        memcpy(z, f->best_z, bytes);
    else if (residual > DIVERGENCE_RATIO * f->best)
        restart(f, z);
    else
        combine(f, change, z);
    return f->stalled < MAX_STALLED;
}
