#ifndef SLIPMODE_CONTACT_MARCH_H
#define SLIPMODE_CONTACT_MARCH_H

#include "slow/motion/forcing.h"
#include "contact/elastic/solve.h"
#include "contact/stage/chebyshev.h"

/* Lengths of the steps of rigid contacts, each half the one before. */
#define SM_RIGID_LEVELS 4

/* Contacts marched along a slow trajectory: one lane. */
typedef struct {
    sm_forcing forcing;
    sm_stepper stepper[SM_RIGID_LEVELS]; /* as they were needed last */
    sm_lanes lane;
    sm_warm warm;
    sm_reaction reaction;
    double *force; /* (N_c) friction force at the end of the last step */
    double *acceleration; /* (N_c) of rigid contacts: mean of the last step */
    double *pull;         /* (N_c) of rigid contacts: M dv/dt at its end */
    double *before;       /* rigid contacts as the step found them */
    int level;            /* of the steps that lane and warm are set for; -1: of none */
    /* elastic contacts have these instead of stepper, lane and warm: */
    sm_elastic_solver solver;
    double *flexibility;      /* (N_c, N_c) */
    double *u, *last_u, *x, *v; /* (N_c) */
    double *memory;           /* of the sliders */
} sm_march;

/* With room for `orders` harmonics that act on the contacts. */
void sm_march_place(sm_march *march, const sm_contact *contact, int orders, sm_block *block);

/* The state that a march starts from and ends in: x_c, v_c, f_c; then accelerations and M dv/dt of
 * rigid contacts, or where elastic ones would be if they stuck and where their sliders are. */
size_t sm_march_state_count(const sm_contact *contact);
/* NULL: at rest. */
void sm_march_start(sm_march *march, const sm_contact *contact, const double *state);
void sm_march_read(const sm_march *march, const sm_contact *contact, double *state);

/* How far a march follows what is faster than its steps. */
typedef enum {
    SM_RESOLVED,  /* rigid contacts: steps in which a velocity bends are halved, up to three times,
                     for what is left of a contact's own vibration as it begins to slip; once where
                     that dies away before the end */
    SM_UNHALVED,  /* no step is halved: smoothly as amplitudes, angles and forces change */
    SM_TO_BE_READ /* resolved, and the last step, where a velocity bends at all; of elastic contacts it is
                     halved again and again towards its end, for their velocities have jumps and
                     are means of the last step */
} sm_detail;

/* From `from` to `to` seconds after the segment's start, in steps of at most one
 * steps_per_period-th of the faster carrier's period. */
sm_status sm_march_along(sm_march *march, const sm_contact *contact, const sm_segment *segment,
                         double from, double to, int steps_per_period, sm_detail detail);
#endif
