#include "torus/periodic/fixed_point.h"

#include <math.h>
#include <string.h>

#define PATIENCE 10   /* evaluations in which the residual may fail to fall by this factor: */
#define BETTER 0.7
#define ASTRAY 4.0    /* times the least residual */
#define LEAST_PART 0.1
#define REGULARISED 1e-13 /* of the largest pivot: differences that are multiples of others */

static double dot(const double *a, const double *b, size_t size) {
    double sum = 0.0;
    for (size_t k = 0; k < size; k++) sum += a[k] * b[k];
    return sum;
}

/* gram theta = right by Cholesky's factors, without the columns that others have already. */
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
                used[i] = sum > REGULARISED * fmax(gram[i][i], REGULARISED * largest);
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
    double **rows[] = {&f->z_last, &f->g_last, &f->nearest, &f->change};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(block, size);
    f->dz = sm_take(block, SM_ANDERSON_DEPTH * size);
    f->dg = sm_take(block, SM_ANDERSON_DEPTH * size);
    sm_fixed_point_start(f);
}

void sm_fixed_point_start(sm_fixed_point *f) {
    f->count = 0;
    f->best = f->fallen = INFINITY;
    f->part = 1.0;
    f->stalled = 0;
}

/* Back to the nearest z and from there a smaller way, its change the first that is known. */
static void start_again(sm_fixed_point *f, double *z) {
    f->part = fmax(0.5 * f->part, LEAST_PART);
    f->count = 1;
    memcpy(f->z_last, f->nearest, f->size * sizeof(double));
    memcpy(f->g_last, f->change, f->size * sizeof(double));
    for (size_t k = 0; k < f->size; k++) z[k] = f->nearest[k] + f->part * f->change[k];
}

int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z) {
    const size_t bytes = f->size * sizeof(double);
    f->stalled++;
    if (residual < BETTER * f->fallen) {
        f->fallen = residual;
        f->stalled = 0;
    }
    if (residual < f->best) {
        f->best = residual;
        memcpy(f->nearest, z, bytes);
        memcpy(f->change, change, bytes);
    }
    if (f->stalled >= PATIENCE)
        memcpy(z, f->nearest, bytes);
    else if (residual > ASTRAY * f->best)
        start_again(f, z);
    else
        combine(f, change, z);
    return f->stalled < PATIENCE;
}
