#include "torus/torus.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "torus/group.h"
#include "torus/fixed_point/search.h"

#define MOST_AVERAGED 16
#define SOFTEST 0.5 /* relaxation below which passes are slow */

/* One point of the group. */
typedef struct {
    sm_fixed_point search;
    double *mean, *last, *change; /* (orders, N_c, 2) harmonics */
    double *square;                         /* (N_c) mean square */
    double residual;
    int done, open; /* whether it repeats, and whether it still comes nearer */
} soft_point;

int sm_torus_is_soft(const sm_torus_grid *grid) {
    for (int q = 0; grid->relaxation && q < grid->orders_count; q++)
        if (grid->relaxation[q] < SOFTEST) return 1;
    return 0;
}

static size_t point_size(const sm_torus_grid *grid) {
    return sm_fixed_point_size(grid->per_point) + 3 * grid->per_point
           + (size_t)grid->contact->contacts;
}

static void place(const sm_torus_grid *grid, soft_point *point, double *memory) {
    const size_t all = grid->per_point;
    sm_fixed_point_place(&point->search, all, memory);
    memory += sm_fixed_point_size(all);
    double **rows[] = {&point->mean, &point->last, &point->change};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++, memory += all) *rows[k] = memory;
    point->square = memory;
    point->done = 0;
}

/* Harmonics and mean squares of all points over so many periods, under the same response. */
static sm_status evaluate(const sm_torus_grid *grid, sm_torus_group *g, soft_point *point,
                          size_t count, int periods) {
    const size_t all = grid->per_point, n = (size_t)grid->contact->contacts;
    for (size_t p = 0; p < count; p++) {
        if (point[p].done) continue;
        memcpy(point[p].last, point[p].mean, all * sizeof(double));
        memset(point[p].mean, 0, all * sizeof(double));
        memset(point[p].square, 0, n * sizeof(double));
    }
    for (int k = 0; k < periods; k++) {
        for (int half = 0; half < 2; half++) {
            const sm_status status = sm_torus_group_half(grid, g, half);
            if (status != SM_OK) return status;
        }
        for (size_t p = 0; p < count; p++) {
            if (point[p].done) continue;
            sm_torus_group_mean_square(grid, g, p, 0, 1, g->idle_squares);
            for (size_t i = 0; i < all; i++)
                point[p].mean[i] += g->fresh[p * all + i] / periods;
            for (size_t i = 0; i < n; i++) point[p].square[i] += g->idle_squares[i] / periods;
        }
        sm_torus_group_advance(grid, g);
        sm_torus_group_react(grid, g);
    }
    return SM_OK;
}

/* How far a point is from repeating: its harmonics, and what the modes respond to. */
static double distance(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                       soft_point *point, const sm_scales *scales) {
    const double *responded = g->responded + p * grid->per_point;
    const int contacts = grid->contact->contacts;
    for (size_t i = 0; i < grid->per_point; i++)
        point->change[i] = point->mean[i] - responded[i];
    return fmax(sm_relative_distance(scales, contacts, grid->orders_count, grid->orders,
                                     point->mean, point->last),
                sm_relative_distance(scales, contacts, grid->orders_count, grid->orders,
                                     point->mean, responded));
}

static void store(const sm_torus_grid *grid, const sm_torus_task *task, size_t index,
                  const soft_point *point, int marched) {
    const size_t n = (size_t)grid->contact->contacts;
    memcpy(task->motion->harmonics + index * grid->per_point, point->mean,
           grid->per_point * sizeof(double));
    memcpy(task->motion->mean_square + index * n, point->square, n * sizeof(double));
    task->motion->residual[index] = point->residual;
    task->motion->marched[index] = marched;
}

/* Evaluations of so many periods until every point repeats, or comes no nearer; at a part of the
 * amplitudes, which only leads to a start for more. */
static sm_status settle(const sm_torus_grid *grid, sm_torus_group *g, const sm_torus_task *task,
                        size_t first, size_t count, soft_point *point, int periods, double part,
                        int *marched) {
    const size_t all = grid->per_point, modes = (size_t)grid->contact->modes;
    for (size_t p = 0; p < count; p++) {
        sm_fixed_point_start(&point[p].search);
        point[p].open = !point[p].done;
    }
    const int until = *marched + task->grid->max_periods * grid->steps;
    for (int open = 1; open && *marched < until;) {
        const sm_status status = evaluate(grid, g, point, count, periods);
        if (status != SM_OK) return status;
        const int at_start = *marched == 0; /* the first period forgets the start */
        *marched += periods * grid->steps;
        open = 0;
        for (size_t p = 0; p < count; p++) {
            soft_point *s = &point[p];
            if (!s->open) continue;
            const sm_scales scales = sm_displacement_scales(
                grid->contact, task->points->amplitudes + (first + p) * modes, task->grid->smallest_scale);
            double *responded = g->responded + p * all;
            s->residual = distance(grid, g, p, s, &scales);
            const int repeats =
                scales.largest == 0.0 || (!at_start && s->residual <= task->grid->tolerance);
            s->open = !repeats;
            if (part == 1.0) {
                s->done = repeats;
                store(grid, task, first + p, s, *marched);
            }
            if (s->open && !at_start)
                s->open = sm_fixed_point_next(&s->search, s->residual, s->change, responded);
            open |= s->open;
        }
        sm_torus_group_react(grid, g);
    }
    return SM_OK;
}

static int any_left(const soft_point *point, size_t count) {
    for (size_t p = 0; p < count; p++)
        if (!point[p].done && point[p].residual > SM_ALMOST) return 1;
    return 0;
}

/* From small amplitudes, where the response is that of contacts that stick, up to the points. */
static sm_status climb(const sm_torus_grid *grid, sm_torus_group *g, const sm_torus_task *task,
                       size_t first, size_t count, soft_point *point, int *marched) {
    const size_t all = grid->per_point;
    double reached = 0.0;
    for (size_t rung = 0; rung < SM_RUNGS; rung++) {
        const double part = SM_LADDER[rung];
        for (size_t p = 0; p < count; p++) {
            double *responded = g->responded + p * all;
            for (size_t i = 0; i < all && !point[p].done; i++)
                responded[i] = reached > 0.0 ? responded[i] * part / reached : 0.0;
        }
        sm_torus_group_amplitudes(grid, g, first, task->points->count, task->points->amplitudes, part);
        sm_torus_group_react(grid, g);
        const sm_status status =
            settle(grid, g, task, first, count, point, 1, part, marched);
        if (status != SM_OK) return status;
        reached = part;
    }
    return SM_OK;
}

sm_status sm_torus_soft_group(const sm_torus_grid *grid, sm_torus_group *g,
                              const sm_torus_task *task, size_t first, size_t count) {
    const size_t size = point_size(grid);
    soft_point *point = calloc(count, sizeof *point);
    double *memory = calloc(count * size, sizeof(double));
    sm_status status = point && memory ? SM_OK : SM_NO_MEMORY;
    int marched = 0;
    if (status == SM_OK) {
        for (size_t p = 0; p < count; p++) place(grid, &point[p], memory + p * size);
        sm_torus_group_start(grid, g, first, task->points->count, task->points->amplitudes);
        sm_torus_group_react(grid, g);
    }
    if (status == SM_OK)
        status = settle(grid, g, task, first, count, point, 1, 1.0, &marched);
    if (status == SM_OK && any_left(point, count) && !grid->contact->response->start)
        status = climb(grid, g, task, first, count, point, &marched);
    for (int periods = 4; periods <= MOST_AVERAGED && status == SM_OK; periods *= 4)
        status = settle(grid, g, task, first, count, point, periods, 1.0, &marched);
    free(memory);
    free(point);
    return status;
}
