/* The march of rigid contacts on the torus, eq. (13): its arrays, and the functions of sm_torus_law
 * by which the search for periodic motion (periodic/search.c) calls it. steps.c has its periods. */
#include "torus/rigid/group.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The first half periods, in which the initial state decays, have steps that are 4 times as large,
 * but at least 16 per period: this saves up to half of the steps of one mode
 * (benchmarks/contact_solves.py). */
#define COARSE_STEP 4
#define FEWEST_STEPS 16
#define SMALLEST_RELAXATION 0.5 /* of iterations by half periods: smaller factors converge slowly */
/* Residual of a stage relative to the tolerance, and its upper bound relative to the friction
 * limit. The residuals change the harmonics by a few times as much. */
#define STAGE_RESIDUAL 1e-3
#define LARGEST_STAGE_RESIDUAL 1e-6

/* Places the arrays. */
static void place(const sm_torus_grid *grid, sm_torus_group *g, sm_block *block) {
    const size_t n = (size_t)grid->contact->contacts, points = (size_t)grid->points_per_group;
    const size_t wide = (size_t)g->blocks * (size_t)grid->lanes, row = n * (size_t)grid->lanes;
    const size_t harmonics = sm_whole_lines(points * grid->per_point);
    for (int k = 0; k < g->blocks; k++) {
        sm_lanes_place(&g->lanes[k], grid->contact->contacts, grid->lanes, block);
        block->taken = sm_whole_lines(block->taken);
    }
    SM_TAKE_EACH(block, wide, &g->a, &g->b, &g->a_step, &g->b_step);
    g->phases = (sm_phases){.lines = (size_t)grid->lines, .wide = wide};
    sm_phases_place(&g->phases, (size_t)grid->orders_count, grid->orders, block);
    g->sums = sm_take(block, wide * grid->per_point);
    if (grid->dynamic_stiffness) g->reaction = sm_take(block, wide * grid->per_point);
    g->squares = sm_take(block, wide * n);
    g->forcing = sm_take(block, 2 * SM_TOGETHER * row);
    g->displacement = sm_take(block, SM_TOGETHER * row);
    SM_TAKE_EACH(block, harmonics, &g->Y, &g->response);
    g->mean_square = sm_take(block, points * n);
    for (size_t p = 0; p < points; p++) {
        sm_acceleration *a = &g->acceleration[p];
        SM_TAKE_EACH(block, sm_acceleration_size(n, (size_t)grid->lines), &a->spectrum, &a->change,
                     &a->fresh);
    }
}

/* Allocates a group. The caller releases it also after a failure. */
static sm_status make_group(sm_torus_group *g, const sm_torus_grid *grid) {
    const size_t points = (size_t)grid->points_per_group;
    sm_block block = {NULL, 0};
    g->blocks = grid->lines > grid->lanes ? grid->lines / grid->lanes : 1;
    g->lanes = calloc((size_t)g->blocks, sizeof(sm_lanes));
    g->acceleration = calloc(points, sizeof(sm_acceleration));
    if (!g->lanes || !g->acceleration) return SM_NO_MEMORY;
    place(grid, g, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    g->memory = block.memory;
    place(grid, g, &block);
    return SM_OK;
}

/* ---- the march ------------------------------------------------------------------------- */

/* Sets the contacts of all lanes to rest. Harmonics do not determine the offsets of stuck contacts,
 * so that Y is not used. */
static void start(sm_march *m, const double *Y) {
    sm_rigid_lines *r = m->lines;
    sm_torus_group *g = &r->group;
    (void)Y;
    for (int block = 0; block < g->blocks; block++)
        memset(g->lanes[block].x, 0, g->lanes[block].size * sizeof(double));
    for (size_t p = 0; p < m->points; p++) g->acceleration[p].recorded = 0;
    sm_phases_start(&g->phases);
    r->marched = 0;
}

/* Returns whether iterations of the response with relaxation may converge slowly, or diverge. */
static int responds_strongly(const sm_torus_grid *grid) {
    for (int q = 0; grid->relaxation && q < grid->orders_count; q++)
        if (grid->relaxation[q] < SMALLEST_RELAXATION) return 1;
    return 0;
}

/* Chooses half periods if `half`, for odd harmonics and weak responses. */
static int by_halves(sm_march *m, int half) {
    sm_rigid_lines *r = m->lines;
    r->half = half && sm_is_odd(m->task->grid) && !responds_strongly(&r->grid);
    m->relaxation = r->grid.relaxation;
    return m->plain = r->half;
}

/* Extrapolates the displacements of point p after half periods. */
static int extrapolate(sm_march *m, size_t p, int wanted) {
    sm_rigid_lines *r = m->lines;
    return r->half && sm_accelerate(&r->grid, &r->group, p, wanted);
}

/* Frees the lines. */
static void release(sm_march *m) {
    sm_rigid_lines *r = m->lines;
    if (!r) return;
    free(r->group.memory);
    free(r->group.lanes);
    free(r->group.acceleration);
    free(r->coarse.memory);
    free(r->grid.memory);
    free(r);
}

sm_status sm_rigid_make(sm_march *m) {
    static const sm_torus_law law = {start, sm_rigid_period, by_halves, NULL, extrapolate, release};
    const sm_discretisation *fine = m->task->grid;
    const size_t points = m->task->points->count;
    sm_rigid_lines *r = m->lines = calloc(1, sizeof *r);
    m->law = &law;
    if (!r) return SM_NO_MEMORY;
    sm_discretisation coarse = *fine;
    if (fine->steps / COARSE_STEP >= FEWEST_STEPS)
        coarse.steps = fine->steps / COARSE_STEP / 2 * 2;
    sm_status status = sm_torus_grid_make(&r->grid, m->contact, fine, points);
    if (status == SM_OK) status = sm_torus_grid_make(&r->coarse, m->contact, &coarse, points);
    if (status == SM_OK) status = make_group(&r->group, &r->grid);
    r->grid.stepper.tolerance = r->coarse.stepper.tolerance =
        fmin(fmax(STAGE_RESIDUAL * fine->tolerance, SM_SMOOTH_TOLERANCE), LARGEST_STAGE_RESIDUAL);
    m->points = (size_t)r->grid.points_per_group;
    m->settling = 1;
    m->requested = (size_t)fine->orders_count;
    m->response = r->group.response;
    m->Y = r->group.Y;
    m->square = r->group.mean_square;
    return status;
}
