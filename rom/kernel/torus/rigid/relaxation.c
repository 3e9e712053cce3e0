/* Periodic motion of rigid contacts, half period by half period.
 *
 * Friction is odd: half a period repeats the one before with opposite sign, but where contacts that
 * stick are off the middle. After every half its harmonics are compared with those of the half
 * before, and those of the last whole period with those a period before; the march ends when either
 * repeats. The modes respond to each half in the next, with a part of the change where their response
 * is large. Displacements of contacts that stick are extrapolated (acceleration.h).
 */
#include <math.h>
#include <string.h>

#include "torus/rigid/group.h"

#define COARSE_HALVES 3 /* marched in larger steps: a half to forget the start, and a whole period */
#define DRIFT 2.0 /* times the difference of two half periods: the distance of their mean, at most */
#define SOFTEST 0.5 /* relaxation below which passes are slow */

int sm_rigid_is_soft(const sm_march *m) {
    const sm_torus_grid *grid = &((const sm_rigid_lines *)m->lines)->grid;
    for (int q = 0; grid->relaxation && q < grid->orders_count; q++)
        if (grid->relaxation[q] < SOFTEST) return 1;
    return 0;
}

/* ---- whether halves repeat ---------------------------------------------------------------- */

/* How far the march of a group has come. */
typedef struct {
    int halves, fine; /* half periods; of these, since the last change of the grid */
    int32_t steps;    /* along each line */
} progress;

/* Distance of harmonics (orders, N_c, 2) of a point. */
static double distance(const sm_torus_grid *grid, const sm_scales *scales, const double *one,
                       const double *other) {
    return sm_relative_distance(scales, grid->contact->contacts, grid->orders_count, grid->orders,
                                one, other);
}

/* See sm_distance_by_halves. */
static double distance_by_halves(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                                 const sm_scales *scales, const progress *at) {
    if (at->fine == 1) sm_progress_other_grid(&g->track[p]);
    if (at->halves < 2 || at->fine == 1) return INFINITY;
    const size_t from = p * grid->per_point;
    const double turn = 2.0 * distance(grid, scales, g->half[0] + from, g->half[1] + from);
    const double by_halves = sm_distance_by_halves(&g->track[p], turn);
    if (at->fine < 2 || at->halves < 3) return INFINITY; /* the first half began at rest */
    if (grid->lines == 1) return by_halves;
    /* lines drift against the grid, and harmonics move by its error, which does not fall: the mean
     * of two halves counts, the earlier of them not that after another grid */
    return at->fine < 3 ? INFINITY : fmax(by_halves, DRIFT * turn);
}

/* sum += fresh over the halves since the change of a point last fell noticeably. */
static void add_stalled(const sm_progress *track, size_t count, const double *fresh, double *sum) {
    for (size_t k = 0; k < count; k++) sum[k] = fresh[k] + (track->stalled > 1 ? sum[k] : 0.0);
}

/* Stores the harmonics of a point after a half. If halves of one line repeat, the last, which is closer
 * to periodicity, stands for both. Harmonics that keep moving by the error of the grid while the
 * phases drift are stored as means, with their distance from these. */
static void store(const sm_march *m, const sm_torus_grid *grid, sm_torus_group *g, size_t p,
                  const progress *at) {
    const sm_torus_motion *motion = m->task->motion;
    const size_t all = grid->per_point, n = (size_t)grid->contact->contacts, point = m->first + p;
    const double tolerance = m->task->grid->tolerance;
    const int last_half = (at->halves - 1) % 2;
    sm_progress *track = &g->track[p];
    double *harmonics = motion->harmonics + point * all, *squares = motion->mean_square + point * n;
    double *fresh = g->fresh + p * all, *last = g->last[at->halves % 2] + p * all;
    double *sum = g->stalled_sum + p * all, *sum_squares = g->stalled_squares + p * n;
    const sm_scales scales =
        sm_scales_at(m->contact, sm_march_amplitudes(m, p), m->task->grid->smallest_scale);
    const double change = distance(grid, &scales, fresh, last);
    const double by_halves = distance_by_halves(grid, g, p, &scales, at);
    motion->residual[point] =
        sm_distance_from_periodic(track, &scales, change, by_halves, at->halves, tolerance);
    motion->marched[point] = at->steps;
    memcpy(last, fresh, sizeof(double) * all);
    memcpy(harmonics, fresh, sizeof(double) * all);
    const int repeats = grid->lines == 1 && by_halves <= tolerance;
    for (size_t k = 0; k < all && repeats; k++)
        harmonics[k] = 2.0 * g->half[last_half][p * all + k];
    sm_torus_group_mean_square(grid, g, p, repeats ? last_half : 1 - last_half, last_half, squares);
    add_stalled(track, all, fresh, sum);
    add_stalled(track, n, squares, sum_squares);
    if (!track->done || motion->residual[point] <= tolerance) return;
    for (size_t k = 0; k < all; k++) harmonics[k] = sum[k] / track->stalled;
    for (size_t i = 0; i < n; i++) squares[i] = sum_squares[i] / track->stalled;
    motion->residual[point] = distance(grid, &scales, fresh, harmonics);
}

/* ---- between halves ------------------------------------------------------------------------ */

/* R += a part of (H Y + held - R) for each harmonic. */
static void respond(const sm_torus_grid *grid, sm_torus_group *g, const double *relaxation) {
    const size_t all = grid->per_point, each = 2 * (size_t)grid->contact->contacts;
    for (size_t p = 0; p < (size_t)grid->points_per_group; p++) {
        double *R = g->response + p * all;
        sm_respond(grid->contact, g->fresh + p * all, g->next_response);
        for (size_t k = 0; k < all; k++)
            R[k] += relaxation[k / each] * (g->next_response[k] - R[k]);
    }
}

/* Contacts at rest, and the response to the initial guess of their harmonics. */
static void start(const sm_march *m, const sm_torus_grid *grid, sm_torus_group *g) {
    const double *at_start = m->contact->response ? m->contact->response->start : NULL;
    m->law->start((sm_march *)m, NULL);
    memset(g->fresh, 0, m->points * grid->per_point * sizeof(double));
    for (size_t p = 0; p < m->points; p++) {
        sm_progress_start(&g->track[p]);
        g->faster[p].recorded = 0;
        if (at_start)
            memcpy(g->fresh + p * grid->per_point, at_start, grid->per_point * sizeof(double));
        if (g->reaction)
            sm_respond(m->contact, g->fresh + p * grid->per_point,
                       g->response + p * grid->per_point);
    }
}

static sm_status relax(sm_march *m) {
    sm_rigid_lines *r = m->lines;
    sm_torus_group *g = &r->group;
    const int coarse_halves = r->coarse.steps < r->grid.steps ? COARSE_HALVES : 0;
    progress at = {.steps = 0};
    start(m, &r->grid, g);
    for (int halves = 1; halves <= 2 * m->task->grid->max_periods; halves++) {
        const int half = (halves - 1) % 2;
        const sm_torus_grid *now = halves <= coarse_halves ? &r->coarse : &r->grid;
        const sm_status status = sm_torus_group_half(now, g, half);
        if (status != SM_OK) return status;
        at.halves = halves;
        at.fine = halves - coarse_halves;
        at.steps += sm_torus_half_end(now, half) - sm_torus_half_start(now, half);
        int open = 0;
        for (size_t p = 0; p < m->count; p++) {
            if (!g->track[p].done) store(m, &r->grid, g, p, &at);
            open |= !g->track[p].done;
        }
        if (!open) return SM_OK;
        if (half == 1) {
            sm_phases_turn(&g->phases, r->grid.ratio);
            for (size_t p = 0; p < m->count; p++)
                if (!g->track[p].done && sm_accelerate(&r->grid, g, p))
                    sm_progress_restart(&g->track[p]);
        }
        if (g->reaction) respond(&r->grid, g, r->grid.relaxation);
    }
    return SM_OK;
}

sm_status sm_rigid_relax(sm_march *m) {
    const size_t points = m->task->points->count;
    sm_status status = SM_OK;
    for (m->first = 0; m->first < points && status == SM_OK; m->first += m->points) {
        m->count = points - m->first < m->points ? points - m->first : m->points;
        status = relax(m);
    }
    return status;
}
