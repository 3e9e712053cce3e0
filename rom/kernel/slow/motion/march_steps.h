/* The time steps of contacts along a slow trajectory: parts of a carrier period, which may be halved
 * while a rigid contact vibrates. contact_march.c makes them. */
#ifndef SLIPMODE_MARCH_STEPS_H
#define SLIPMODE_MARCH_STEPS_H

#include "base/lanes.h"
#include "slipmode.h"

/* Step sizes of rigid contacts, each half the one before: the shortest is an eighth. */
#define SM_RIGID_LEVELS 4

/* Fewest steps_per_period that resolve a carrier. */
#define SM_MIN_STEPS 4

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

/* The steps of an integration: they have h 2^-level seconds. Times are integers in units of the
 * shortest step. */
typedef struct {
    double from, to, h; /* [s] */
    int finest;         /* level of the shortest step */
    int64_t whole, end; /* duration of a step of level 0, and of the integration */
    int64_t resolved;   /* time from which on vibrations do not decay before the end */
    double allowed;     /* deviation of a velocity from a straight line [m/s]; infinity: any */
    int to_be_read;     /* 1: the motion at the end is read */
} sm_steps;

/* Chooses the steps between steps->from and steps->to. */
sm_status sm_choose_steps(const sm_contact *contact, const sm_segment *segment,
                          int steps_per_period, sm_detail detail, sm_steps *steps);

/* Returns the level of the next step, at least `level`: steps of a level begin at multiples of
 * their duration. */
SM_INLINE int sm_next_level(const sm_steps *steps, int level, int64_t at) {
    while (level < steps->finest && (at & ((steps->whole >> level) - 1)) != 0) level++;
    return level;
}

#endif
