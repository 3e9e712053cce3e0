#ifndef SLIPMODE_CONTACT_MOTION_H
#define SLIPMODE_CONTACT_MOTION_H

#include "slow/motion/reaction.h"
#include "contact/stage/warm_chebyshev.h"

/* Contacts marched along a slow trajectory: one lane. */
typedef struct {
    sm_stepper stepper;
    sm_lanes lane;
    sm_warm warm;
    sm_reaction reaction;
    double *force; /* (N_c) friction force at the end of the last step */
} sm_march;

/* With room for `orders` harmonics that act on the contacts. */
size_t sm_march_size(int contacts, int orders); /* doubles */
void sm_march_place(sm_march *march, int contacts, int orders, double *memory);
/* Start from displacement x, velocity v and friction force f (any of them NULL: zero). */
void sm_march_start(sm_march *march, const double *x, const double *v, const double *f);
/* From `from` to `to` seconds after the segment's start, in equal steps of at most one
 * steps_per_period-th of the faster carrier's period. */
sm_status sm_march_along(sm_march *march, const sm_contact *contact, const sm_segment *segment,
                         double from, double to, int steps_per_period);
#endif
