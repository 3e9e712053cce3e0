/* Fixed points z = G(z) by Anderson's acceleration: z_next = z + g - sum_k theta_k (dz_k + dg_k),
 * where theta minimises |g - sum_k theta_k dg_k|, g = G(z) - z. See the header. */
#include "torus/periodic/fixed_point.h"

#include <math.h>
#include <string.h>

/* The residual stalls if it is not reduced by the factor MIN_REDUCTION in MAX_STALLED evaluations.
 * Slower convergence would need more than 190 evaluations for three digits. */
#define MAX_STALLED 10
#define MIN_REDUCTION 0.7
#define DIVERGENCE_RATIO 4.0 /* residual / least residual above which the iteration restarts */
#define SMALLEST_STEP 0.1    /* of a restart; each restart halves the step */
/* Pivot / diagonal below which a difference is a linear combination of the others: squares of
 * rounding errors relative to squares of differences that still have some digits. */
#define SMALLEST_PIVOT 1e-13

/* Returns the inner product of two vectors. */
static double dot(const double *a, const double *b, size_t size) {
    double sum = 0.0;
    for (size_t k = 0; k < size; k++) sum += a[k] * b[k];
    return sum;
}

/* Solves gram theta = right by Cholesky's factorisation, and replaces `right` by theta. Linearly
 * dependent columns are omitted: their theta is 0. */
static void least_squares(double gram[][SM_ANDERSON_DEPTH], double *right, int n) {
    double factor[SM_ANDERSON_DEPTH][SM_ANDERSON_DEPTH], largest = 0.0;
    int used[SM_ANDERSON_DEPTH];
    for (int i = 0; i < n; i++) largest = fmax(largest, gram[i][i]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = gram[i][j];
            for (int k = 0; k < j; k++) sum -= used[k] ? factor[i][k] * factor[j][k] : 0.0;
            if (j < i) {
                factor[i][j] = used[j] ? sum / factor[j][j] : 0.0;
            } else {
                used[i] = sum > SMALLEST_PIVOT * fmax(gram[i][i], SMALLEST_PIVOT * largest);
                factor[i][i] = used[i] ? sqrt(sum) : 1.0;
            }
        }
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) right[i] -= used[k] ? factor[i][k] * right[k] : 0.0;
        right[i] = used[i] ? right[i] / factor[i][i] : 0.0;
    }
    for (int i = n; i-- > 0;) {
        for (int k = i + 1; k < n; k++) right[i] -= used[k] ? factor[k][i] * right[k] : 0.0;
        right[i] = used[i] ? right[i] / factor[i][i] : 0.0;
    }
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
            a->gram[slot][j] = a->gram[j][slot] = dot(dg, a->dg + (size_t)j * size, size);
        for (int j = 0; j < known; j++) theta[j] = dot(g, a->dg + (size_t)j * size, size);
        least_squares(a->gram, theta, known);
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
    double **rows[] = {&f->z_last, &f->g_last, &f->best_z, &f->best_g};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(block, size);
    f->dz = sm_take(block, SM_ANDERSON_DEPTH * size);
    f->dg = sm_take(block, SM_ANDERSON_DEPTH * size);
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
