/* A group of phase lines, eq. (13), of rigid contacts that are marched together in lanes. Made by
 * group.c for the search of periodic motion (periodic/search.c), and used by growth.c. */
#ifndef SLIPMODE_GROUP_H
#define SLIPMODE_GROUP_H

#include "torus/march.h"
#include "torus/phases.h"
#include "torus/rigid/grid.h"

/* Fourier coefficients over t_B of the displacements of a point, for the extrapolation in
 * acceleration.c. */
typedef struct {
    int recorded;             /* periods since the start or the last extrapolation, up to 2 */
    double *spectrum;         /* (coefficients, N_c, 2) at the end of the last period */
    double *change, *fresh;   /* the same shape: last change, present spectrum */
} sm_acceleration;

/* Returns the number of doubles of `spectrum`. */
static inline size_t sm_acceleration_size(size_t contacts, size_t lines) {
    return 2 * contacts * (lines < 2 ? 1 : lines / 2);
}

/* The phase lines of one point, or of several points if they fit into one block of lanes. */
typedef struct {
    int blocks;              /* blocks of lanes in the group */
    sm_lanes *lanes;         /* (blocks) contact states */
    double *a, *b;           /* (blocks * lanes) |a_A|, |a_B| of each lane at the period's start */
    double *a_step, *b_step; /* (blocks * lanes) growth of the amplitudes per step */
    sm_phases phases;        /* t_B at t_A = 0 in all lanes */
    double *sums;            /* (blocks, orders, N_c, 2, lanes) sums of x weight over the steps */
    double *reaction;        /* the same shape: modal forces on the contacts at t_A = 0 */
    double *squares;         /* (blocks, N_c, lanes): sum of x^2 over the steps */
    double *Y, *mean_square; /* (points_per_group, orders, N_c, 2), (points_per_group, N_c) */
    double *response;        /* (points_per_group, orders, N_c, 2): R, see march.h */
    double *forcing;         /* (2 SM_TOGETHER, N_c, lanes) modal forces at some stages */
    double *displacement;    /* (SM_TOGETHER, N_c, lanes) contact displacements after some steps */
    sm_acceleration *acceleration; /* (points_per_group) */
    double *memory;          /* block of all arrays */
} sm_torus_group;

/* The march of rigid contacts. */
typedef struct {
    sm_torus_grid grid, coarse; /* the grid; a grid with larger steps for the first half periods */
    sm_torus_group group;
    int half;                   /* 1: half periods, each one with the opposite sign of the last */
    int marched;                /* periods or half periods since the start */
} sm_rigid_lines;

/* Marches through a period or half a period of mode A under the response, on the coarse grid at
 * first: computes Y and the mean squares. After half a period Y has the harmonics of odd motion. */
sm_status sm_rigid_period(sm_march *march);
/* Records the displacements of point p after a period; the phases are at the start of the next one.
 * Extrapolates them to the limit if `wanted` and two changes are known; returns whether it did. */
int sm_accelerate(const sm_torus_grid *grid, sm_torus_group *group, size_t p, int wanted);

#endif
