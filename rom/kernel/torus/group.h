/* A group of phase lines that are marched together in lanes. */
#ifndef SLIPMODE_GROUP_H
#define SLIPMODE_GROUP_H

#include "torus/grid.h"
#include "torus/periodic/acceleration.h"
#include "torus/periodic/periodicity.h"

/* The lanes of one point, or of several points when it has fewer lines than a block lanes. */
typedef struct {
    int blocks;              /* lanes of the group / those of a block */
    sm_lanes *lanes;         /* (blocks) */
    double *a, *b;           /* (blocks * lanes) amplitudes of each lane as the period starts */
    double *a_step, *b_step; /* the same shape: what they grow by in a step */
    double *phase;           /* (blocks, 2, lanes) cos and sin of t_B at t_A = 0 */
    double *turn;            /* (blocks, highest + 1, 2, lanes) the same of m t_B */
    double *sums;            /* (blocks, orders, N_c, 2, lanes) */
    double *reaction;            /* the same shape: modal response on the contacts at t_A = 0 */
    double *squares[2];      /* (blocks, N_c, lanes): sum of x^2 over the steps of each half */
    double *half[2];         /* (points_per_group, orders, N_c, 2) harmonics of half a period */
    double *fresh;           /* the same shape: of the last whole period */
    double *last[2];         /* the same shape: of those that ended with each half before */
    double *stalled_sum;        /* the same shape: sum over the halves without progress */
    double *stalled_squares;    /* (points_per_group, N_c): likewise, of the mean squares */
    double *responded; /* (points_per_group, orders, N_c, 2): harmonics that the modes respond to */
    double *response;          /* the same shape: force of that response on the contacts */
    double *forcing, *moved; /* (2 SM_TOGETHER, N_c, lanes), (SM_TOGETHER, N_c, lanes) */
    sm_progress *track;      /* (points_per_group) */
    sm_acceleration *faster; /* (points_per_group) */
    double *line_state;      /* (N_c + 2, lines): x, cos and sin of t_B of one point's lines */
    double *memory;
} sm_torus_group;

/* Takes its memory; release it also after a failure. */
sm_status sm_torus_group_make(sm_torus_group *group, const sm_torus_grid *grid);
void sm_torus_group_release(sm_torus_group *group);

/* Contacts at rest, for points `first` on of `points`. */
void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *group, size_t first,
                          size_t points, const double *amplitudes);
/* `turn`, where the phases have changed. */
void sm_torus_group_turn(const sm_torus_grid *grid, sm_torus_group *group);
/* The amplitudes of the lanes, all of them times `part`. */
void sm_torus_group_amplitudes(const sm_torus_grid *grid, sm_torus_group *group, size_t first,
                               size_t points, const double *amplitudes, double part);
/* Mean square of x_c over two of the last halves, or one of them twice, and all lines of point p of
 * the group, (N_c). */
void sm_torus_group_mean_square(const sm_torus_grid *grid, const sm_torus_group *group, size_t p,
                                int one, int other, double *mean_square);

/* The first or second half of a period of mode A; the harmonics over this and the half before
 * are in `fresh`. */
sm_status sm_torus_group_half(const sm_torus_grid *grid, sm_torus_group *group, int half);
/* After a half: let the retained modes respond to the harmonics in `fresh`; after the second,
 * advance the phases and move the lines of unfinished points closer to periodicity. */
void sm_torus_group_next(const sm_torus_grid *grid, sm_torus_group *group, size_t points,
                         int half);
/* The reaction to the harmonics in `responded`, at the present phases. */
void sm_torus_group_react(const sm_torus_grid *grid, sm_torus_group *group);
/* After a period: the phases of the next. */
void sm_torus_group_advance(const sm_torus_grid *grid, sm_torus_group *group);

#endif
