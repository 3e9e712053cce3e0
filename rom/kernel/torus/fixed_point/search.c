#include "torus/fixed_point/search.h"

#include <math.h>
#include <string.h>

#define PATIENCE 10   /* evaluations in which the residual may fail to fall by this factor: */
#define BETTER 0.7
#define ASTRAY 4.0    /* times the least residual */
#define LEAST_PART 0.1

void sm_fixed_point_place(sm_fixed_point *f, size_t size, double *memory) {
    sm_anderson_place(&f->faster, size, memory);
    f->nearest = memory + sm_anderson_size(size);
    f->change = f->nearest + size;
    sm_fixed_point_start(f);
}

void sm_fixed_point_start(sm_fixed_point *f) {
    sm_anderson_start(&f->faster);
    f->best = f->fallen = INFINITY;
    f->part = 1.0;
    f->idle = 0;
}

/* Back to the nearest z and from there a smaller way, its change the first that is known. */
static void start_again(sm_fixed_point *f, double *z) {
    const size_t size = f->faster.size;
    f->part = fmax(0.5 * f->part, LEAST_PART);
    sm_anderson_start_from(&f->faster, f->nearest, f->change);
    for (size_t k = 0; k < size; k++) z[k] = f->nearest[k] + f->part * f->change[k];
}

int sm_fixed_point_next(sm_fixed_point *f, double residual, const double *change, double *z) {
    const size_t bytes = f->faster.size * sizeof(double);
    f->idle++;
    if (residual < BETTER * f->fallen) {
        f->fallen = residual;
        f->idle = 0;
    }
    if (residual < f->best) {
        f->best = residual;
        memcpy(f->nearest, z, bytes);
        memcpy(f->change, change, bytes);
    }
    if (f->idle >= PATIENCE)
        memcpy(z, f->nearest, bytes);
    else if (residual > ASTRAY * f->best)
        start_again(f, z);
    else
        sm_anderson_next(&f->faster, change, z);
    return f->idle < PATIENCE;
}
