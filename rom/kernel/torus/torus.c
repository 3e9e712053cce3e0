/* Periodic contact motion on the torus, eq. (13), by characteristics.
 *
 * Along t_B = t_B0 + (omega_B / omega_A) t_A the partial differential equation is ordinary.
 * `lines` phase lines with t_B0 = 2 pi p / lines are marched period by period of mode A, side by
 * side in lanes; P_nm is the plain mean of x exp(-i (n t_A + m t_B)) over steps and lines,
 * spectrally accurate in t_B. Friction is odd: half a period repeats the one before with opposite
 * sign, but where contacts that stick are off the middle. After every half its harmonics are
 * compared with those of the half before, and those of the last whole period with those a period
 * before; the march ends when either repeats.
 */
#include "base/check.h"
#include "torus/torus.h"
#include "torus/group.h"

/* Half a period to forget the start and a whole one are marched in larger steps: this saves up to
 * half of the steps of one mode (benchmarks/contact_solves.py). */
#define COARSE_HALVES 3
#define COARSER 4
#define FEWEST_STEPS 16
/* Residual of stages relative to the tolerance; it moves the harmonics by a few times as much. */
#define LEFT_BY_STAGES 1e-3
#define MOST_LEFT 1e-6
#define DRIFT 2.0 /* times the difference of two half periods: the distance of their mean, at most */
#define MAX_STEPS 65536
#define MAX_LINES 4096
#define MAX_ORDER 65536 /* of a harmonic: no grid resolves more */
#define MAX_ORDERS_COUNT 4096

/* Lines of rigid contacts fill lanes. */
static sm_status check_grid(int law, const sm_discretisation *grid) {
    const int32_t steps = grid->steps, lines = grid->lines, orders_count = grid->orders_count;
    const int32_t *orders = grid->orders;
    if (steps < 4 || steps > MAX_STEPS) return SM_BAD_ARGUMENT;
    if (lines < 1 || lines > MAX_LINES ||
        (law != SM_ELASTIC && (lines & (lines - 1)) != 0))
        return SM_BAD_ARGUMENT;
    if (!orders || orders_count < 1 || orders_count > MAX_ORDERS_COUNT) return SM_BAD_ARGUMENT;
    for (int32_t k = 0; k < 2 * orders_count; k++)
        if (orders[k] < -MAX_ORDER || orders[k] > MAX_ORDER) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static sm_status check_rates(int modes, const double *rates) {
    if (!rates) return SM_BAD_ARGUMENT;
    for (int j = 0; j < modes; j++) {
        const sm_status status = sm_check_positive(rates[j]);
        if (status != SM_OK) return status;
    }
    return modes == 1 || isfinite(rates[1] / rates[0] * MAX_ORDER) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid) {
    sm_status status = sm_contact_check(contact);
    if (status == SM_OK && (!grid || contact->contacts == 0)) return SM_BAD_ARGUMENT;
    if (status == SM_OK) status = check_grid(contact->law, grid);
    return status == SM_OK ? check_rates(contact->modes, grid->rates) : status;
}

sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count) {
    const size_t per_point = (size_t)orders_count * (size_t)contact->contacts * 2;
    if (!sm_fits(points, per_point * sizeof(double))) return SM_BAD_ARGUMENT;
    if (points > 0 && !values) return SM_BAD_ARGUMENT;
    return sm_all_finite(values, points * (size_t)contact->modes) ? SM_OK : SM_NOT_FINITE;
}

/* The modes must respond to the harmonics that are computed. */
static int responds_to(const sm_modal_response *response, const sm_discretisation *grid) {
    const size_t size = 2 * (size_t)grid->orders_count * sizeof(int32_t);
    return response->dynamic_stiffness && response->orders_count == grid->orders_count &&
           memcmp(response->orders, grid->orders, size) == 0;
}

static sm_status check_scales(const sm_contact *contact, const double *smallest_scale) {
    if (!smallest_scale) return SM_BAD_ARGUMENT;
    for (int j = 0; j < contact->modes; j++) {
        const sm_status status = sm_check_not_negative(smallest_scale[j]);
        if (status != SM_OK) return status;
    }
    return SM_OK;
}

static sm_status check_points(const sm_torus_task *task, const sm_contact *contact) {
    const sm_torus_points *points = task->points;
    const sm_torus_motion *motion = task->motion;
    const int32_t orders_count = task->grid->orders_count;
    const sm_status status =
        sm_torus_check_points(contact, points->count, points->amplitudes, orders_count);
    for (size_t k = 0; status == SM_OK && k < points->count * (size_t)contact->modes; k++)
        if (points->amplitudes[k] < 0.0) return SM_BAD_ARGUMENT;
    if (points->count == 0 || status != SM_OK) return status;
    const sm_modal_response *response = contact->response;
    const size_t all = 2 * (size_t)contact->contacts * (size_t)orders_count * points->count;
    if (points->near && !sm_all_finite(points->near, all)) return SM_NOT_FINITE;
    if (response && (response->start || points->near) && response->marched > 0
        && !response->periodic)
        return SM_BAD_ARGUMENT;
    return motion->harmonics && motion->mean_square && motion->residual && motion->marched
               ? SM_OK : SM_BAD_ARGUMENT;
}

/* sum += fresh over the halves since the change of a point last fell noticeably. */
static void add_stalled(const sm_progress *track, size_t count, const double *fresh, double *sum) {
    for (size_t k = 0; k < count; k++) sum[k] = fresh[k] + (track->stalled > 1 ? sum[k] : 0.0);
}

/* Stores the result of a point whose harmonics keep moving by the error of the grid while the phases
 * drift: means of harmonics and mean squares over those halves. Returns the distance of the last
 * harmonics from their mean. */
static double store_mean(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                              const sm_scales *scales, double *mean, double *mean_square) {
    const size_t per_point = grid->per_point, n = (size_t)grid->contact->contacts;
    const double stalled = g->track[p].stalled;
    for (size_t k = 0; k < per_point; k++) mean[k] = g->stalled_sum[p * per_point + k] / stalled;
    for (size_t i = 0; i < n; i++) mean_square[i] = g->stalled_squares[p * n + i] / stalled;
    return sm_relative_distance(scales, grid->contact->contacts, grid->orders_count, grid->orders,
                                g->fresh + p * per_point, mean);
}

/* See sm_distance_by_halves, after so many halves of which the last `fine` are of the grid. */
static double by_halves(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                        const sm_scales *scales, int halves, int fine) {
    if (fine == 1) sm_progress_other_grid(&g->track[p]);
    if (halves < 2 || fine == 1) return INFINITY;
    const size_t at = p * grid->per_point;
    const double turn = 2.0 * sm_relative_distance(scales, grid->contact->contacts,
                                                   grid->orders_count, grid->orders,
                                                   g->half[0] + at, g->half[1] + at);
    const double distance = sm_distance_by_halves(&g->track[p], turn);
    if (fine < 2 || halves < 3) return INFINITY; /* the first half began at rest */
    if (grid->lines == 1) return distance;
    /* lines drift against the grid, and harmonics move by its error, which does not fall: the mean
     * of two halves counts, the earlier of them not that after another grid */
    return fine < 3 ? INFINITY : fmax(distance, DRIFT * turn);
}

/* How far the march of a group has come. */
typedef struct {
    size_t first, count; /* points */
    int halves, fine;    /* half periods; of these, since the last change of the grid */
    int marched;         /* steps */
} march_state;

/* Stores the harmonics of unfinished points; returns whether any goes on. If halves of one line
 * repeat, the last, which is closer to periodicity, stands for both. */
static int store(const sm_torus_grid *grid, sm_torus_group *g, const sm_torus_task *task,
                 const march_state *at) {
    const size_t per_point = grid->per_point, modes = (size_t)grid->contact->modes;
    const size_t n = (size_t)grid->contact->contacts;
    const int halves = at->halves;
    int open = 0;
    for (size_t p = 0; p < at->count; p++) {
        sm_progress *track = &g->track[p];
        if (track->done) continue; /* its result is already stored */
        const size_t point = at->first + p;
        double *fresh = g->fresh + p * per_point, *last = g->last[halves % 2] + p * per_point;
        double *harmonics = task->motion->harmonics + point * per_point;
        double *mean_square = task->motion->mean_square + point * n;
        const sm_scales scales = sm_displacement_scales(
            grid->contact, task->points->amplitudes + point * modes, task->grid->smallest_scale);
        const double change = sm_relative_distance(&scales, grid->contact->contacts,
                                                   grid->orders_count, grid->orders, fresh, last);
        const double of_halves = by_halves(grid, g, p, &scales, halves, at->fine);
        task->motion->residual[point] = sm_distance_from_periodic(track, &scales, change, of_halves,
                                                          halves, task->grid->tolerance);
        task->motion->marched[point] = at->marched;
        memcpy(last, fresh, sizeof(double) * per_point);
        memcpy(harmonics, fresh, sizeof(double) * per_point);
        const int last_half = (halves - 1) % 2;
        const int repeats = grid->lines == 1 && of_halves <= task->grid->tolerance;
        for (size_t k = 0; k < per_point && repeats; k++)
            harmonics[k] = 2.0 * g->half[last_half][p * per_point + k];
        sm_torus_group_mean_square(grid, g, p, repeats ? last_half : 1 - last_half, last_half,
                                   mean_square);
        add_stalled(track, per_point, fresh, g->stalled_sum + p * per_point);
        add_stalled(track, n, mean_square, g->stalled_squares + p * n);
        if (track->done && task->motion->residual[point] > task->grid->tolerance)
            task->motion->residual[point] =
                store_mean(grid, g, p, &scales, harmonics, mean_square);
        open |= !track->done;
    }
    return open;
}

static sm_status solve_group(const sm_torus_grid *grid, const sm_torus_grid *coarse,
                             sm_torus_group *g, const sm_torus_task *task, size_t first) {
    const size_t left = task->points->count - first, most = (size_t)grid->points_per_group;
    const size_t count = left < most ? left : most;
    if (sm_torus_is_soft(grid)) return sm_torus_soft_group(grid, g, task, first, count);
    const int coarse_halves = coarse->steps < grid->steps ? COARSE_HALVES : 0;
    march_state at = {.first = first, .count = count};
    sm_torus_group_start(grid, g, first, task->points->count, task->points->amplitudes);
    if (g->reaction) sm_torus_group_react(grid, g);
    for (int halves = 1; halves <= 2 * task->grid->max_periods; halves++) {
        const int half = (halves - 1) % 2;
        const sm_torus_grid *now = halves <= coarse_halves ? coarse : grid;
        const sm_status status = sm_torus_group_half(now, g, half);
        if (status != SM_OK) return status;
        at.halves = halves;
        at.fine = halves - coarse_halves;
        at.marched += sm_torus_half_end(now, half) - sm_torus_half_start(now, half);
        if (!store(grid, g, task, &at)) return SM_OK;
        sm_torus_group_next(grid, g, count, half);
    }
    return SM_OK;
}

sm_status sm_torus_harmonics(const sm_contact *contact, const sm_discretisation *fine,
                             const sm_torus_points *points, const sm_torus_motion *motion) {
    const sm_torus_task task = {fine, points, motion};
    sm_status status = sm_torus_check(contact, fine);
    if (status == SM_OK && (!points || !motion)) return SM_BAD_ARGUMENT;
    if (status == SM_OK && contact->response && !responds_to(contact->response, fine))
        return SM_BAD_ARGUMENT;
    if (status == SM_OK) status = sm_check_not_negative(fine->tolerance);
    if (status == SM_OK) status = check_scales(contact, fine->smallest_scale);
    if (status == SM_OK) status = check_points(&task, contact);
    if (status == SM_OK && fine->max_periods < 1) status = SM_BAD_ARGUMENT;
    if (status != SM_OK) return status;
    if (contact->law == SM_ELASTIC) return sm_torus_elastic(contact, &task);

    sm_torus_grid grid = {.memory = NULL}, coarse = {.memory = NULL};
    sm_torus_group group = {.memory = NULL};
    sm_discretisation few = *fine;
    if (fine->steps / COARSER >= FEWEST_STEPS) few.steps = fine->steps / COARSER;
    status = sm_torus_grid_make(&grid, contact, fine, points->count);
    if (status == SM_OK) status = sm_torus_grid_make(&coarse, contact, &few, points->count);
    if (status == SM_OK) status = sm_torus_group_make(&group, &grid);
    grid.stepper.tolerance = coarse.stepper.tolerance =
        fmin(fmax(LEFT_BY_STAGES * fine->tolerance, SM_SMOOTH_TOLERANCE), MOST_LEFT);
    for (size_t first = 0; first < points->count && status == SM_OK;
         first += (size_t)grid.points_per_group)
        status = solve_group(&grid, &coarse, &group, &task, first);
    sm_torus_group_release(&group);
    sm_torus_grid_release(&coarse);
    sm_torus_grid_release(&grid);
    return status;
}
