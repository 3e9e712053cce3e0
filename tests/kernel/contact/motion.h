/* All arguments of sm_contact_motion: amplitudes that change in straight lines over two segments,
 * and frequencies that sweep. */
#ifndef TEST_MOTION_H
#define TEST_MOTION_H

#include "fixtures.h"

#define SAMPLES 57
#define SEGMENTS 2

typedef struct {
    const sm_contact *contact;
    size_t segments, samples;
    sm_segment two[SEGMENTS], *segment;
    double *start_x, *times, *x, *v, *f;
    int32_t steps_per_period;
} motion_call;

/* Segments from 3 to 31 s; as many samples, evenly spaced. `c` must stay where it is. */
void new_motion(motion_call *c, const sm_contact *contact, size_t samples);
sm_status march(void *c);
/* -2 Re(L_j a_j exp(i theta_j)) summed over the modes, straight from the definition. */
double forcing(const motion_call *c, int i, double time);

#endif
