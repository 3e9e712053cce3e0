/* One implicit step of the contact problem, eq. (12): [M x'' +] D x' + K x + g(x') = u(t).
 *
 * Its two stages end at t + 2 gamma h and at t + h (stage/tr_bdf2.h). Each one is the problem
 *   S v + g(v) = r,   S = [M / (gamma h) +] D + gamma h K,
 * the minimum of a strictly convex potential, which stage/newton.h finds. Contacts on the torus
 * (torus/rigid/) make steps in lanes side by side, contacts along a trajectory (slow/motion/) in
 * one lane. Full order (full/esdirk4.h) has the same problem in the stages of another method.
 */
#ifndef SLIPMODE_STEPPER_H
#define SLIPMODE_STEPPER_H

#include "base/block.h"
#include "contact/friction.h"

#define SM_GAMMA 0.29289321881345254     /* 1 - 1/sqrt 2 */
#define SM_FIRST_END (2.0 * SM_GAMMA)    /* end of the first stage, in steps */
#define SM_BDF_WEIGHT 0.35355339059327376 /* sqrt 2 / 4: of the first two velocities in a step */
#define SM_STAGE_TOLERANCE 1e-11 /* of the forces on the contact */
#define SM_SMOOTH_TOLERANCE 1e-12 /* of the friction limits, for rounding alone */
/* Tolerance of stages whose force is read, of the friction limits [-]: far below the error of the time
 * steps, also if the matrix S multiplies the error of v in the force. */
#define SM_READ_TOLERANCE 1e-10

typedef struct {
    int contacts;
    double h;            /* step [s] */
    double *matrix;      /* (N_c, N_c) S */
    double *stiffness;   /* (N_c, N_c) K */
    double *inertia;     /* (N_c, N_c) M / (gamma h) */
    int massless;
    int sticks;          /* Coulomb friction, which has a jump at zero velocity */
    double tolerance;    /* of the residual of tanh friction, in friction limits */
    double *factor;      /* (N_c, N_c) of S, for the check that it is positive definite */
    sm_resolvent *laws;  /* (N_c) */
} sm_stepper;

/* State of the contacts in lanes, and work arrays of their steps. */
typedef struct {
    int lanes;
    size_t size;         /* doubles from x on: all of them */
    double *x, *base;    /* displacement; displacement of a stage without its own velocity */
    double *u;           /* forcing of the stage */
    double *v;           /* velocity */
    double *g, *slope;   /* friction and dg/dv, infinite where a contact sticks */
    double *stage_v[2];  /* velocity of the first stage; at the start of the step, then at its end */
    double *inertia;     /* M dv/dt at the start of the step, then at its end */
    double *r, *residual; /* right-hand side of the stage, r - S v - g */
    double *step, *before; /* last Newton step, velocity before it */
    double *factor;      /* (N_c, N_c) per lane, of S + diag slope */
    double *last_r;      /* of one lane: right-hand side of the stage before */
    int rows;            /* of one lane: rows of the factor that are valid */
} sm_lanes;

void sm_stepper_place(sm_stepper *stepper, int contacts, sm_block *block);
/* SM_BAD_ARGUMENT unless S is positive definite: the step would have no unique solution. Its
 * tolerance is SM_SMOOTH_TOLERANCE. */
sm_status sm_stepper_set(sm_stepper *stepper, const sm_contact *contact, double h);
void sm_lanes_place(sm_lanes *lane, int contacts, int lanes, sm_block *block);

/* Makes one stage of a step of one lane, 0 or 1, under the forcing m->u: sets m->v, after stage 1
 * also m->x. Where S changes and where a march begins, m->rows must be 0: the factor is not valid. */
sm_status sm_stage_one(const sm_stepper *stepper, sm_lanes *m, int stage);
/* Finds velocities m->v of one lane for m->r, from the velocities m->v of the solution before. */
sm_status sm_solve_one(const sm_stepper *stepper, sm_lanes *m);

#endif
