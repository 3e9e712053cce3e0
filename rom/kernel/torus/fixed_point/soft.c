#include "torus/torus.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "torus/group.h"
#include "torus/fixed_point/search.h"

#define SOFTEST 0.5 /* relaxation below which passes are slow */

/* One point of the group. */
typedef struct {
    sm_fixed_point search;
    double *mean, *last, *change; /* (orders, N_c, 2) harmonics */
    double *square;               /* (N_c) mean square */
    sm_scales scales;
    double residual;
    int done, open; /* whether it repeats; whether the residual still falls */
} soft_point;

/* Points of the task that are solved together. */
typedef struct {
    const sm_torus_grid *grid;
    const sm_torus_task *task;
    sm_torus_group *g;
    size_t first, count;
    soft_point *point;
    int marched; /* steps along each line */
} soft_group;

int sm_torus_is_soft(const sm_torus_grid *grid) {
    for (int q = 0; grid->relaxation && q < grid->orders_count; q++)
        if (grid->relaxation[q] < SOFTEST) return 1;
    return 0;
}

static void place(const soft_group *s, sm_block *block) {
    const size_t all = s->grid->per_point;
    for (size_t p = 0; p < s->count; p++) {
        soft_point *point = &s->point[p];
        sm_fixed_point_place(&point->search, all, block);
        double **rows[] = {&point->mean, &point->last, &point->change};
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(block, all);
        point->square = sm_take(block, (size_t)s->grid->contact->contacts);
    }
}

/* Harmonics and mean squares of all points over so many periods, under the same response. */
static sm_status evaluate(const soft_group *s, int periods) {
    const sm_torus_grid *grid = s->grid;
    sm_torus_group *g = s->g;
    soft_point *point = s->point;
    const size_t all = grid->per_point, n = (size_t)grid->contact->contacts, count = s->count;
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
            sm_torus_group_mean_square(grid, g, p, 0, 1, g->stalled_squares);
            for (size_t i = 0; i < all; i++)
                point[p].mean[i] += g->fresh[p * all + i] / periods;
            for (size_t i = 0; i < n; i++) point[p].square[i] += g->stalled_squares[i] / periods;
        }
        sm_torus_group_advance(grid, g);
        sm_torus_group_react(grid, g);
    }
    return SM_OK;
}

/* Distance of a point from periodicity: the change of its harmonics from the evaluation before, and
 * from the harmonics that the modes respond to. */
static double distance(const sm_torus_grid *grid, soft_point *point, const double *responded) {
    const int contacts = grid->contact->contacts;
    for (size_t i = 0; i < grid->per_point; i++)
        point->change[i] = point->mean[i] - responded[i];
    return fmax(sm_relative_distance(&point->scales, contacts, grid->orders_count, grid->orders,
                                     point->mean, point->last),
                sm_relative_distance(&point->scales, contacts, grid->orders_count, grid->orders,
                                     point->mean, responded));
}

static void store(const soft_group *s, size_t p) {
    const sm_torus_motion *motion = s->task->motion;
    const size_t n = (size_t)s->grid->contact->contacts, all = s->grid->per_point;
    const size_t index = s->first + p;
    memcpy(motion->harmonics + index * all, s->point[p].mean, all * sizeof(double));
    memcpy(motion->mean_square + index * n, s->point[p].square, n * sizeof(double));
    motion->residual[index] = s->point[p].residual;
    motion->marched[index] = s->marched;
}

/* Iterates evaluations of so many periods until every point repeats or its residual stops falling. At
 * a part of the amplitudes the result is only an initial guess for a larger part. */
static sm_status iterate(soft_group *s, int periods, double part) {
    const sm_discretisation *grid = s->task->grid;
    for (size_t p = 0; p < s->count; p++) {
        sm_fixed_point_start(&s->point[p].search);
        s->point[p].open = !s->point[p].done;
    }
    const int until = s->marched + grid->max_periods * grid->steps;
    for (int open = 1; open && s->marched < until;) {
        const sm_status status = evaluate(s, periods);
        if (status != SM_OK) return status;
        const int at_start = s->marched == 0; /* the first period forgets the start */
        s->marched += periods * grid->steps;
        open = 0;
        for (size_t p = 0; p < s->count; p++) {
            soft_point *point = &s->point[p];
            if (!point->open) continue;
            double *responded = s->g->responded + p * s->grid->per_point;
            point->residual = distance(s->grid, point, responded);
            const int repeats = point->scales.largest == 0.0 ||
                                (!at_start && point->residual <= grid->tolerance);
            point->open = !repeats;
            if (part == 1.0) {
                point->done = repeats;
                store(s, p);
            }
            if (point->open && !at_start)
                point->open = sm_fixed_point_next(&point->search, point->residual, point->change,
                                                  responded);
            open |= point->open;
        }
        sm_torus_group_react(s->grid, s->g);
    }
    return SM_OK;
}

static int any_far(const soft_group *s) {
    for (size_t p = 0; p < s->count; p++)
        if (!s->point[p].done && s->point[p].residual > SM_ALMOST) return 1;
    return 0;
}

/* Continues the points from small amplitudes, at which the contacts stick, to their own. */
static sm_status continue_from_rest(soft_group *s) {
    const sm_torus_points *points = s->task->points;
    const size_t all = s->grid->per_point;
    double reached = 0.0;
    for (size_t rung = 0; rung < SM_RUNGS; rung++) {
        const double part = SM_LADDER[rung];
        for (size_t p = 0; p < s->count; p++) {
            double *responded = s->g->responded + p * all;
            for (size_t i = 0; i < all && !s->point[p].done; i++)
                responded[i] = reached > 0.0 ? responded[i] * part / reached : 0.0;
        }
        sm_torus_group_amplitudes(s->grid, s->g, s->first, points->count, points->amplitudes, part);
        sm_torus_group_react(s->grid, s->g);
        const sm_status status = iterate(s, 1, part);
        if (status != SM_OK) return status;
        reached = part;
    }
    return SM_OK;
}

sm_status sm_torus_soft_group(const sm_torus_grid *grid, sm_torus_group *g,
                              const sm_torus_task *task, size_t first, size_t count) {
    const size_t modes = (size_t)grid->contact->modes;
    const double *amplitudes = task->points->amplitudes;
    soft_group s = {.grid = grid, .task = task, .g = g, .first = first, .count = count,
                    .point = calloc(count, sizeof *s.point)};
    sm_block block = {NULL, 0};
    if (s.point) place(&s, &block);
    sm_status status = s.point && sm_allocate(&block) ? SM_OK : SM_NO_MEMORY;
    if (status == SM_OK) {
        place(&s, &block);
        for (size_t p = 0; p < count; p++)
            s.point[p].scales = sm_displacement_scales(
                grid->contact, amplitudes + (first + p) * modes, task->grid->smallest_scale);
        sm_torus_group_start(grid, g, first, task->points->count, amplitudes);
        sm_torus_group_react(grid, g);
        status = iterate(&s, 1, 1.0);
    }
    if (status == SM_OK && any_far(&s) && !grid->contact->response->start)
        status = continue_from_rest(&s);
    for (int periods = 4; periods <= SM_MOST_AVERAGED && status == SM_OK; periods *= 4)
        status = iterate(&s, periods, 1.0);
    free(block.memory);
    free(s.point);
    return status;
}
