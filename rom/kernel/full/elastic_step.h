/* One implicit step with elastic contacts, I q'' + C q' + Lambda q + W f(W^T q) = p(t).
 *
 * With weights g and b of each mode (own, ahead) the step goes from (q, v, a) to
 *   q_1 = q + b v + g v_1,   v_1 = v + b a + g a_1,
 *   a_1 = p_1 - C v_1 - Lambda q_1 - W f(W^T q_1):
 * the trapezoidal rule (Newmark's average acceleration) if b = g, backward Euler if b = 0. For
 * modes that move, b + g = 2 / Omega tan(Omega h / 2) makes motion at Omega exact (coordinates.py);
 * for modes that follow statically b + g = h. Any b = g transfers the work of the contacts exactly:
 * sliders dissipate energy at every step size.
 *
 * As A v_1 = (v + b a) / g + p_1 - Lambda (q + b v) - W f, A = 1 / g + C + g Lambda, the contacts
 * are at x_c = u_0 - D f(x_c), D = W^T g A^-1 W. Relative to sticking contacts this is
 * x_c - R y = (I - R k_ref) u_0 with R = D (I + k_ref D)^-1, as in contact/elastic/solve.h.
 * full.c makes the steps, in the arrays of esdirk4.h.
 */
#ifndef SLIPMODE_ELASTIC_STEP_H
#define SLIPMODE_ELASTIC_STEP_H

#include "contact/elastic/solve.h"
#include "full/esdirk4.h"

typedef struct {
    size_t contacts, width, remembered;
    double *own, *ahead;     /* (width) g, b */
    double *directions;      /* (N_c, width) W^T */
    double *gather;          /* (N_c, width) (I - R k_ref) W^T */
    double *u, *x_c, *v_c;   /* (N_c) of the solver; displacement, velocity of the contacts */
    double *memory;          /* before the step */
    sm_elastic_solver solver;
} sm_elastic_step;

/* Takes the arrays from a block, or counts them. */
void sm_elastic_step_place(sm_elastic_step *step, const sm_full *full, size_t width,
                           sm_block *block);
/* Sets the arrays that are constant in time. */
void sm_elastic_step_set(sm_elastic_step *step, const sm_full *full);

/* Makes the step that starts `elapsed` seconds after the inputs do; m->stage_dv has the
 * acceleration. */
sm_status sm_elastic_step_take(sm_elastic_step *step, sm_esdirk4 *m, double elapsed);

/* Sets v_c = W^T v. */
void sm_elastic_step_velocity(sm_elastic_step *step, const double *v);

#endif
