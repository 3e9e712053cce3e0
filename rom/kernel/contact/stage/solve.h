/* Solutions of the stage problem S v + g(v) = r of sdirk2.h, and stages of time steps made of them.
 *
 * Lanes side by side (lanes.c) advance the contacts through periods in large steps, and begin at a
 * guess from r alone. One lane (one.c) follows a trajectory in small steps, and begins at the
 * solution before. Both are newton.h.
 */
#ifndef SLIPMODE_SOLVE_H
#define SLIPMODE_SOLVE_H

#include "contact/sdirk2.h"

/* Finds velocities m->v for the right-hand sides m->r; m->v is the initial guess. */
sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m);

/* Makes one stage of SDIRK2, 0 or 1: forcing in m->u; velocity into m->v. */
sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage);

/* Finds velocities m->v of one lane for m->r, from the velocities m->v of the solution before. Where
 * S changes and where a march begins, m->rows must be 0: the factor is not valid. */
sm_status sm_solve_one(const sm_stepper *s, sm_lanes *m);

/* Makes one stage of TR-BDF2, 0 or 1: forcing in m->u; velocity into m->v; M dv/dt in `inertia`, at
 * the step's start and then at its end. */
sm_status sm_stage_one(const sm_stepper *s, sm_lanes *m, double *inertia, int stage);

#endif
