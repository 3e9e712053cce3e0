/* A group of phase lines that are marched together in lanes. */
#ifndef SLIPMODE_GROUP_H
#define SLIPMODE_GROUP_H

#include "torus/march.h"
#include "torus/phases.h"
#include "torus/rigid/grid.h"

/* Of one point, see acceleration.c. */
typedef struct {
    int recorded;             /* periods since the start or the last extrapolation, up to 2 */
    double *spectrum;         /* (coefficients, N_c, 2) at the end of the last period */
    double *change, *fresh;   /* the same shape: last change, present spectrum */
} sm_acceleration;

/* Doubles of each of these arrays. */
static inline size_t sm_acceleration_size(size_t contacts, size_t lines) {
    return 2 * contacts * (lines < 2 ? 1 : lines / 2);
}

/* The lanes of one point, or of several points when it has fewer lines than a block lanes. */
typedef struct {
    int blocks;              /* lanes of the group / those of a block */
    sm_lanes *lanes;         /* (blocks) */
    double *a, *b;           /* (blocks * lanes) amplitudes of each lane as the period starts */
    double *a_step, *b_step; /* the same shape: what they grow by in a step */
    sm_phases phases;        /* t_B at t_A = 0 in all lanes */
    double *sums;            /* (blocks, orders, N_c, 2, lanes) */
    double *reaction;            /* the same shape: modal response on the contacts at t_A = 0 */
    double *squares;         /* (blocks, N_c, lanes): sum of x^2 over the steps */
    double *Y, *mean_square; /* (points_per_group, orders, N_c, 2), (points_per_group, N_c) */
    double *response;        /* (points_per_group, orders, N_c, 2): R, see march.h */
    double *forcing, *moved; /* (2 SM_TOGETHER, N_c, lanes), (SM_TOGETHER, N_c, lanes) */
    sm_acceleration *faster; /* (points_per_group) */
    double *memory;
} sm_torus_group;

typedef struct {
    sm_torus_grid grid, coarse; /* the grid, and larger steps for the first halves */
    sm_torus_group group;
    int half;                   /* half periods are marched: the next one has the opposite sign */
    int marched;                /* of these, since the start */
} sm_rigid_lines;

/* Takes its memory; release it also after a failure. */
sm_status sm_torus_group_make(sm_torus_group *group, const sm_torus_grid *grid);
void sm_torus_group_release(sm_torus_group *group);

/* So many steps from the start of a period of mode A, under the response: Y and mean squares over
 * them. Where these are half a period, Y is that of odd motion. */
sm_status sm_torus_group_march(const sm_torus_grid *grid, sm_torus_group *group, int steps);
/* After a period, with the phases of the next: records the displacements of point p; moves them to
 * their limit if that is wanted and enough is known, and returns whether it did. */
int sm_accelerate(const sm_torus_grid *grid, sm_torus_group *group, size_t p, int wanted);

#endif
