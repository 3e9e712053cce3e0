/* The discretisation of the torus and the angles at its steps: what all groups of phase lines
 * share. */
#ifndef SLIPMODE_GRID_H
#define SLIPMODE_GRID_H

#include "contact/sdirk2.h"
#include "torus/phases.h"

typedef struct {
    const sm_contact *contact;
    int steps, lines, orders_count;
    int lanes, points_per_group; /* of a block; of a group, which is a block or more */
    size_t per_point;        /* doubles: orders, N_c, 2 */
    const int32_t *orders;
    double ratio;            /* omega_B / omega_A */
    sm_stepper stepper;
    /* at all steps, and SM_TOGETHER beyond: */
    double *carrier;         /* (steps, 2 stages, cos A, sin A, cos B', sin B'), B' from t_B0 */
    double *weight;          /* (steps, orders, 2): exp(-i (n + m ratio) t_A) / steps */
    double *phasor;          /* (steps, 2 stages, orders, 2): exp(i (n + m ratio) t_A) */
    const double *dynamic_stiffness;  /* (orders, N_c, N_c, 2): modal response; NULL without one */
    double *relaxation;      /* (orders) part of a change that the modes respond to at once */
    double *memory;
} sm_torus_grid;

/* Where in a period a stage is, in steps. */
static inline double sm_stage_place(size_t stage) {
    return (double)(stage / 2) + (stage % 2 == 0 ? SM_GAMMA : 1.0);
}

/* For so many points. Takes its memory; release it also after a failure. */
sm_status sm_torus_grid_make(sm_torus_grid *grid, const sm_contact *contact,
                             const sm_discretisation *fine, size_t points);
void sm_torus_grid_release(sm_torus_grid *grid);

#endif
