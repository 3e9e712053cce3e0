/* The search for periodic motion on the torus, eqs. (13), (14), for all laws; torus.c calls it.
 * Unknowns are the response R of the modes and, if contacts converge slowly, their memory. A march
 * under R gives harmonics Y and the next R = H Y + prescribed force. Weak responses to rigid
 * contacts are iterated with relaxation after each half period, others by Anderson's method. */
#include "torus/march.h"

#include <math.h>

#include "torus/periodic/fixed_point.h"
#include "torus/periodic/periodicity.h"

/* Residual below which the search is near a solution: the discretisation error is then removed by
 * means over several periods instead of another initial guess. */
#define NEAR_SOLUTION 1e-3
#define MOST_AVERAGED 16 /* periods of the longest mean */
/* Convergence tolerance for slider harmonics that are not requested, relative to `tolerance`, and
 * its upper bound. If a contact slips on few lines, these harmonics keep changing by the
 * discretisation error. The relaxed tolerance is not for contacts that open: these have several
 * periodic motions, and the search would stop between them. */
#define NOT_REQUESTED 32.0
#define NOT_REQUESTED_MOST 3e-3

/* Factors of the amplitudes in a continuation from rest, for points without convergence: contacts
 * stick at the first one, and the steps become shorter where more contacts slip. */
static const double AMPLITUDE_FACTORS[] = {0.3, 0.45, 0.6, 0.7, 0.8, 0.87, 0.94, 1.0};

/* The search at one point. */

typedef struct {
    sm_fixed_point fixed_point;
    double *Y, *last_Y; /* (orders, N_c, 2) harmonics of the last two evaluations */
    double *square;     /* (N_c) mean square of the motion */
    double *change;     /* (orders N_c 2 + memory) next unknowns less the present ones */
    sm_scales scales;
    sm_progress progress; /* convergence from half period to half period */
    double residual;
    int done, open;     /* done: periodic. open: not periodic, and the residual decreases */
} search_point;

/* The search at the points that are marched side by side. */
typedef struct {
    sm_march *march;
    search_point *point; /* (march->points) */
    size_t harmonics, unknowns; /* doubles of a point */
    int follows;         /* 1: the response at the previous point is the initial guess */
    int32_t steps;       /* time steps along each line so far */
} search;

/* Places the arrays of all points. */
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

/* Returns the unknowns of a point: the response R, then the memory. */
static double *response_of(const search *s, size_t p) {
    return s->march->response + p * s->unknowns;
}

/* Sets contacts and response to motion with harmonics Y, `stride` doubles from point to point; to
 * rest if Y is NULL. */
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

/* Marches through a number of periods under the same response: computes the harmonics and mean
 * squares of all points over these periods. */
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

/* Computes the residual of a point: the larger of the change of its harmonics since the previous
 * evaluation, relative to the motion due to the modes, and of the change of the response, relative
 * to the largest force (elastic contacts: displacement) of the modes. */
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
        scales.motion = fmax(scales.motion, fabs(point->Y[k])); /* slip beyond elastic motion */
    double largest = 0.0;
    for (size_t k = 0; k < s->harmonics; k++) {
        const int32_t *order = grid->orders + k / (2 * (size_t)m->contact->contacts) * 2;
        const double relative = fabs(point->Y[k] - point->last_Y[k]) / sm_scale_of(&scales, order);
        largest = fmax(largest, k < requested ? relative : others * relative);
    }
    point->residual = fmax(change / fmax(scales.response, SM_TINY), largest);
}

/* Copies harmonics, mean squares, residual and number of steps of a point into the results. */
static void store(const search *s, size_t p) {
    const sm_torus_motion *motion = s->march->task->motion;
    const size_t n = (size_t)s->march->contact->contacts, at = s->march->first + p;
    const search_point *point = &s->point[p];
    memcpy(motion->harmonics + at * s->harmonics, point->Y, s->harmonics * sizeof(double));
    memcpy(motion->mean_square + at * n, point->square, n * sizeof(double));
    motion->residual[at] = point->residual;
    motion->marched[at] = s->steps;
}

/* Tests a point for periodicity after a half period, stores it, and sets its next response by a
 * relaxed iteration. Returns whether the iteration continues. */
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

/* Tests a point for periodicity after an evaluation, stores it, and sets its next unknowns by
 * Anderson's acceleration. Returns whether the iteration continues. The `first` evaluation after
 * the start sets no unknowns. Results at reduced amplitudes are not stored. */
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
    const int decreases = sm_fixed_point_next(&point->fixed_point, point->residual, change,
                                              unknown);
    if (m->memory > 0) m->law->exchange_memory(m, unknown + s->harmonics, 1);
    return decreases;
}

/* Iterates with evaluations of `periods` periods, at the factor `part` of the amplitudes, until
 * each point is periodic or its residual stalls. */
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

/* Returns whether a point is not periodic and has at least this residual. */
static int any_open(const search *s, double residual) {
    for (size_t p = 0; p < s->march->count; p++)
        if (!s->point[p].done && s->point[p].residual >= residual) return 1;
    return 0;
}

/* Iterates from the initial guess of the caller or the previous point, then from the common one. */
static sm_status iterate_from_guesses(search *s) {
    const sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const double *guess = m->task->points->guess;
    sm_status status = SM_OK;
    if (guess)
        start(s, guess + m->first * s->harmonics, s->harmonics);
    else if (s->follows)
        m->law->start(s->march, NULL);
    if (guess || s->follows) status = iterate(s, 1, 1.0);
    if (status != SM_OK || !any_open(s, NEAR_SOLUTION)) return status;
    start(s, response ? response->start : NULL, 0);
    return iterate(s, 1, 1.0);
}

/* Continues the points from small amplitudes, at which the contacts stick, to their amplitudes. */
static sm_status continue_from_rest(search *s) {
    sm_status status = SM_OK;
    double reached = INFINITY;
    for (size_t k = 0; k < sizeof AMPLITUDE_FACTORS / sizeof(double) && status == SM_OK; k++) {
        const double part = AMPLITUDE_FACTORS[k];
        for (size_t p = 0; p < s->march->count; p++)
            for (size_t i = 0; i < s->harmonics && !s->point[p].done; i++)
                response_of(s, p)[i] *= part / reached;
        status = iterate(s, 1, part);
        reached = part;
    }
    return status;
}

/* Finds the periodic motion at the points of the march: with half periods first, then with whole
 * periods, a continuation from rest, and means over several periods. */
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
    if (status == SM_OK && any_open(s, NEAR_SOLUTION) && !at_start) status = continue_from_rest(s);
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

/* Finds the periodic motion at all points of the task, one group after the other. */
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
        s->follows = m->contact->law == SM_ELASTIC && !any_open(s, NEAR_SOLUTION)
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
