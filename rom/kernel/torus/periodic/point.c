/* Residual, result and next iterate of the search for periodic motion at one point. See the header.
 */
#include "torus/periodic/point.h"

#include <math.h>

#include "base/check.h"

/* Convergence tolerance for slider harmonics that are not requested, relative to `tolerance`, and
 * its upper bound. If a contact slips on few lines, these harmonics keep changing by the
 * discretisation error. The relaxed tolerance is not for contacts that open: these have several
 * periodic motions, and the search would stop between them. */
#define NOT_REQUESTED 32.0
#define NOT_REQUESTED_MOST 3e-3

/* Returns the largest change of the harmonics of a point since the previous evaluation, relative to
 * the motion due to the modes. */
static double harmonics_change(const sm_search *s, const sm_search_point *point) {
    const sm_march *m = s->march;
    const sm_discretisation *grid = m->task->grid;
    const size_t requested = 2 * m->requested * (size_t)m->contact->contacts;
    const double least = grid->tolerance / NOT_REQUESTED_MOST;
    const double others = fmin(fmax(1.0 / NOT_REQUESTED, least), 1.0);
    sm_scales scales = point->scales;
    for (size_t k = 0; k < s->harmonics && m->contact->law == SM_ELASTIC; k++)
        scales.motion = fmax(scales.motion, fabs(point->Y[k])); /* slip beyond elastic motion */
    double largest = 0.0;
    for (size_t k = 0; k < s->harmonics; k++) {
        const int32_t *order = grid->orders + k / (2 * (size_t)m->contact->contacts) * 2;
        const double relative = fabs(point->Y[k] - point->last_Y[k]) / sm_scale_of(&scales, order);
        largest = fmax(largest, k < requested ? relative : others * relative);
    }
    return largest;
}

double sm_search_residual(const sm_search *s, size_t p) {
    sm_march *m = s->march;
    sm_search_point *point = &s->point[p];
    const double scale = fmax(point->scales.response, SM_TINY);
    double of_response = 0.0, of_memory = 0.0;
    if (m->contact->response) {
        sm_respond(m->contact, point->Y, point->change);
        for (size_t k = 0; k < s->harmonics; k++) point->change[k] -= sm_search_unknowns(s, p)[k];
        for (size_t k = 0; k < s->harmonics; k += 2)
            of_response = fmax(of_response, hypot(point->change[k], point->change[k + 1]) / scale);
    }
    if (m->memory > 0) m->law->exchange_memory(m, point->change + s->harmonics, 0);
    for (size_t k = s->harmonics; k < s->unknowns; k++) {
        point->change[k] -= sm_search_unknowns(s, p)[k];
        of_memory = fmax(of_memory, fabs(point->change[k]) / scale);
    }
    const double of_harmonics = harmonics_change(s, point);
    point->residual = fmax(of_response, of_harmonics);
    if (m->memory == 0) return point->residual;
    point->residual = fmax(of_response, fmin(of_memory, of_harmonics));
    return fmax(of_response, of_memory);
}

void sm_search_store(const sm_search *s, size_t p) {
    const sm_torus_motion *motion = s->march->task->motion;
    const size_t n = (size_t)s->march->contact->contacts, at = s->march->first + p;
    const sm_search_point *point = &s->point[p];
    memcpy(motion->harmonics + at * s->harmonics, point->Y, s->harmonics * sizeof(double));
    memcpy(motion->mean_square + at * n, point->square, n * sizeof(double));
    motion->residual[at] = point->residual;
    motion->marched[at] = s->steps;
}

int sm_search_next_half(const sm_search *s, size_t p) {
    sm_march *m = s->march;
    sm_search_point *point = &s->point[p];
    sm_progress *progress = &point->progress;
    const size_t each = 2 * (size_t)m->contact->contacts;
    double *R = sm_search_unknowns(s, p);
    point->residual = sm_progress_next(progress, m, &point->scales, point->Y, point->square);
    point->done = progress->done;
    sm_search_store(s, p);
    if (m->marches % 2 == 0 && !point->done && m->law->extrapolate(m, p, progress->slow))
        sm_progress_restart(progress);
    if (m->contact->response) {
        sm_respond(m->contact, progress->mean[m->marches % 2], point->change);
        for (size_t k = 0; k < s->harmonics; k++)
            R[k] += m->relaxation[k / each] * (point->change[k] - R[k]);
    }
    return !point->done;
}

int sm_search_next(const sm_search *s, size_t p, int first) {
    sm_march *m = s->march;
    sm_search_point *point = &s->point[p];
    double *unknown = sm_search_unknowns(s, p), *change = point->change;
    const double distance = sm_search_residual(s, p);
    const int repeats = !first && point->residual <= m->task->grid->tolerance;
    if (m->part == 1.0) {
        point->done = repeats;
        sm_search_store(s, p);
    }
    if (repeats || first) return first;
    const int decreases = sm_fixed_point_next(&point->fixed_point, distance, change, unknown);
    if (m->memory > 0) m->law->exchange_memory(m, unknown + s->harmonics, 1);
    return decreases;
}
