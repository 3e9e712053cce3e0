/* Periodic contact motion on the torus, eqs. (13), (14), by characteristics; called by Python.
 *
 * Along t_B = t_B0 + (omega_B / omega_A) t_A, eq. (13) is an ordinary differential equation. Phase
 * lines with t_B0 = 2 pi p / lines are marched side by side until the motion repeats. P_nm is the
 * mean of x exp(-i (n t_A + m t_B)) over all steps and lines. Unknowns are the response R of the
 * modes and, if contacts converge slowly, their memory. A march under R gives harmonics Y and the
 * next R = H Y + prescribed force. Weak responses to rigid contacts are iterated with relaxation
 * after each half period, others by Anderson's method. */
#include "torus/periodic/point.h"

/* Residual below which the search is near a solution: the discretisation error is then removed by
 * means over several periods instead of another initial guess. */
#define NEAR_SOLUTION 1e-3
#define MOST_AVERAGED 16 /* periods of the longest mean */

/* Factors of the amplitudes in a continuation from rest, for points without convergence: contacts
 * stick at the first one, and the steps become shorter where more contacts slip. */
static const double AMPLITUDE_FACTORS[] = {0.3, 0.45, 0.6, 0.7, 0.8, 0.87, 0.94, 1.0};

/* Places the arrays of all points. */
static void place(const sm_search *s, sm_block *block) {
    const size_t n = (size_t)s->march->contact->contacts;
    for (size_t p = 0; p < s->march->points; p++) {
        sm_search_point *point = &s->point[p];
        if (s->march->plain)
            sm_progress_place(&point->progress, s->harmonics, n, block);
        else
            sm_fixed_point_place(&point->fixed_point, s->unknowns, block);
        SM_TAKE_EACH(block, s->harmonics, &point->Y, &point->last_Y);
        point->square = sm_take(block, n);
        point->change = sm_take(block, s->unknowns);
    }
}

/* Sets contacts and response to motion with harmonics Y, `stride` doubles from point to point; to
 * rest if Y is NULL. */
static void start(sm_search *s, const double *Y, size_t stride) {
    const sm_march *m = s->march;
    m->law->start(s->march, Y);
    for (size_t p = 0; p < m->count; p++) {
        sm_search_point *point = &s->point[p];
        if (Y)
            memcpy(point->Y, Y + p * stride, s->harmonics * sizeof(double));
        else
            memset(point->Y, 0, s->harmonics * sizeof(double));
        memset(sm_search_unknowns(s, p), 0, s->harmonics * sizeof(double));
        if ((Y || m->plain) && m->contact->response)
            sm_respond(m->contact, point->Y, sm_search_unknowns(s, p));
        if (m->plain)
            sm_progress_start(&point->progress, s->harmonics, (size_t)m->contact->contacts);
    }
}

/* Marches through a number of periods under the same response: computes the harmonics and mean
 * squares of all points over these periods. */
static sm_status evaluate(sm_search *s, int periods) {
    const sm_march *m = s->march;
    const size_t n = (size_t)m->contact->contacts;
    for (size_t p = 0; p < m->count; p++) {
        sm_search_point *point = &s->point[p];
        memcpy(point->last_Y, point->Y, s->harmonics * sizeof(double));
        memset(point->Y, 0, s->harmonics * sizeof(double));
        memset(point->square, 0, n * sizeof(double));
    }
    for (int k = 0; k < periods; k++) {
        SM_TRY(m->law->period(s->march));
        s->steps += m->steps;
        for (size_t p = 0; p < m->count; p++) {
            sm_search_point *point = &s->point[p];
            const double *Y = m->Y + p * s->harmonics, *square = m->square + p * n;
            for (size_t i = 0; i < s->harmonics; i++) point->Y[i] += Y[i] / periods;
            for (size_t i = 0; i < n; i++) point->square[i] += square[i] / periods;
        }
    }
    return SM_OK;
}

/* Marches rigid contacts by half periods until each point is periodic. */
static sm_status iterate_by_halves(sm_search *s) {
    sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const size_t n = (size_t)m->contact->contacts;
    int open = 1;
    start(s, response ? response->start : NULL, 0);
    for (int marches = 0; open && marches < 2 * m->task->grid->max_periods; marches++) {
        SM_TRY(m->law->period(m));
        s->steps += m->steps;
        open = 0;
        for (size_t p = 0; p < m->count; p++) {
            sm_search_point *point = &s->point[p];
            if (point->done) continue;
            memcpy(point->Y, m->Y + p * s->harmonics, s->harmonics * sizeof(double));
            memcpy(point->square, m->square + p * n, n * sizeof(double));
            open |= sm_search_next_half(s, p);
        }
    }
    return SM_OK;
}

/* Iterates with evaluations of `periods` periods, at the factor `part` of the amplitudes, until
 * each point is periodic or its residual stalls. */
static sm_status iterate(sm_search *s, int periods, double part) {
    sm_march *m = s->march;
    m->part = part;
    for (size_t p = 0; p < m->count; p++) {
        sm_fixed_point_start(&s->point[p].fixed_point);
        s->point[p].open = !s->point[p].done;
    }
    int open = 1;
    for (int marches = 0; open && marches < m->task->grid->max_periods; marches += periods) {
        const int first = s->steps == 0;
        if (m->memory > 0) m->law->exchange_memory(m, m->response + s->harmonics, 0);
        SM_TRY(evaluate(s, periods));
        open = 0;
        for (size_t p = 0; p < m->count; p++) {
            sm_search_point *point = &s->point[p];
            if (point->open) point->open = sm_search_next(s, p, first);
            open |= point->open;
        }
    }
    return SM_OK;
}

/* Returns whether a point is not periodic and has at least this residual. */
static int any_open(const sm_search *s, double residual) {
    for (size_t p = 0; p < s->march->count; p++)
        if (!s->point[p].done && s->point[p].residual >= residual) return 1;
    return 0;
}

/* Iterates from the initial guess of the caller or the previous point, then from the common one. */
static sm_status iterate_from_guesses(sm_search *s) {
    const sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const double *guess = m->task->points->guess;
    sm_status status = SM_OK;
    if (guess)
        start(s, guess + m->first * s->harmonics, s->harmonics);
    else if (s->follows)
        m->law->start(s->march, NULL);
    if (guess || s->follows) status = iterate(s, m->settling, 1.0);
    if (status != SM_OK || !any_open(s, NEAR_SOLUTION)) return status;
    start(s, response ? response->start : NULL, 0);
    return iterate(s, m->settling, 1.0);
}

/* Continues the points from small amplitudes, at which the contacts stick, to their amplitudes. */
static sm_status continue_from_rest(sm_search *s) {
    sm_status status = SM_OK;
    double reached = INFINITY;
    for (size_t k = 0; k < sizeof AMPLITUDE_FACTORS / sizeof(double) && status == SM_OK; k++) {
        const double part = AMPLITUDE_FACTORS[k];
        for (size_t p = 0; p < s->march->count; p++)
            for (size_t i = 0; i < s->harmonics && !s->point[p].done; i++)
                sm_search_unknowns(s, p)[i] *= part / reached;
        status = iterate(s, s->march->settling, part);
        reached = part;
    }
    return status;
}

/* Finds the periodic motion at the points of the march: with half periods first, then with whole
 * periods, a continuation from rest, and means over several periods. */
static sm_status solve(sm_search *s) {
    sm_march *m = s->march;
    const sm_modal_response *response = m->contact->response;
    const int has_start = response && response->start;
    sm_status status;
    if (m->law->by_halves(m, 1)) {
        status = iterate_from_guesses(s);
        if (status != SM_OK || !any_open(s, 0.0)) return status;
        m->law->by_halves(m, 0);
    }
    status = iterate_from_guesses(s);
    if (status == SM_OK && any_open(s, NEAR_SOLUTION) && !has_start) status = continue_from_rest(s);
    for (int periods = 4 * m->settling; periods <= MOST_AVERAGED && status == SM_OK; periods *= 4)
        if (any_open(s, 0.0)) status = iterate(s, periods, 1.0);
    if (status != SM_OK || !any_open(s, 0.0)) return status;
    status = evaluate(s, MOST_AVERAGED);
    for (size_t p = 0; p < m->count && status == SM_OK; p++) {
        if (s->point[p].done) continue;
        sm_search_residual(s, p);
        sm_search_store(s, p);
    }
    return status;
}

/* Prepares the search at the next points of the task. */
static void begin_group(sm_search *s) {
    sm_march *m = s->march;
    const size_t left = m->task->points->count - m->first;
    m->count = left < m->points ? left : m->points;
    s->steps = 0;
    for (size_t p = 0; p < m->count; p++) {
        s->point[p].residual = INFINITY;
        s->point[p].done = 0;
        s->point[p].scales = sm_scales_at(m->contact, sm_march_amplitudes(m, p),
                                          m->task->grid->smallest_scale);
    }
}

/* Allocates the points and their arrays. */
static sm_status allocate(sm_search *s) {
    sm_block block = {NULL, 0};
    s->point = calloc(s->march->points, sizeof *s->point);
    if (!s->point) return SM_NO_MEMORY;
    place(s, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    s->memory = block.memory;
    place(s, &block);
    return SM_OK;
}

sm_status sm_torus_harmonics(const sm_contact *contact, const sm_discretisation *grid,
                             const sm_torus_points *points, const sm_torus_motion *motion) {
    const sm_torus_task task = {grid, points, motion};
    SM_TRY(sm_torus_check_task(contact, &task));
    sm_march m = {.contact = contact, .task = &task, .part = 1.0};
    sm_status status = contact->law == SM_ELASTIC ? sm_elastic_make(&m) : sm_rigid_make(&m);
    sm_search s = {.march = &m, .harmonics = sm_march_harmonics(&m)};
    s.unknowns = s.harmonics + m.memory;
    if (status == SM_OK) m.law->by_halves(&m, 1);
    if (status == SM_OK) status = allocate(&s);
    for (; status == SM_OK && m.first < points->count; m.first += m.points) {
        begin_group(&s);
        status = m.plain ? iterate_by_halves(&s) : solve(&s);
        s.follows = contact->law == SM_ELASTIC && !any_open(&s, NEAR_SOLUTION)
                    && !(contact->response && contact->response->start);
    }
    free(s.memory);
    free(s.point);
    m.law->release(&m);
    return status;
}
