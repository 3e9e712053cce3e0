/* Time integration of the contacts along a slow trajectory, eq. (12). */
#ifndef SLIPMODE_CONTACT_MARCH_H
#define SLIPMODE_CONTACT_MARCH_H

#include "contact/elastic/solve.h"
#include "contact/stepper.h"
#include "slow/motion/forcing.h"
#include "slow/motion/march_steps.h"

/* State of the contacts and work arrays of one integration. */
typedef struct {
    sm_forcing forcing;
    sm_stepper stepper[SM_RIGID_LEVELS]; /* matrices by step size, computed when needed */
    sm_lanes lane;
    double *force; /* (N_c) friction force at the end of the last step */
    double *acceleration; /* (N_c) of rigid contacts: mean of the last step */
    double *before;       /* state of the rigid contacts at the start of the step */
    int level;            /* step size that lane is set for; -1: none */
    /* elastic contacts have these instead of stepper and lane: */
    sm_elastic_solver solver;
    double *flexibility;      /* (N_c, N_c) */
    double *u, *x, *v;        /* (N_c) */
    double *memory;           /* of the sliders */
} sm_march;

/* Places the arrays of an integration with up to `orders` harmonics of the response of the
 * modes. */
void sm_march_place(sm_march *march, const sm_contact *contact, int orders, sm_block *block);

/* Returns the number of doubles of the state: x_c, v_c, f_c; then accelerations and M dv/dt of
 * rigid contacts, or the memory of the laws of elastic contacts. */
size_t sm_march_state_count(const sm_contact *contact);
/* Starts from a state; NULL: at rest. */
void sm_march_start(sm_march *march, const sm_contact *contact, const double *state);
/* Writes the present state. */
void sm_march_read(const sm_march *march, const sm_contact *contact, double *state);

/* Integrates from `from` to `to` seconds after the start of the segment, with at least
 * steps_per_period steps per period of the faster carrier. */
sm_status sm_march_along(sm_march *march, const sm_contact *contact, const sm_segment *segment,
                         double from, double to, int steps_per_period, sm_detail detail);
#endif
