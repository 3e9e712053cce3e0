/* One implicit step with elastic contacts, I q'' + C q' + Lambda q + W f(W^T q) = p(t).
 *
 * With weights g and b of each mode (own, ahead) it goes from (q, v, a) to
 *   q_1 = q + b v + g v_1,   v_1 = v + b a + g a_1,   a_1 = p_1 - C v_1 - Lambda q_1 - W f(W^T q_1):
 * the trapezoidal rule (Newmark's average acceleration) where b = g, backward Euler where b = 0.
 * b + g is h of modes that follow statically; of those that move it is warped,
 * 2 / Omega tan(Omega h / 2), so that motion at Omega is exact (see coordinates.py). Work is done on
 * a mode as contacts do it, on any b = g: sliders take energy, whatever the step.
 *
 * As (1 / g + C + g Lambda) v_1 = (v + b a) / g + p_1 - Lambda (q + b v) - W f, the contacts come to
 * x_c = u_0 - D f(x_c), D = W^T g A^-1 W. About contacts that stick it is x_c - R y = (I - R k_ref) u_0
 * with y = k_ref x_c - f and R = D (I + k_ref D)^-1: what contact/elastic/solve.h solves.
 */
#ifndef SLIPMODE_ELASTIC_STEP_H
#define SLIPMODE_ELASTIC_STEP_H

#include "contact/elastic/solve.h"
#include "full/esdirk4.h"

typedef struct {
    size_t contacts, width, remembered;
    double static_closure;   /* largest of preloaded contacts [m] */
    double *own, *ahead;     /* (width) g, b */
    double *per_own;         /* (width) 1 / g */
    double *directions;      /* (N_c, width) W^T */
    double *gather;          /* (N_c, width) (I - R k_ref) W^T */
    double *u, *x_c, *v_c;   /* (N_c) of the solver; displacement, velocity of the contacts */
    double *memory;          /* before the step */
    sm_elastic_solver solver;
} sm_elastic_step;

void sm_elastic_step_place(sm_elastic_step *step, const sm_full *full, size_t width,
                           sm_block *block);
/* What does not change from step to step. */
void sm_elastic_step_set(sm_elastic_step *step, const sm_full *full);

/* The step that starts `elapsed` seconds after the inputs do; m->stage_dv has the acceleration. */
sm_status sm_elastic_step_take(sm_elastic_step *step, sm_esdirk4 *m, double elapsed);

/* v_c = W^T v */
void sm_elastic_step_velocity(sm_elastic_step *step, const double *v);

#endif
