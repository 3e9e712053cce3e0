/* The discretisation of the torus, eq. (13), for rigid contacts: matrices of a time step, angles at
 * all steps. All groups of phase lines share it; group.c and growth.c make it. */
#ifndef SLIPMODE_GRID_H
#define SLIPMODE_GRID_H

#include "contact/stepper.h"
#include "torus/phases.h"

typedef struct {
    const sm_contact *contact;
    int steps, lines, orders_count;
    int lanes;               /* of a block */
    int points_per_group;    /* a group is one block or more */
    size_t per_point;        /* doubles of harmonics (orders, N_c, 2) */
    const int32_t *orders;   /* (orders, 2) n, m */
    double ratio;            /* omega_B / omega_A */
    sm_stepper stepper;
    /* at all steps, and at SM_TOGETHER more: */
    double *carrier;         /* (steps, 2 stages, 4): exp(i t_A), exp(i (t_B - t_B0)) */
    double *weight;          /* (steps, orders, 2): exp(-i (n + m ratio) t_A) / steps */
    double *phasor;          /* (steps, 2 stages, orders, 2): exp(i (n + m ratio) t_A) */
    const double *dynamic_stiffness;  /* (orders, N_c, N_c, 2): modal response; NULL without one */
    double *relaxation;      /* (orders) relaxation factors of the iterations of the response */
    double *memory;          /* block of all arrays */
} sm_torus_grid;

/* Returns the time of a stage since the start of the period, in steps. */
static inline double sm_stage_place(size_t stage) {
    return (double)(stage / 2) + (stage % 2 == 0 ? SM_FIRST_END : 1.0);
}

/* Allocates and computes a grid for a number of points. The caller frees its memory, also after a
 * failure. */
sm_status sm_torus_grid_make(sm_torus_grid *grid, const sm_contact *contact,
                             const sm_discretisation *fine, size_t points);

#endif
