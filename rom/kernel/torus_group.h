/* A group of phase lines that are marched together in lanes, and what they have in common. */
#ifndef SLIPMODE_TORUS_GROUP_H
#define SLIPMODE_TORUS_GROUP_H

#include "acceleration.h"
#include "contact.h"
#include "exact_sum.h"
#include "periodicity.h"

#define SM_TOGETHER 4 /* steps whose sums over the harmonics are formed together */

/* What all groups share: the discretisation of the torus and the angles at its steps. */
typedef struct {
    const sm_contact *contact;
    int steps, lines, points_per_group, orders_count;
    size_t per_point;        /* doubles: orders, N_c, 2 */
    const int32_t *orders;
    double ratio;            /* omega_B / omega_A */
    sm_stepper stepper;
    /* at all steps, and SM_TOGETHER beyond: */
    double *carrier;         /* (steps, 2 stages, cos A, sin A, cos B', sin B'), B' from t_B0 */
    double *weight;          /* (steps, orders, 2): exp(-i (n + m ratio) t_A) / steps */
    double *turn;            /* (steps, 2 stages, orders, 2): exp(i (n + m ratio) t_A) */
    const double *feedback;  /* (orders, N_c, N_c, 2): modal answer; NULL without one */
    double *relaxation;      /* (orders) part of a change that the modes answer to at once */
    double *memory;
} sm_torus_grid;

/* The lanes of one point, or of several points when lines < SM_LANES. */
typedef struct {
    int blocks;              /* lanes of the group / SM_LANES */
    sm_lanes *lanes;         /* (blocks) */
    double *a, *b;           /* (blocks * SM_LANES) amplitudes of each lane as the period starts */
    double *a_step, *b_step; /* the same shape: what they grow by in a step */
    double *phase;           /* (blocks, 2, SM_LANES) cos and sin of t_B at t_A = 0 */
    double *sums;            /* (blocks, orders, N_c, 2, SM_LANES) */
    double *pull;            /* the same shape: modal answer on the contacts at t_A = 0 */
    double *squares[2];      /* (blocks, N_c, SM_LANES): sum of x^2 over the steps of each half */
    double *half[2];         /* (points_per_group, orders, N_c, 2) harmonics of half a period */
    double *fresh;           /* the same shape: of the last whole period */
    double *last[2];         /* the same shape: of those that ended with each half before */
    double *idle_sum;        /* the same shape: sum over the halves without progress */
    double *idle_squares;    /* (points_per_group, N_c): likewise, of the mean squares */
    double *answered;        /* (points_per_group, orders, N_c, 2): harmonics that the modes answer to */
    double *answer;          /* the same shape: force of that answer on the contacts */
    double *forcing, *moved; /* (2 SM_TOGETHER, N_c, SM_LANES), (SM_TOGETHER, N_c, SM_LANES) */
    sm_progress *track;      /* (points_per_group) */
    sm_acceleration *faster; /* (points_per_group) */
    double *line_state;      /* (N_c + 2, lines): x, cos and sin of t_B of one point's lines */
    double *memory;
} sm_torus_group;

/* The steps of the first and second half of a period, from the start to before the end. */
static inline int sm_torus_half_start(const sm_torus_grid *grid, int half) {
    return half == 0 ? 0 : grid->steps / 2;
}

static inline int sm_torus_half_end(const sm_torus_grid *grid, int half) {
    return half == 0 ? grid->steps / 2 : grid->steps;
}

/* Where in a period a stage is, in steps. */
static inline double sm_stage_place(size_t stage) {
    return (double)(stage / 2) + (stage % 2 == 0 ? SM_GAMMA : 1.0);
}

/* Both take their memory here; release it with the functions that follow, also after a failure. */
sm_status sm_torus_grid_make(sm_torus_grid *grid, const sm_contact *contact, const double *rates,
                             int steps, int lines, int orders_count, const int32_t *orders);
sm_status sm_torus_group_make(sm_torus_group *group, const sm_torus_grid *grid);
void sm_torus_grid_release(sm_torus_grid *grid);
void sm_torus_group_release(sm_torus_group *group);

/* Contacts at rest, for points `first` on of `points`. */
void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *group, size_t first,
                          size_t points, const double *amplitudes);
/* The first or second half of a period of mode A; the harmonics over this and the half before
 * are in `fresh`. */
sm_status sm_torus_group_half(const sm_torus_grid *grid, sm_torus_group *group, int half);
/* Mean square of x_c over the last period and all lines of point p of the group, (N_c). */
void sm_torus_group_mean_square(const sm_torus_grid *grid, const sm_torus_group *group, size_t p,
                                double *mean_square);
/* After a half: let the retained modes answer to the harmonics in `fresh`; after the second, turn
 * the phases and move the lines of unfinished points closer to periodicity. */
void sm_torus_group_next(const sm_torus_grid *grid, sm_torus_group *group, size_t points,
                         int half);
/* After a period: the phases of the next. */
void sm_torus_group_turn(const sm_torus_grid *grid, sm_torus_group *group);

#endif
