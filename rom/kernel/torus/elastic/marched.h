/* Modes that are integrated along the phase lines with the contacts, and the response of all other
 * modes to harmonics; see sm_modal_response. */
#ifndef SLIPMODE_MARCHED_H
#define SLIPMODE_MARCHED_H

#include <stddef.h>

#include "slipmode.h"
#include "torus/elastic/phase_lines.h"

typedef struct {
    const sm_modal_response *response; /* NULL: there are none */
    size_t modes, contacts;
    size_t stride;   /* lines, and lanes that only fill vectors up */
    double *state;   /* (modes, 3, stride): p, v, and the force g on it */
} sm_marched;

static inline size_t sm_marched_modes(const sm_modal_response *response) {
    return response ? (size_t)response->marched : 0;
}
static inline size_t sm_marched_size(const sm_modal_response *response, size_t stride) {
    return 3 * sm_marched_modes(response) * stride;
}
void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t stride, sm_block *block);
/* All at rest. */
void sm_marched_start(sm_marched *m);
/* As they move in the end where the contacts have the harmonics Y (orders, N_c, 2). */
void sm_marched_begin(sm_marched *m, const sm_phase_lines *lines, const double *Y);
/* u (N_c, stride) += what the modes do to the contacts in a step without its force. */
void sm_marched_displace(const sm_marched *m, double *u);
/* To the end of the step, where the contacts have y (N_c, stride). */
void sm_marched_advance(sm_marched *m, const double *y);

#endif
