/* Corrections of sliders that stop or begin to slide between two time steps.
 *
 * A slider stops where its contact turns back, which is beyond the farthest step by a part of the
 * square of the step: the largest error of a time step. A parabola through three steps gives this
 * distance to third order. It goes through the displacements z of the contact without the
 * displacements by its own force deficit: z is smooth. torus/elastic/elastic_lines.c calls both functions. */
#ifndef SLIPMODE_REVERSAL_H
#define SLIPMODE_REVERSAL_H

#include "contact/elastic/solve.h"

typedef struct {
    const double *x;          /* (N_c) displacements at the middle one of three steps */
    const double *z[3];       /* (N_c) x less `compliance` y at each of them */
    const double *compliance; /* (N_c) R_ii if all contacts are sliders; 0 if some are frictional,
                                 whose y also depends on the normal displacement */
    double *now, *before;     /* (N_c) receive the error of y at the last and the middle step, for
                                 means over the steps; NULL: not wanted */
} sm_reversal;

/* Returns how far the parabola through three points rises above z[1], if this is the highest. */
double sm_rise(const double z[3]);

/* Moves the sliders in `memory`, at the last step, that turned back at the middle one. Friction in
 * two directions stays: its sliders change their direction and never stop. */
void sm_elastic_reverse(const sm_elastic *elastic, const sm_reversal *reversal, double *memory);

/* Adds to `now` (N_c) the error of means of y over a solved step, from displacements x (N_c) and
 * `memory`, in which sliders begin to slide. */
void sm_elastic_begin(const sm_elastic_solver *solver, const double *x, const double *memory,
                      double *now);

#endif
