/* The stage problem S v + g(v) = r in SM_FEW_LANES or SM_LANES lanes, and the stage of a time step.
 *
 * Under tanh friction: with the others moving as they are thought to, a contact has a solution
 * whose shape is known, it sticks, slides, or is in the knee between. From there two or three steps
 * of Chebyshev's cubic iteration on the coupled problem end far below the error of the time steps,
 * at one tanh a contact and step. Where they do not, and under Coulomb friction, Newton's method
 * takes over.
 */
#ifndef SLIPMODE_CHEBYSHEV_H
#define SLIPMODE_CHEBYSHEV_H

#include "contact/sdirk2.h"

/* Velocities m->v for the right-hand sides m->r; a first guess is in m->v. */
sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m);

/* One stage, 0 or 1: forcing in m->u; velocity into m->v. */
sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage);

#endif
