#include "torus/periodic/periodicity.h"

#include <math.h>

#define DRIFT 2.0 /* times the difference of two half periods: the distance of their mean, at most */
#define IDLE_HALVES 80 /* without progress, after which changes are put down to the grid */
#define PROGRESS 0.8
#define SLOW_RATIO 0.5 /* of successive changes, from which marching alone takes too long */
#define UNKNOWN 0.9 /* ratio of successive changes before there are two */

void sm_progress_place(sm_progress *t, size_t harmonics, size_t contacts, sm_block *block) {
    double **of_harmonics[] = {&t->half, &t->mean[0], &t->mean[1], &t->sum};
    for (size_t k = 0; k < sizeof of_harmonics / sizeof *of_harmonics; k++)
        *of_harmonics[k] = sm_take(block, harmonics);
    t->half_square = sm_take(block, contacts);
    t->sum_square = sm_take(block, contacts);
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
    t->half_ratio = UNKNOWN;
}

static double ratio_of(double now, double before, double unknown) {
    return before > 0.0 ? fmin(fmax(now / before, 0.3), 0.97) : unknown;
}

/* The changes to come, as a geometric series. */
static double to_come(double now, double ratio) { return now * ratio / (1.0 - ratio); }

/* Distance of the last half period from those to come, which differs by `change` from the half
 * before. */
static double distance_by_halves(sm_progress *t, const sm_march *m, double change) {
    if (m->fine == 1) t->half_change = 0.0; /* the half before is of another grid */
    if (m->marches < 2 || m->fine == 1) return INFINITY;
    t->half_ratio = ratio_of(change, t->half_change, t->half_ratio);
    t->half_change = change;
    if (m->fine < 2 || m->marches < 3) return INFINITY; /* the first half began at rest */
    const double distance = to_come(change, t->half_ratio);
    if (m->task->grid->lines == 1) return distance;
    /* lines drift against the grid, and harmonics move by its error, which does not fall: the mean
     * of two halves counts, the earlier of them not that after another grid */
    return m->fine < 3 ? INFINITY : fmax(distance, DRIFT * change);
}

/* The smaller of `by_halves` and the distance by the last change over a whole period. */
static double distance_by_periods(sm_progress *t, int marches, double change, double by_halves) {
    if (marches < 4 || by_halves <= 0.0) return by_halves; /* the first whole period ended after two */
    double *before = &t->change[marches % 2];
    const double ratio = ratio_of(change, *before, UNKNOWN);
    *before = change;
    t->slow = ratio > SLOW_RATIO;
    t->stalled = change < PROGRESS * t->best ? 0 : t->stalled + 1;
    t->best = fmin(t->best, change);
    return fmin(by_halves, to_come(change, ratio));
}

/* values = mean of themselves and of those of the half before, which they replace. */
static void mean_of_two(size_t count, double *values, double *before) {
    for (size_t k = 0; k < count; k++) {
        const double now = values[k];
        values[k] = 0.5 * (now + before[k]);
        before[k] = now;
    }
}

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
    t->done = residual <= tolerance || t->stalled >= IDLE_HALVES;
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
