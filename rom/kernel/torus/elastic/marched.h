/* Modes that are integrated in time with the contacts, along the phase lines of a point.
 *
 * Mode k moves under the force g_k = projection_k y, linear in time over a step: (p, v) at its end
 * follow from (p, v, g) at its start and g at its end by `advance`; see sm_modal_response.
 * elastic_lines.c calls these functions in each step. */
#ifndef SLIPMODE_MARCHED_H
#define SLIPMODE_MARCHED_H

#include <stddef.h>

#include "slipmode.h"
#include "torus/elastic/phase_lines.h"

typedef struct {
    const sm_modal_response *response; /* NULL: there are none */
    size_t modes, contacts;
    size_t stride;   /* lines, rounded up to whole vectors */
    double *state;   /* (modes, 3, stride): p, v, and the force g on it */
} sm_marched;

/* Returns the number of integrated modes. */
static inline size_t sm_marched_modes(const sm_modal_response *response) {
    return response ? (size_t)response->marched : 0;
}
/* Returns the doubles of their state. */
static inline size_t sm_marched_size(const sm_modal_response *response, size_t stride) {
    return 3 * sm_marched_modes(response) * stride;
}
/* Takes the state from a block, or counts it. */
void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t stride, sm_block *block);
/* Sets all modes at rest. */
void sm_marched_start(sm_marched *m);
/* Sets the periodic motion of the modes under harmonics Y (orders, N_c, 2) of y, at t = 0. */
void sm_marched_begin(sm_marched *m, const sm_phase_lines *lines, const double *Y);
/* Adds to u (N_c, stride) the displacement by the modes at the end of a step, without its force. */
void sm_marched_displace(const sm_marched *m, double *u);
/* Advances the modes to the end of the step, where the force deficit is y (N_c, stride). */
void sm_marched_advance(sm_marched *m, const double *y);
/* Returns the displacement of contact i per constant force deficit of contact j, without the
 * flexibility within a step [m/N]. */
double sm_marched_flexibility(const sm_marched *m, size_t i, size_t j);
/* Moves the modes on line p as far as a constant force deficit `y` of contact i moves them. */
void sm_marched_shift(sm_marched *m, size_t p, size_t i, double y);

#endif
