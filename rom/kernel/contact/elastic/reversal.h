/* Where sliders turn back, and begin to slide, between two steps.
 *
 * A slider that slid and now sticks has stopped where its contact was farthest, which is beyond
 * the farthest of its steps by a part of the step's square. That is what steps lose most by: a
 * parabola tells it but for the cube. It goes through the last three places where the structure
 * would have taken the contact without its sliders: they give way as soon as it slides, which bends
 * the way of the contact itself. */
#ifndef SLIPMODE_REVERSAL_H
#define SLIPMODE_REVERSAL_H

#include "contact/elastic/solve.h"

typedef struct {
    const double *x;      /* (N_c) displacements at the middle one of three steps */
    const double *z[3];   /* (N_c) at each of them: x without what contacts give way */
    const double *gives;  /* (N_c) how far they do per y: R_ii where all contacts are sliders; 0
                             where some are frictional, whose y is also by what presses them */
    double *now, *before; /* (N_c) are added to: what y misses at the last step and at the middle
                             one, for its means over steps to be as exact; or NULL: to nothing */
} sm_reversal;

/* Moves the sliders that turned back at the middle step, the last one being where `memory` is.
 * Friction in two directions is left as it is: there the direction turns, and the slider never
 * stops. */
void sm_elastic_reverse(const sm_elastic *elastic, const sm_reversal *reversal, double *memory);

/* Adds to `now` (N_c) what y misses at the end of a step that was solved, from displacements x (N_c)
 * and `memory`, of sliders that begin to slide in it. */
void sm_elastic_begin(const sm_elastic_solver *solver, const double *x, const double *memory,
                      double *now);

#endif
