/* The search for periodic motion, of all contact laws.
 *
 * The unknowns of a point are the response R of the modes and, where the contacts forget slowly,
 * their memory at the start of a period. A march under R gives harmonics Y of the motion, and
 * these the next response H Y + held. Where the modes respond weakly to rigid contacts, it takes
 * (a part of) that change after every half period: see periodicity.c. Else Anderson's acceleration
 * combines several changes, and where the harmonics keep changing by the error of the grid, Y is
 * the mean over several periods.
 */
#include "torus/march.h"

#include <math.h>

#include "torus/periodic/fixed_point.h"
#include "torus/periodic/periodicity.h"

#define ALMOST 1e-3 /* residual below which means over several periods replace single ones */
#define MOST_AVERAGED 16 /* periods of such a mean */
/* Convergence tolerance for slider harmonics that are not requested, relative to `tolerance`, and
 * its bound: where a contact slips on few lines, they keep changing by the error of the grid. Not
 * for contacts that open: they have several motions, and the search would stop between them. */
#define NOT_REQUESTED 32.0
#define NOT_REQUESTED_MOST 3e-3

/* Parts of the amplitudes through which points that do not converge are continued from rest. */
static const double PARTS[] = {0.3, 0.45, 0.6, 0.7, 0.8, 0.87, 0.94, 1.0};

typedef struct {
    sm_fixed_point fixed_point;
    double *Y, *last_Y; /* (orders, N_c, 2) harmonics of this evaluation and of the one before */
    double *square;     /* (N_c) mean square */
    double *change;     /* (orders N_c 2 + memory) next unknowns less these */
    sm_scales scales;
    sm_progress progress; /* of half periods */
    double residual;
    int done, open;     /* it is periodic; it is not, and the residual falls */
} search_point;

typedef struct {
    sm_march *march;
    search_point *point; /* (march->points) */
    size_t harmonics, unknowns; /* doubles of a point */
    int follows;         /* the response at the point before is an initial guess */
    int32_t steps;       /* marched along each line */
} search;

static void place(const search *s, sm_block *block) {
    const size_t n = (size_t)s->march->contact->contacts;
    for (size_t p = 0; p < s->march->points; p++) {
        search_point *point = &s->point[p];
        if (s->march->plain)
            sm_progress_place(&point->progress, s->harmonics, n, block);
        else
            sm_fixed_point_place(&point->fixed_point, s->unknowns, block);
        point->Y = sm_take(block, s->harmonics);
        point->last_Y = sm_take(block, s->harmonics);
        point->square = sm_take(block, n);
        point->change = sm_take(block, s->unknowns);
    }
}

static double *response_of(const search *s, size_t p) {
    return s->march->response + p * s->unknowns;
}

/* Contacts at rest without a response, or both as in motion with harmonics Y, `stride` doubles
 * from point to point. */
static void start(search *s, const double *Y, size_t stride) {
    const sm_march *m = s->march;
    m->law->start(s->march, Y);
    for (size_t p = 0; p < m->count; p++) {
        search_point *point = &s->point[p];
        if (Y)
            memcpy(point->Y, Y + p * stride, s->harmonics * sizeof(double));
        else
            memset(point->Y, 0, s->harmonics * sizeof(double));
        memset(response_of(s, p), 0, s->harmonics * sizeof(double));
        if ((Y || m->plain) && m->contact->response)
            sm_respond(m->contact, point->Y, response_of(s, p));
        if (m->plain)
            sm_progress_start(&point->progress, s->harmonics, (size_t)m->contact->contacts);
    }
}

/* Harmonics and mean squares of all points over so many periods, under the same response. */
static sm_status evaluate(search *s, int periods) {
    const sm_march *m = s->march;
    const size_t n = (size_t)m->contact->contacts;
    for (size_t p = 0; p < m->count; p++) {
        search_point *point = &s->point[p];
        memcpy(point->last_Y, point->Y, s->harmonics * sizeof(double));
        memset(point->Y, 0, s->harmonics * sizeof(double));
        memset(point->square, 0, n * sizeof(double));
    }
    for (int k = 0; k < periods; k++) {
        const sm_status status = m->law->period(s->march);
        if (status != SM_OK) return status;
        s->steps += m->steps;
        for (size_t p = 0; p < m->count; p++) {
            search_point *point = &s->point[p];
            const double *Y = m->Y + p * s->harmonics, *square = m->square + p * n;
            for (size_t i = 0; i < s->harmonics; i++) point->Y[i] += Y[i] / periods;
            for (size_t i = 0; i < n; i++) point->square[i] += square[i] / periods;
        }
    }
    return SM_OK;
}

/* The residual of a point: the change of its harmonics from the evaluation before, relative to the
 * motion that the modes cause, and of the response, relative to their largest force or
 * displacement. */
static void find_residual(const search *s, size_t p) {
    const sm_march *m = s->march;
    search_point *point = &s->point[p];
    const sm_discretisation *grid = m->task->grid;
    const size_t requested = 2 * m->requested * (size_t)m->contact->contacts;
    const double least = grid->tolerance / NOT_REQUESTED_MOST;
    const double others = fmin(fmax(1.0 / NOT_REQUESTED, least), 1.0);
    double change = 0.0;
    if (m->contact->response) {
        sm_respond(m->contact, point->Y, point->change);
        for (size_t k = 0; k < s->harmonics; k++) point->change[k] -= response_of(s, p)[k];
        for (size_t k = 0; k < s->harmonics; k += 2)
            change = fmax(change, hypot(point->change[k], point->change[k + 1]));
    }
    sm_scales scales = point->scales;
    for (size_t k = 0; k < s->harmonics && m->contact->law == SM_ELASTIC; k++)
        scales.motion = fmax(scales.motion, fabs(point->Y[k])); /* they slide far */
    double moved = 0.0;
    for (size_t k = 0; k < s->harmonics; k++) {
        const int32_t *order = grid->orders + k / (2 * (size_t)m->contact->contacts) * 2;
        const double off = fabs(point->Y[k] - point->last_Y[k]) / sm_scale_of(&scales, order);
        moved = fmax(moved, k < requested ? off : others * off);
    }
    point->residual = fmax(change / fmax(scales.response, 1e-300), moved);
}

static void store(const search *s, size_t p) {
    const sm_torus_motion *motion = s->march->task->motion;
    const size_t n = (size_t)s->march->contact->contacts, at = s->march->first + p;
    const search_point *point = &s->point[p];
    memcpy(motion->harmonics + at * s->harmonics, point->Y, s->harmonics * sizeof(double));
    memcpy(motion->mean_square + at * n, point->square, n * sizeof(double));
    motion->residual[at] = point->residual;
    motion->marched[at] = s->steps;
}

/* After a half period by plain iterations: tests a point for periodicity, stores it and sets its
 * next response. Returns whether it goes on. */
static int next_half(const search *s, size_t p) {
    sm_march *m = s->march;
    search_point *point = &s->point[p];
    sm_progress *progress = &point->progress;
    const size_t each = 2 * (size_t)m->contact->contacts;
    double *R = response_of(s, p);
    point->residual = sm_progress_next(progress, m, &point->scales, point->Y, point->square);
    point->done = progress->done;
    store(s, p);
    if (m->marches % 2 == 0 && !point->done && m->law->extrapolate(m, p, progress->slow))
        sm_progress_restart(progress);
    if (m->contact->response) {
        sm_respond(m->contact, progress->mean[m->marches % 2], point->change);
        for (size_t k = 0; k < s->harmonics; k++)
            R[k] += m->relaxation[k / each] * (point->change[k] - R[k]);
    }
    return !point->done;
}

/* The same after an evaluation, by Anderson's acceleration. `first`: it only forgets the start. At
 * a part of the amplitudes the result is an initial guess for a larger part. */
static int next_iterate(const search *s, size_t p, int first) {
    sm_march *m = s->march;
    search_point *point = &s->point[p];
    double *unknown = response_of(s, p), *change = point->change;
    find_residual(s, p);
    const int repeats = !first && point->residual <= m->task->grid->tolerance;
    if (m->part == 1.0) {
        point->done = repeats;
        store(s, p);
    }
    if (repeats || first) return first;
    if (m->memory > 0) m->law->exchange_memory(m, change + s->harmonics, 0);
    for (size_t k = s->harmonics; k < s->unknowns; k++) change[k] -= unknown[k];
    const int falls = sm_fixed_point_next(&point->fixed_point, point->residual, change, unknown);
    if (m->memory > 0) m->law->exchange_memory(m, unknown + s->harmonics, 1);
    return falls;
}

/* Iterates evaluations of so many periods, at a part of the amplitudes, until every point repeats
 * or its residual stops falling. */
static sm_status iterate(search *s, int periods, double part) {
    sm_march *m = s->march;
    const int most = (m->plain ? 2 : 1) * m->task->grid->max_periods;
    m->part = part;
    for (size_t p = 0; p < m->count; p++) {
        sm_fixed_point_start(&s->point[p].fixed_point);
        s->point[p].open = !s->point[p].done;
    }
    int open = 1;
    for (int marches = 0; open && marches < most; marches += periods) {
        const int first = s->steps == 0;
        if (m->memory > 0) m->law->exchange_memory(m, m->response + s->harmonics, 0);
        const sm_status status = evaluate(s, periods);
        if (status != SM_OK) return status;
        open = 0;
        for (size_t p = 0; p < m->count; p++) {
            search_point *point = &s->point[p];
            if (point->open) point->open = m->plain ? next_half(s, p) : next_iterate(s, p, first);
            open |= point->open;
        }
    }
    return SM_OK;
}

/* Whether any point is not done, with at least this residual. */
static int any_open(const search *s, double residual) {
    for (size_t p = 0; p < s->march->count; p++)
        if (!s->point[p].done && s->point[p].residual >= residual) return 1;
    return 0;
}

/* Iterates from the caller's initial guess or the point before, then from the common start. */
static sm_status iterate_from_guesses(search *s) {
    const sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const double *near = m->task->points->near;
    sm_status status = SM_OK;
    if (near)
        start(s, near + m->first * s->harmonics, s->harmonics);
    else if (s->follows)
        m->law->start(s->march, NULL);
    if (near || s->follows) status = iterate(s, 1, 1.0);
    if (status != SM_OK || !any_open(s, ALMOST)) return status;
    start(s, response ? response->start : NULL, 0);
    return iterate(s, 1, 1.0);
}

/* Continues the points from small amplitudes, at which the contacts stick, to their own. */
static sm_status continue_from_rest(search *s) {
    sm_status status = SM_OK;
    double reached = INFINITY;
    for (size_t k = 0; k < sizeof PARTS / sizeof *PARTS && status == SM_OK; k++) {
        for (size_t p = 0; p < s->march->count; p++)
            for (size_t i = 0; i < s->harmonics && !s->point[p].done; i++)
                response_of(s, p)[i] *= PARTS[k] / reached;
        status = iterate(s, 1, PARTS[k]);
        reached = PARTS[k];
    }
    return status;
}

/* Solves the points of the march; half periods are tried first. */
static sm_status solve(search *s) {
    sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const double *at_start = response ? response->start : NULL;
    sm_status status;
    if (m->law->by_halves(m, 1)) {
        if (m->plain) {
            start(s, at_start, 0);
            return iterate(s, 1, 1.0);
        }
        status = iterate_from_guesses(s);
        if (status != SM_OK || !any_open(s, 0.0)) return status;
        m->law->by_halves(m, 0);
    }
    status = iterate_from_guesses(s);
    if (status == SM_OK && any_open(s, ALMOST) && !at_start) status = continue_from_rest(s);
    for (int periods = 4; periods <= MOST_AVERAGED && status == SM_OK; periods *= 4)
        if (any_open(s, 0.0)) status = iterate(s, periods, 1.0);
    if (status != SM_OK || !any_open(s, 0.0)) return status;
    status = evaluate(s, MOST_AVERAGED);
    for (size_t p = 0; p < m->count && status == SM_OK; p++) {
        if (s->point[p].done) continue;
        find_residual(s, p);
        store(s, p);
    }
    return status;
}

static sm_status solve_all(search *s) {
    sm_march *m = s->march;
    const sm_torus_task *task = m->task;
    const sm_modal_response *response = m->contact->response;
    for (m->first = 0; m->first < task->points->count; m->first += m->points) {
        const size_t left = task->points->count - m->first;
        m->count = left < m->points ? left : m->points;
        s->steps = 0;
        for (size_t p = 0; p < m->count; p++) {
            s->point[p].residual = INFINITY;
            s->point[p].done = 0;
            s->point[p].scales = sm_scales_at(m->contact, sm_march_amplitudes(m, p),
                                              task->grid->smallest_scale);
        }
        const sm_status status = solve(s);
        if (status != SM_OK) return status;
        s->follows = m->contact->law == SM_ELASTIC && !any_open(s, ALMOST)
                     && !(response && response->start);
    }
    return SM_OK;
}

sm_status sm_torus_search(sm_march *m) {
    m->law->by_halves(m, 1);
    search s = {.march = m, .harmonics = sm_march_harmonics(m),
                .unknowns = sm_march_harmonics(m) + m->memory,
                .point = calloc(m->points, sizeof(search_point))};
    sm_block block = {NULL, 0};
    if (s.point) place(&s, &block);
    sm_status status = s.point && sm_allocate(&block) ? SM_OK : SM_NO_MEMORY;
    if (status == SM_OK) {
        place(&s, &block);
        status = solve_all(&s);
    }
    free(block.memory);
    free(s.point);
    return status;
}
