/* The stage problem S v + g(v) = r in SM_FEW_LANES or SM_LANES lanes, and the stage of a time step.
 *
 * Under tanh friction, a contact has a solution of known shape if the velocities of the others are
 * given: it sticks, slides, or is in the knee between. From this guess two or three steps of
 * Chebyshev's cubic iteration on the coupled problem end far below the error of the time steps, at
 * one tanh for each contact and step. If they do not, Newton's method takes over, as for Coulomb
 * friction.
 */
#ifndef SLIPMODE_CHEBYSHEV_H
#define SLIPMODE_CHEBYSHEV_H

#include "contact/sdirk2.h"
#include "contact/tr_bdf2.h"

/* Finds velocities m->v for the right-hand sides m->r from an initial guess in m->v. */
sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m);

/* One stage, 0 or 1: forcing in m->u; velocity into m->v. */
sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage);

/* The stage problem S v + g(v) = r of one lane, where successive right-hand sides lie close together.
 *
 * Tanh friction is smooth, so a step of Chebyshev's cubic iteration with the Newton matrix
 * J = S + diag g'(v) of the last solution predicts the next one, and one or two more with its own J
 * end far below the error of the time steps. That takes half the time of the iteration above for one
 * lane. If it does not converge (a contact passing from stick to slip within a step, exact Coulomb
 * friction), Newton's method takes over.
 */

#define SM_WARM_TOLERANCE 1e-9 /* of v / alpha: far below what the time steps leave */

typedef struct {
    double per_alpha;      /* 1 / alpha, 0 for exact Coulomb friction */
    double tolerance;      /* SM_WARM_TOLERANCE from the start on */
    double *v, *r;         /* the last solution and its right-hand side */
    double *factor;        /* (N_c, N_c) of J: unit lower triangle, inverse pivots */
    double *next;          /* v under iteration */
    double *delta, *bend;  /* residual, then Newton's step; its correction by curvature */
    double *tanh, *sech2;  /* of v / alpha */
} sm_warm;

void sm_warm_place(sm_warm *warm, int contacts, sm_block *block);
/* Starts at velocities v under friction forces g(v). */
void sm_warm_start(const sm_stepper *s, sm_warm *warm, const double *v, const double *force);
/* Continues after a change of S alone. */
void sm_warm_resume(const sm_stepper *s, sm_warm *warm, const double *force);
/* Finds warm->v for the right-hand side lane->r. */
sm_status sm_warm_solve(const sm_stepper *s, sm_warm *warm, sm_lanes *lane);

/* One stage of TR-BDF2, 0 or 1: forcing in lane->u; velocity into lane->v; M dv/dt in `pull`, at the
 * step's start and then at its end. */
sm_status sm_stage_one(const sm_stepper *s, sm_warm *warm, sm_lanes *lane, double *pull, int stage);

#endif
