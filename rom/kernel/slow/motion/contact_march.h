/* Time integration of the contacts along a slow trajectory. */
#ifndef SLIPMODE_CONTACT_MARCH_H
#define SLIPMODE_CONTACT_MARCH_H

#include "slow/motion/forcing.h"
#include "contact/elastic/solve.h"
#include "contact/stage/solve.h"
#include "contact/tr_bdf2.h"

/* Step sizes of rigid contacts, each half the one before. */
#define SM_RIGID_LEVELS 4

/* State of the contacts and work arrays of one integration. */
typedef struct {
    sm_forcing forcing;
    sm_stepper stepper[SM_RIGID_LEVELS]; /* by step size, set when they are needed */
    sm_lanes lane;
    double *force; /* (N_c) friction force at the end of the last step */
    double *acceleration; /* (N_c) of rigid contacts: mean of the last step */
    double *inertia;      /* (N_c) of rigid contacts: M dv/dt at its end */
    double *before;       /* state of the rigid contacts at the start of the step */
    int level;            /* step size that lane is set for; -1: none */
    /* elastic contacts have these instead of stepper and lane: */
    sm_elastic_solver solver;
    double *flexibility;      /* (N_c, N_c) */
    double *u, *last_u, *x, *v; /* (N_c) */
    double *memory;           /* of the sliders */
} sm_march;

/* Takes the arrays of an integration with up to `orders` harmonics of the response of the modes. */
void sm_march_place(sm_march *march, const sm_contact *contact, int orders, sm_block *block);

/* Doubles of the state of the contacts: x_c, v_c, f_c; then accelerations and M dv/dt of rigid
 * contacts, or displacements that elastic contacts would have if they stuck, and the positions of
 * their sliders. */
size_t sm_march_state_count(const sm_contact *contact);
/* Starts from a state; NULL: at rest. */
void sm_march_start(sm_march *march, const sm_contact *contact, const double *state);
/* Writes the present state. */
void sm_march_read(const sm_march *march, const sm_contact *contact, double *state);

/* How far an integration resolves motion that is faster than its steps.
 *
 * SM_RESOLVED: steps in which the velocity of a rigid contact bends are halved, up to three times,
 * because a contact that begins to slip vibrates on its own stiffness; not if this vibration decays
 * before the end. SM_UNHALVED: no step is halved, so that the result is a smooth function of
 * amplitudes, angles and forces. SM_TO_BE_READ: resolved, and more closely in the last step; for
 * elastic contacts, whose velocities jump and are means over the last step, this step is divided. */
typedef enum {
    SM_RESOLVED,
    SM_UNHALVED,
    SM_TO_BE_READ
} sm_detail;

/* Integrates from `from` to `to` seconds after the start of the segment, with at least
 * steps_per_period steps per period of the faster carrier. */
sm_status sm_march_along(sm_march *march, const sm_contact *contact, const sm_segment *segment,
                         double from, double to, int steps_per_period, sm_detail detail);
#endif
