#include "torus/group.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/exact_sum.h"

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
    g->phase = sm_take(block, 2 * wide);
    g->turn = sm_take(block, 2 * wide * (size_t)(grid->highest + 1));
    g->sums = sm_take(block, wide * grid->per_point);
    if (grid->dynamic_stiffness) g->reaction = sm_take(block, wide * grid->per_point);
    for (int half = 0; half < 2; half++) g->squares[half] = sm_take(block, wide * n);
    g->forcing = sm_take(block, 2 * SM_TOGETHER * row);
    g->moved = sm_take(block, SM_TOGETHER * row);
    double **of_points[] = {&g->half[0], &g->half[1],     &g->fresh,     &g->last[0],
                            &g->last[1], &g->stalled_sum, &g->responded, &g->response};
    for (size_t k = 0; k < sizeof of_points / sizeof *of_points; k++)
        *of_points[k] = sm_take(block, harmonics);
    for (size_t p = 0; p < points; p++)
        sm_acceleration_place(&g->faster[p], grid->contact->contacts, grid->lines, block);
    g->line_state = sm_take(block, (n + 2) * (size_t)grid->lines);
    g->stalled_squares = sm_take(block, points * n);
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

void sm_torus_group_amplitudes(const sm_torus_grid *grid, sm_torus_group *g, size_t first,
                               size_t points, const double *amplitudes, double part) {
    const size_t modes = (size_t)grid->contact->modes;
    for (int lane = 0; lane < g->blocks * grid->lanes; lane++) {
        size_t point = first + (size_t)(lane / grid->lines);
        point = point < points ? point : points - 1; /* spare lanes repeat the last point */
        g->a[lane] = part * amplitudes[point * modes];
        g->b[lane] = modes == 2 ? part * amplitudes[point * 2 + 1] : 0.0;
    }
}

void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *g, size_t first,
                          size_t points, const double *amplitudes) {
    for (int block = 0; block < g->blocks; block++)
        memset(g->lanes[block].x, 0, g->lanes[block].size * sizeof(double));
    const size_t harmonics = (size_t)grid->points_per_group * grid->per_point * sizeof(double);
    const double *at_start = g->reaction ? grid->contact->response->start : NULL;
    memset(g->responded, 0, harmonics);
    for (int p = 0; at_start && p < grid->points_per_group; p++)
        memcpy(g->responded + (size_t)p * grid->per_point, at_start,
               grid->per_point * sizeof(double));
    memset(g->half[1], 0, harmonics);
    for (int lane = 0; lane < g->blocks * grid->lanes; lane++) {
        const int block = lane / grid->lanes, l = lane % grid->lanes;
        const double t_b0 = SM_TWO_PI * (lane % grid->lines) / grid->lines;
        g->phase[block * 2 * grid->lanes + l] = cos(t_b0);
        g->phase[(block * 2 + 1) * grid->lanes + l] = sin(t_b0);
    }
    sm_torus_group_turn(grid, g);
    sm_torus_group_amplitudes(grid, g, first, points, amplitudes, 1.0);
    for (int p = 0; p < grid->points_per_group; p++) {
        sm_progress_start(&g->track[p]);
        sm_acceleration_start(&g->faster[p]);
    }
}

void sm_torus_group_turn(const sm_torus_grid *grid, sm_torus_group *g) {
    const size_t lanes = (size_t)grid->lanes;
    double *turn = g->turn;
    for (int block = 0; block < g->blocks; block++, turn += 2 * lanes) {
        const double *c = g->phase + (size_t)block * 2 * lanes, *s = c + lanes;
        for (size_t l = 0; l < lanes; l++) {
            turn[l] = 1.0;
            turn[lanes + l] = 0.0;
        }
        for (int m = 0; m < grid->highest; m++, turn += 2 * lanes)
            for (size_t l = 0; l < lanes; l++) {
                const double re = turn[l], im = turn[lanes + l];
                turn[2 * lanes + l] = re * c[l] - im * s[l];
                turn[3 * lanes + l] = re * s[l] + im * c[l];
            }
    }
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
