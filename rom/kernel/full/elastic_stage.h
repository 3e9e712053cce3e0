/* Elastic contacts at the stages of a time step, see esdirk4.h.
 *
 * A stage that starts from x and ends at velocity v takes the contacts to W^T (x + gamma h v), and
 * v = v_0 - A^-1 W f(x_c). With C = gamma h W^T A^-1 W this is x_c + C f(x_c) = W^T (x + gamma h v_0),
 * or, about contacts that stick, x_c - R y = (I - R k_ref) W^T (x + gamma h v_0) with
 * y = k_ref x_c - f and R = C (I + k_ref C)^-1: what contact/elastic/solve.h solves. All stages
 * remember what the contacts did up to the start of the step; the last one ends it.
 */
#ifndef SLIPMODE_ELASTIC_STAGE_H
#define SLIPMODE_ELASTIC_STAGE_H

#include "contact/elastic/solve.h"

#define SM_FULL_BLOCK \
    4 /* coordinates go in blocks of this many, the last one filled with zeros */

/* For each coordinate k, in blocks that the vectoriser takes whole. */
#define SM_EACH(k, width)                                           \
    for (size_t block = 0; block < (width); block += SM_FULL_BLOCK) \
        SM_SIMD for (size_t k = block; k < block + SM_FULL_BLOCK; k++)

typedef struct {
    size_t contacts, width, remembered;
    double static_closure;      /* largest of preloaded contacts [m] */
    double *directions;         /* (N_c, width) W^T */
    double *gather;             /* (N_c, width) (I - R k_ref) W^T */
    double *u, *x, *v;          /* (N_c) of the solver; displacement, velocity of the contacts */
    double *memory;             /* at the start of the step */
    sm_elastic_solver solver;
} sm_elastic_stage;

/* Doubles of its arrays. */
size_t sm_elastic_stage_size(const sm_elastic *elastic, int contacts, size_t width);
void sm_elastic_stage_place(sm_elastic_stage *stage, const sm_elastic *elastic, int contacts,
                            size_t width, const double *flexibility, double *memory);
/* Directions (N_c, n). */
void sm_elastic_stage_set(sm_elastic_stage *stage, const double *directions, size_t n);

/* From free velocities v (width) to those of the stage, `own` = gamma h; response is A^-1 W
 * (N_c, width). Leaves displacement and velocity of the contacts in x and v. */
sm_status sm_elastic_stage_solve(sm_elastic_stage *stage, double own, const double *base_q,
                                 const double *response, double *v);

/* The contacts remember what the last stage did. */
void sm_elastic_stage_commit(sm_elastic_stage *stage);

#endif
