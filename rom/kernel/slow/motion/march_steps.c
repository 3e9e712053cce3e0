/* Choice of the time steps of contacts along a slow trajectory. See the header; called by
 * contact_march.c. */
#include "slow/motion/march_steps.h"

#include <math.h>

#include "base/check.h"
#include "base/exact_sum.h"

/* Divisions of the last step of elastic contacts: its short part is 2^-6 of the step. Elastic
 * contacts have no inertia, so that later steps do not depend on the motion between two steps. */
#define ELASTIC_HALVINGS 6
/* Steps below this part of the longest step allowed need fewer halvings [-]. */
#define SHORT_STEP 0.6
/* Steps of one integration: more would take hours. */
#define MAX_STEPS 1e10
/* Time constants after which a vibration has decayed, to exp(-5) = 0.7 %. */
#define DECAY_TIMES 5.0
/* Largest deviation of a velocity from a straight line in a step, relative to the largest velocity
 * without friction [-]: a step with a larger deviation is halved. */
#define CURVED 0.2

/* Returns the largest velocity of a rigid contact without friction and inertia [m/s]. */
static double free_velocity(const sm_contact *contact, const sm_segment *g) {
    const size_t n = (size_t)contact->contacts;
    double fastest = 0.0;
    for (size_t i = 0; i < n; i++) {
        double force_rate = 0.0;
        for (size_t j = 0; j < (size_t)contact->modes; j++) {
            const double *L = contact->coupling + 2 * (j * n + i), *a = g->amplitude_end + 2 * j;
            force_rate += 2.0 * g->frequency[j]
                          * sqrt((L[0] * L[0] + L[1] * L[1]) * (a[0] * a[0] + a[1] * a[1]));
        }
        fastest = fmax(fastest, force_rate / contact->stiffness[i * (n + 1)]);
    }
    return fastest;
}

/* Returns the time in which the slowest vibration of the rigid contacts decays, estimated from
 * the diagonals of M and D [s]; infinity without damping. Vibrations that decay need not be
 * resolved. */
static double decay_time(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    double longest = 0.0;
    for (size_t k = 0; k < n * n; k += n + 1) {
        const double mass = contact->mass ? contact->mass[k] : 0.0;
        longest = fmax(longest, mass > 0.0 ? 2.0 * mass / contact->damping[k] : INFINITY);
    }
    return DECAY_TIMES * longest;
}

sm_status sm_choose_steps(const sm_contact *contact, const sm_segment *segment,
                          int steps_per_period, sm_detail detail, sm_steps *steps) {
    const double from = steps->from, to = steps->to;
    double fastest = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const double end = segment->frequency[j] + segment->frequency_rate[j] * segment->duration;
        fastest = fmax(fastest, fmax(fabs(segment->frequency[j]), fabs(end)));
    }
    const double longest = SM_TWO_PI / (fastest * steps_per_period);
    /* a multiple of the longest step needs no further step, in spite of rounding */
    const double count = ceil((to - from) / longest * (1.0 - SM_ROUNDING_TOLERANCE));
    if (!(count <= MAX_STEPS)) return SM_BAD_ARGUMENT;
    const int elastic = contact->law == SM_ELASTIC;
    const int halvings = elastic ? ELASTIC_HALVINGS : SM_RIGID_LEVELS - 1;
    const int halved = detail == SM_TO_BE_READ || (!elastic && detail != SM_UNHALVED);
    *steps = (sm_steps){.from = from,
                        .to = to,
                        .h = (to - from) / fmax(count, 1.0),
                        .finest = halved ? halvings : 0,
                        .allowed = INFINITY,
                        .to_be_read = detail == SM_TO_BE_READ};
    while (steps->finest > 0
           && steps->h <= ldexp(SHORT_STEP * longest, steps->finest - halvings))
        steps->finest--;
    steps->whole = (int64_t)1 << steps->finest;
    steps->end = steps->whole * (int64_t)fmax(count, 1.0);
    if (steps->finest > 0 && !elastic) {
        steps->allowed = CURVED * free_velocity(contact, segment);
        const double before = 1.0 - decay_time(contact) / (to - from);
        steps->resolved = before > 0.0 ? (int64_t)(before * (double)steps->end) : 0;
    }
    return SM_OK;
}
