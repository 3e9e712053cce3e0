/* Modes that are marched along the phase lines with the contacts; see sm_modal_response. */
#ifndef SLIPMODE_MARCHED_H
#define SLIPMODE_MARCHED_H

#include <stddef.h>

#include "slipmode.h"

typedef struct {
    const sm_modal_response *response; /* NULL: there are none */
    size_t modes, contacts, lines;
    double *state;   /* (lines, modes, 3): p, v, and the force g on it */
} sm_marched;

static inline size_t sm_marched_modes(const sm_modal_response *response) {
    return response ? (size_t)response->marched : 0;
}
static inline size_t sm_marched_size(const sm_modal_response *response, size_t lines) {
    return 3 * sm_marched_modes(response) * lines;
}
void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t lines, double *memory);
/* All at rest. */
void sm_marched_start(sm_marched *m);
/* u (N_c) += what the modes of a line do to the contacts in a step without its force. */
void sm_marched_displace(const sm_marched *m, size_t line, double *u);
/* To the end of the step, where the contacts have y (N_c). */
void sm_marched_advance(sm_marched *m, size_t line, const double *y);

#endif
