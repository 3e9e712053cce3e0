/* Time integration of the contacts along a slow trajectory, eq. (12). */
#ifndef SLIPMODE_CONTACT_MARCH_H
#define SLIPMODE_CONTACT_MARCH_H

#include "slow/motion/forcing.h"
#include "contact/elastic/solve.h"
#include "contact/stage/solve.h"
#include "contact/tr_bdf2.h"

/* Step sizes of rigid contacts, each half the one before: the shortest is an eighth. */
#define SM_RIGID_LEVELS 4

/* Fewest steps_per_period that resolve a carrier. */
#define SM_MIN_STEPS 4

/* State of the contacts and work arrays of one integration. */
typedef struct {
    sm_forcing forcing;
    sm_stepper stepper[SM_RIGID_LEVELS]; /* matrices by step size, computed when needed */
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

/* Places the arrays of an integration with up to `orders` harmonics of the response of the
 * modes. */
void sm_march_place(sm_march *march, const sm_contact *contact, int orders, sm_block *block);

/* Returns the number of doubles of the state: x_c, v_c, f_c; then accelerations and M dv/dt of
 * rigid contacts, or displacements of elastic contacts if all stuck, and the memory of their
 * laws. */
size_t sm_march_state_count(const sm_contact *contact);
/* Starts from a state; NULL: at rest. */
void sm_march_start(sm_march *march, const sm_contact *contact, const double *state);
/* Writes the present state. */
void sm_march_read(const sm_march *march, const sm_contact *contact, double *state);

/* Resolution of contact motion that is faster than the steps.
 *
 * SM_RESOLVED: a step is halved, up to three times, if the velocity of a rigid contact deviates
 * from a straight line, because a contact that begins to slip vibrates on the stiffness of the
 * structure; not if this vibration decays before the end. SM_UNHALVED: no step is halved, so that
 * the result is a smooth function of amplitudes, angles and forces. SM_TO_BE_READ: as SM_RESOLVED
 * with a smaller tolerance in the last step. The velocity of elastic contacts is a mean over a
 * step, so that the last one is divided into a long and a short step. */
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
