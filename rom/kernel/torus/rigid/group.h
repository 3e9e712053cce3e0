/* A group of phase lines that are marched together in lanes. */
#ifndef SLIPMODE_GROUP_H
#define SLIPMODE_GROUP_H

#include "torus/march.h"
#include "torus/rigid/acceleration.h"
#include "torus/phases.h"
#include "torus/rigid/grid.h"

/* How the harmonics of one point converge. */
typedef struct {
    double change[2];   /* last change over a period, relative to the displacement scale; the
                           first after even halves, the second after odd ones */
    double half_change; /* last difference of half periods, one with opposite sign, */
    double half_ratio;  /* and by which it fell */
    double best;        /* smallest change so far */
    int stalled;        /* half periods since `best` last fell noticeably */
    int slow;           /* whether the changes hardly fall from period to period */
    int done;
} sm_progress;

/* The lanes of one point, or of several points when it has fewer lines than a block lanes. */
typedef struct {
    int blocks;              /* lanes of the group / those of a block */
    sm_lanes *lanes;         /* (blocks) */
    double *a, *b;           /* (blocks * lanes) amplitudes of each lane as the period starts */
    double *a_step, *b_step; /* the same shape: what they grow by in a step */
    sm_phases phases;        /* t_B at t_A = 0 in all lanes */
    double *sums;            /* (blocks, orders, N_c, 2, lanes) */
    double *reaction;            /* the same shape: modal response on the contacts at t_A = 0 */
    double *squares[2];      /* (blocks, N_c, lanes): sum of x^2 over the steps of each half */
    double *half[2];         /* (points_per_group, orders, N_c, 2) harmonics of half a period */
    double *fresh;           /* the same shape: of the last whole period */
    double *last[2];         /* the same shape: of those that ended with each half before */
    double *stalled_sum;        /* the same shape: sum over the halves without progress */
    double *stalled_squares;    /* (points_per_group, N_c): likewise, of the mean squares */
    double *mean_squares;    /* (points_per_group, N_c) over the last period */
    double *response;        /* (points_per_group, orders, N_c, 2): R, see march.h */
    double *next_response;   /* (orders, N_c, 2) */
    double *forcing, *moved; /* (2 SM_TOGETHER, N_c, lanes), (SM_TOGETHER, N_c, lanes) */
    sm_progress *track;      /* (points_per_group) */
    sm_acceleration *faster; /* (points_per_group) */
    double *memory;
} sm_torus_group;

typedef struct {
    sm_torus_grid grid, coarse; /* the grid, and larger steps for the first halves */
    sm_torus_group group;
} sm_rigid_lines;

/* Takes its memory; release it also after a failure. */
sm_status sm_torus_group_make(sm_torus_group *group, const sm_torus_grid *grid);
void sm_torus_group_release(sm_torus_group *group);

/* Contacts at rest at the points of the march, with their amplitudes and without growth. */
void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *group, const sm_march *march);
/* Mean square of x_c over two of the last halves, or one of them twice, and all lines of point p of
 * the group, (N_c). */
void sm_torus_group_mean_square(const sm_torus_grid *grid, const sm_torus_group *group, size_t p,
                                int one, int other, double *mean_square);

/* The first or second half of a period of mode A under the response; the harmonics over this and the
 * half before are in `fresh`. */
sm_status sm_torus_group_half(const sm_torus_grid *grid, sm_torus_group *group, int half);
/* After a period, with the phases of the next: moves the displacements of point p to their limit if that
 * is due; returns whether it did. */
int sm_accelerate(const sm_torus_grid *grid, sm_torus_group *group, size_t p);

/* Whether relaxed responses may take too long to converge, or diverge. */
int sm_rigid_is_soft(const sm_march *march);
/* Solves all points of the task by half periods, each under a relaxed response to those before. */
sm_status sm_rigid_relax(sm_march *march);

#endif
