#include "torus/rigid/group.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/exact_sum.h"

/* The first halves, which forget the start, are marched in larger steps: this saves up to half of the
 * steps of one mode (benchmarks/contact_solves.py). */
#define COARSER 4
#define FEWEST_STEPS 16
/* Residual of stages relative to the tolerance; it moves the harmonics by a few times as much. */
#define STAGE_RESIDUAL 1e-3
#define LARGEST_STAGE_RESIDUAL 1e-6

static void place(const sm_torus_grid *grid, sm_torus_group *g, sm_block *block) {
    const size_t n = (size_t)grid->contact->contacts, points = (size_t)grid->points_per_group;
    const size_t wide = (size_t)g->blocks * (size_t)grid->lanes, row = n * (size_t)grid->lanes;
    const size_t harmonics = sm_whole_lines(points * grid->per_point);
    for (int k = 0; k < g->blocks; k++) {
        sm_lanes_place(&g->lanes[k], grid->contact->contacts, grid->lanes, block);
        block->taken = sm_whole_lines(block->taken);
    }
    double **of_lanes[] = {&g->a, &g->b, &g->a_step, &g->b_step};
    for (size_t k = 0; k < sizeof of_lanes / sizeof *of_lanes; k++)
        *of_lanes[k] = sm_take(block, wide);
    g->phases = (sm_phases){.lines = (size_t)grid->lines, .wide = wide};
    sm_phases_place(&g->phases, (size_t)grid->orders_count, grid->orders, block);
    g->sums = sm_take(block, wide * grid->per_point);
    if (grid->dynamic_stiffness) g->reaction = sm_take(block, wide * grid->per_point);
    for (int half = 0; half < 2; half++) g->squares[half] = sm_take(block, wide * n);
    g->forcing = sm_take(block, 2 * SM_TOGETHER * row);
    g->moved = sm_take(block, SM_TOGETHER * row);
    double **of_points[] = {&g->half[0], &g->half[1],     &g->fresh,     &g->last[0],
                            &g->last[1], &g->stalled_sum, &g->response};
    for (size_t k = 0; k < sizeof of_points / sizeof *of_points; k++)
        *of_points[k] = sm_take(block, harmonics);
    for (size_t p = 0; p < points; p++) {
        const size_t size = sm_acceleration_size(n, (size_t)grid->lines);
        g->faster[p].spectrum = sm_take(block, size);
        g->faster[p].change = sm_take(block, size);
        g->faster[p].fresh = sm_take(block, size);
    }
    g->stalled_squares = sm_take(block, points * n);
    g->mean_squares = sm_take(block, points * n);
    g->next_response = sm_take(block, grid->per_point);
}

sm_status sm_torus_group_make(sm_torus_group *g, const sm_torus_grid *grid) {
    const size_t points = (size_t)grid->points_per_group;
    sm_block block = {NULL, 0};
    g->blocks = grid->lines > grid->lanes ? grid->lines / grid->lanes : 1;
    g->lanes = calloc((size_t)g->blocks, sizeof(sm_lanes));
    g->track = calloc(points, sizeof(sm_progress));
    g->faster = calloc(points, sizeof(sm_acceleration));
    if (!g->lanes || !g->track || !g->faster) return SM_NO_MEMORY;
    place(grid, g, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    g->memory = block.memory;
    place(grid, g, &block);
    return SM_OK;
}

void sm_torus_group_release(sm_torus_group *g) {
    free(g->memory);
    free(g->lanes);
    free(g->track);
    free(g->faster);
}

static void set_amplitudes(const sm_torus_grid *grid, sm_torus_group *g, const sm_march *m) {
    for (int lane = 0; lane < g->blocks * grid->lanes; lane++) {
        const double *amplitude = sm_march_amplitudes(m, (size_t)(lane / grid->lines));
        g->a[lane] = m->part * amplitude[0];
        g->b[lane] = grid->contact->modes == 2 ? m->part * amplitude[1] : 0.0;
    }
}

void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *g, const sm_march *m) {
    for (int block = 0; block < g->blocks; block++)
        memset(g->lanes[block].x, 0, g->lanes[block].size * sizeof(double));
    memset(g->half[1], 0, (size_t)grid->points_per_group * grid->per_point * sizeof(double));
    sm_phases_start(&g->phases);
    set_amplitudes(grid, g, m);
}

void sm_torus_group_mean_square(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                                int one, int other, double *mean_square) {
    const int n = grid->contact->contacts, lines = grid->lines;
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int lane = (int)p * lines; lane < ((int)p + 1) * lines; lane++) {
            const int at = (lane / grid->lanes * n + i) * grid->lanes + lane % grid->lanes;
            sum += g->squares[one][at] + g->squares[other][at];
        }
        mean_square[i] = sum / ((double)grid->steps * lines);
    }
}

/* ---- the march ------------------------------------------------------------------------- */

static void start(sm_march *m, const double *Y) {
    sm_rigid_lines *r = m->lines;
    (void)Y;
    sm_torus_group_start(&r->grid, &r->group, m);
}

static sm_status march_period(sm_march *m) {
    sm_rigid_lines *r = m->lines;
    set_amplitudes(&r->grid, &r->group, m);
    for (int half = 0; half < 2; half++) {
        const sm_status status = sm_torus_group_half(&r->grid, &r->group, half);
        if (status != SM_OK) return status;
    }
    for (size_t p = 0; p < m->count; p++)
        sm_torus_group_mean_square(&r->grid, &r->group, p, 0, 1,
                                   r->group.mean_squares + p * (size_t)m->contact->contacts);
    m->steps = r->grid.steps;
    sm_phases_turn(&r->group.phases, r->grid.ratio);
    return SM_OK;
}

static void release(sm_march *m) {
    sm_rigid_lines *r = m->lines;
    if (!r) return;
    sm_torus_group_release(&r->group);
    sm_torus_grid_release(&r->coarse);
    sm_torus_grid_release(&r->grid);
    free(r);
}

sm_status sm_rigid_make(sm_march *m) {
    static const sm_torus_law law = {start, march_period, NULL, NULL, release};
    const sm_discretisation *fine = m->task->grid;
    const size_t points = m->task->points->count;
    sm_rigid_lines *r = m->lines = calloc(1, sizeof *r);
    m->law = &law;
    if (!r) return SM_NO_MEMORY;
    sm_discretisation few = *fine;
    if (fine->steps / COARSER >= FEWEST_STEPS) few.steps = fine->steps / COARSER;
    sm_status status = sm_torus_grid_make(&r->grid, m->contact, fine, points);
    if (status == SM_OK) status = sm_torus_grid_make(&r->coarse, m->contact, &few, points);
    if (status == SM_OK) status = sm_torus_group_make(&r->group, &r->grid);
    r->grid.stepper.tolerance = r->coarse.stepper.tolerance =
        fmin(fmax(STAGE_RESIDUAL * fine->tolerance, SM_SMOOTH_TOLERANCE), LARGEST_STAGE_RESIDUAL);
    m->points = (size_t)r->grid.points_per_group;
    m->requested = (size_t)fine->orders_count;
    m->response = r->group.response;
    m->Y = r->group.fresh;
    m->square = r->group.mean_squares;
    return status;
}
