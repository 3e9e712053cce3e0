#include "torus/periodic/periodicity.h"

#include <math.h>

/* Half periods without progress after which a change is put down to the discretisation: phases
 * drift from period to period, so the harmonics of a coarse grid keep moving by its error. */
#define IDLE_HALVES 80
#define PROGRESS 0.8
#define UNKNOWN 0.9 /* ratio of successive changes before there are two */

void sm_progress_start(sm_progress *progress) {
    sm_progress_restart(progress);
    progress->best = INFINITY;
    progress->stalled = 0;
    progress->slow = 0;
    progress->done = 0;
}

void sm_progress_restart(sm_progress *progress) {
    progress->change[0] = progress->change[1] = progress->turn = 0.0;
    progress->ratio = UNKNOWN;
}

void sm_progress_other_grid(sm_progress *progress) { progress->turn = 0.0; }

sm_scales sm_scales_at(const sm_contact *contact, const double *amplitude,
                       const double *smallest_scale) {
    const size_t n = (size_t)contact->contacts;
    const int elastic = contact->law == SM_ELASTIC;
    sm_scales scales = {{0.0, 0.0}, 0.0, 0.0};
    for (int j = 0; j < contact->modes; j++) {
        const double a = fmax(amplitude[j], smallest_scale[j]);
        double motion = 0.0;
        for (size_t i = 0; i < n; i++) {
            const double *L = contact->coupling + 2 * ((size_t)j * n + i);
            const double force = (elastic ? 1.0 : 2.0) * hypot(L[0], L[1]) * a;
            motion = fmax(motion, elastic ? force * contact->elastic->reference[i]
                                          : force / contact->stiffness[i * n + i]);
            scales.response = fmax(scales.response, force);
        }
        scales.of_mode[j] = elastic ? 0.0 : motion;
        scales.motion = fmax(scales.motion, motion);
    }
    return scales;
}

/* A mode's own harmonics are measured by its own displacement, or they would be lost next to a
 * much stronger mode; mixed harmonics, and those of a mode at rest, by the largest. */
double sm_scale_of(const sm_scales *scales, const int32_t *order) {
    const double own = order[1] == 0   ? scales->of_mode[0]
                       : order[0] == 0 ? scales->of_mode[1]
                                       : 0.0;
    return own > 0.0 ? own : fmax(scales->motion, 1e-300);
}

double sm_relative_distance(const sm_scales *scales, int contacts, int orders_count,
                            const int32_t *orders, const double *one, const double *other) {
    double largest = 0.0;
    for (int q = 0; q < orders_count && scales->motion > 0.0; q++) {
        const double scale = sm_scale_of(scales, orders + 2 * q);
        for (int k = 2 * contacts * q; k < 2 * contacts * (q + 1); k++)
            largest = fmax(largest, fabs(one[k] - other[k]) / scale);
    }
    return largest;
}

static double ratio_of(double now, double before, double unknown) {
    return before > 0.0 ? fmin(fmax(now / before, 0.3), 0.97) : unknown;
}

/* The changes to come, as a geometric series. */
static double to_come(double now, double ratio) { return now * ratio / (1.0 - ratio); }

double sm_distance_by_halves(sm_progress *progress, double turn) {
    progress->ratio = ratio_of(turn, progress->turn, progress->ratio);
    progress->turn = turn;
    return to_come(turn, progress->ratio);
}

double sm_distance_from_periodic(sm_progress *progress, const sm_scales *scales, double change,
                                 double by_halves, int halves, double tolerance) {
    double distance = scales->motion == 0.0 ? 0.0 : by_halves;
    if (halves >= 4 && distance > 0.0) { /* the first whole period ended after two */
        double *before = &progress->change[halves % 2];
        const double ratio = ratio_of(change, *before, UNKNOWN);
        distance = fmin(distance, to_come(change, ratio));
        *before = change;
        progress->slow = ratio > SM_SLOW_RATIO;
        progress->stalled = change < PROGRESS * progress->best ? 0 : progress->stalled + 1;
        progress->best = fmin(progress->best, change);
    }
    progress->done = distance <= tolerance || progress->stalled >= IDLE_HALVES;
    return distance;
}
