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
/* Half periods without progress after which a change is put down to the discretisation: phases
 * drift from period to period, so the harmonics of a coarse grid keep moving by its error. */
#define IDLE_HALVES 80
#define PROGRESS 0.8
#define UNKNOWN 0.9 /* ratio of successive changes before there are two */

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
} march_state;

/* Distance of harmonics (orders, N_c, 2) of a point. */
static double distance(const sm_torus_grid *grid, const sm_scales *scales, const double *one,
                       const double *other) {
    return sm_relative_distance(scales, grid->contact->contacts, grid->orders_count, grid->orders,
                                one, other);
}

static void start_progress(sm_progress *track) {
    *track = (sm_progress){.half_ratio = UNKNOWN, .best = INFINITY};
}

/* The series of changes begins anew. */
static void restart_progress(sm_progress *track) {
    track->change[0] = track->change[1] = track->half_change = 0.0;
    track->half_ratio = UNKNOWN;
}

static double ratio_of(double now, double before, double unknown) {
    return before > 0.0 ? fmin(fmax(now / before, 0.3), 0.97) : unknown;
}

/* The changes to come, as a geometric series. */
static double to_come(double now, double ratio) { return now * ratio / (1.0 - ratio); }

/* Distance of the last half period from those to come, when its harmonics differ by `change` from the
 * half before with opposite sign. */
static double distance_by_halves(const sm_torus_grid *grid, sm_progress *track, double change,
                                 const march_state *at) {
    if (at->fine == 1) track->half_change = 0.0; /* the half before is of another grid */
    if (at->halves < 2 || at->fine == 1) return INFINITY;
    track->half_ratio = ratio_of(change, track->half_change, track->half_ratio);
    track->half_change = change;
    if (at->fine < 2 || at->halves < 3) return INFINITY; /* the first half began at rest */
    const double by_halves = to_come(change, track->half_ratio);
    if (grid->lines == 1) return by_halves;
    /* lines drift against the grid, and harmonics move by its error, which does not fall: the mean
     * of two halves counts, the earlier of them not that after another grid */
    return at->fine < 3 ? INFINITY : fmax(by_halves, DRIFT * change);
}

/* Distance from periodicity: the smaller of `by_halves` and the estimate from the change of the
 * harmonics over a whole period. */
static double distance_by_periods(sm_progress *track, double change, double by_halves,
                                  int halves) {
    if (halves < 4 || by_halves <= 0.0) return by_halves; /* the first whole period ended after two */
    double *before = &track->change[halves % 2];
    const double ratio = ratio_of(change, *before, UNKNOWN);
    *before = change;
    track->slow = ratio > SM_SLOW_RATIO;
    track->stalled = change < PROGRESS * track->best ? 0 : track->stalled + 1;
    track->best = fmin(track->best, change);
    return fmin(by_halves, to_come(change, ratio));
}

/* sum += fresh over the halves since the change of a point last fell noticeably. */
static void add_stalled(const sm_progress *track, size_t count, const double *fresh, double *sum) {
    for (size_t k = 0; k < count; k++) sum[k] = fresh[k] + (track->stalled > 1 ? sum[k] : 0.0);
}

/* Stores the harmonics of a point after a half. If halves of one line repeat, the last, which is closer
 * to periodicity, stands for both. Harmonics that keep moving by the error of the grid while the
 * phases drift are stored as means, with their distance from these. */
static void store(const sm_march *m, const sm_torus_grid *grid, sm_torus_group *g, size_t p,
                  const march_state *at) {
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
    const double half_change = 2.0 * distance(grid, &scales, g->half[0] + p * all,
                                              g->half[1] + p * all);
    const double by_halves = distance_by_halves(grid, track, half_change, at);
    motion->residual[point] = scales.motion == 0.0 ? 0.0
        : distance_by_periods(track, change, by_halves, at->halves);
    track->done = motion->residual[point] <= tolerance || track->stalled >= IDLE_HALVES;
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
        start_progress(&g->track[p]);
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
    march_state at = {.steps = 0};
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
                    restart_progress(&g->track[p]);
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
