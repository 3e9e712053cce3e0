/* The test of periodicity of rigid contacts: changes are extrapolated as a geometric series. If
 * successive changes c have the ratio r, the distance from the limit is c r / (1 - r). See the
 * header; called by search.c. */
#include "torus/periodic/periodicity.h"

#include <math.h>

/* Bound of the distance of the mean of two half periods from the limit / their difference: both
 * have a discretisation error while the phases of the lines change. */
#define MEAN_DISTANCE 2.0
/* Half periods without a decrease of the changes by PROGRESS, after which the rest of the changes
 * is taken as the discretisation error. */
#define STALLED_HALVES 80
#define PROGRESS 0.8
#define INITIAL_RATIO 0.9 /* of successive changes before two are known: a slow convergence */
/* Bounds of the ratio of successive changes: the limit is estimated with a factor r / (1 - r)
 * between 0.4 and 32, because single ratios scatter. */
#define SMALLEST_RATIO 0.3
#define LARGEST_RATIO 0.97

void sm_progress_place(sm_progress *t, size_t harmonics, size_t contacts, sm_block *block) {
    SM_TAKE_EACH(block, harmonics, &t->half, &t->mean[0], &t->mean[1], &t->sum);
    SM_TAKE_EACH(block, contacts, &t->half_square, &t->sum_square);
}

void sm_progress_start(sm_progress *t, size_t harmonics, size_t contacts) {
    memset(t->half, 0, harmonics * sizeof(double));
    memset(t->half_square, 0, contacts * sizeof(double));
    sm_progress_restart(t);
    t->best = INFINITY;
    t->stalled = t->slow = t->done = 0;
}

void sm_progress_restart(sm_progress *t) {
    t->change[0] = t->change[1] = t->half_change = 0.0;
    t->half_ratio = INITIAL_RATIO;
}

/* Returns the ratio of successive changes within its bounds; `initial` if only one is known. */
static double ratio_of(double now, double before, double initial) {
    return before > 0.0 ? fmin(fmax(now / before, SMALLEST_RATIO), LARGEST_RATIO) : initial;
}

/* Returns the distance from the limit of a geometric series after the change `now`. */
static double distance_from_limit(double now, double ratio) { return now * ratio / (1.0 - ratio); }

/* Returns the distance of the last half period from the limit, which differs by `change` from the
 * half period before; infinity as long as it is unknown. */
static double distance_by_halves(sm_progress *t, const sm_march *m, double change) {
    if (m->fine == 1) t->half_change = 0.0; /* the half period before is of the coarse grid */
    if (m->marches < 2 || m->fine == 1) return INFINITY;
    t->half_ratio = ratio_of(change, t->half_change, t->half_ratio);
    t->half_change = change;
    if (m->fine < 2 || m->marches < 3) return INFINITY; /* the first half period began at rest */
    const double distance = distance_from_limit(change, t->half_ratio);
    if (m->task->grid->lines == 1) return distance;
    /* The phases of the lines change relative to the steps, and the harmonics change by the
     * discretisation error, which does not converge. The result is the mean of two half periods,
     * not including the first one on the fine grid. */
    return m->fine < 3 ? INFINITY : fmax(distance, MEAN_DISTANCE * change);
}

/* Returns the smaller of `by_halves` and the distance from the limit by the last change over a
 * whole period. */
static double distance_by_periods(sm_progress *t, int marches, double change, double by_halves) {
    if (marches < 4 || by_halves <= 0.0) return by_halves; /* no mean of the period before */
    double *before = &t->change[marches % 2];
    const double ratio = ratio_of(change, *before, INITIAL_RATIO);
    *before = change;
    t->slow = ratio > SM_SLOW_RATIO;
    t->stalled = change < PROGRESS * t->best ? 0 : t->stalled + 1;
    t->best = fmin(t->best, change);
    return fmin(by_halves, distance_from_limit(change, ratio));
}

/* Replaces `values` of a half period by their mean with the half period `before`, and `before` by
 * `values`. */
static void mean_of_two(size_t count, double *values, double *before) {
    for (size_t k = 0; k < count; k++) {
        const double now = values[k];
        values[k] = 0.5 * (now + before[k]);
        before[k] = now;
    }
}

/* Adds values to the sum over the stalled half periods, or begins a new sum. */
static void add_stalled(const sm_progress *t, size_t count, const double *values, double *sum) {
    for (size_t k = 0; k < count; k++) sum[k] = values[k] + (t->stalled > 1 ? sum[k] : 0.0);
}

double sm_progress_next(sm_progress *t, const sm_march *m, const sm_scales *scales, double *Y,
                        double *square) {
    const size_t harmonics = sm_march_harmonics(m), n = (size_t)m->contact->contacts;
    const double tolerance = m->task->grid->tolerance;
    double *mean = t->mean[m->marches % 2];
    const double by_halves =
        distance_by_halves(t, m, sm_relative_distance(m, scales, Y, t->half));
    mean_of_two(harmonics, Y, t->half);
    mean_of_two(n, square, t->half_square);
    const double change = sm_relative_distance(m, scales, Y, mean);
    double residual = scales->motion == 0.0
                          ? 0.0 : distance_by_periods(t, m->marches, change, by_halves);
    t->done = residual <= tolerance || t->stalled >= STALLED_HALVES;
    memcpy(mean, Y, harmonics * sizeof(double));
    if (m->task->grid->lines == 1 && by_halves <= tolerance) {
        memcpy(Y, t->half, harmonics * sizeof(double));
        memcpy(square, t->half_square, n * sizeof(double));
    }
    add_stalled(t, harmonics, mean, t->sum);
    add_stalled(t, n, square, t->sum_square);
    if (!t->done || residual <= tolerance) return residual;
    for (size_t k = 0; k < harmonics; k++) Y[k] = t->sum[k] / t->stalled;
    for (size_t i = 0; i < n; i++) square[i] = t->sum_square[i] / t->stalled;
    return sm_relative_distance(m, scales, mean, Y);
}
